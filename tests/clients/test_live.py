"""The live view: on a terminal of its own, through a break, another size, and to a clean end."""

import math
import sys
from typing import Any

import numpy as np
import pytest

from clients.ppi.__main__ import main
from clients.ppi.live import ENTER, LEAVE, screen
from clients.ppi.scope import Scope, half_blocks
from radar_service.display.picture import UNSEEN
from tests.clients import fake_feed
from tests.clients.fake_feed import TARGETS, Script, hello, picture, running

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="terminals of Windows are others")
GREETING = hello()


def batch(first: int, count: int, **options: Any) -> dict[str, Any]:
    return fake_feed.spokes(GREETING, picture(), first, count, **options)


def scope(*messages: dict[str, Any], **options: Any) -> Scope:
    made = Scope(**options)
    for message in messages:
        made.take(message)
    return made


@pytest.mark.parametrize("head_up", [False, True])
def test_targets_stand_where_they_belong(head_up: bool) -> None:
    size, image = 80, scope(GREETING, batch(0, 72, heading_deg=70.0), head_up=head_up).image(80)
    lit = image.astype(int).sum(axis=2) > 300
    for bearing_deg, there in TARGETS:
        angle, far = math.radians(bearing_deg - 70.0 * head_up), there / 2000.0 * size / 2
        y, x = size / 2 - far * math.cos(angle), size / 2 + far * math.sin(angle)
        i0, j0 = max(0, int(y) - 3), int(x) - 3
        assert lit[i0 : i0 + 7, j0 : j0 + 7].any()
        lit[i0 : i0 + 7, j0 : j0 + 7] = False
    assert not lit.any()  # rings and heading line are darker


def test_what_has_not_been_seen_is_grey_and_another_epoch_begins_dark() -> None:
    half = scope(GREETING, batch(0, 36))
    image = half.image(60)
    assert image[30, 10].tolist() == list(UNSEEN) and image[30, 50].tolist() != list(UNSEEN)
    half.take(hello("b", bins=50))
    assert (half.image(60)[25:35, 50] == UNSEEN).all()
    assert not Scope().image(10).any() and Scope().caption == "no radar yet"


def test_half_blocks_hold_two_pixels_each() -> None:
    image = np.arange(5 * 3 * 3, dtype=np.uint8).reshape(5, 3, 3)
    lines = half_blocks(image)
    assert len(lines) == 3 and lines[0].startswith("\x1b[38;2;0;1;2;48;2;9;10;11m\u2580\x1b[38;2;3;4;5;")
    assert lines[2].endswith("\x1b[38;2;42;43;44;48;2;0;0;0m\u2580\x1b[0m")
    assert half_blocks(np.zeros((2, 9, 3), np.uint8)) == ["\x1b[38;2;0;0;0;48;2;0;0;0m" + "\u2580" * 9 + "\x1b[0m"]


def test_a_radar_cannot_command_the_terminal() -> None:
    evil = hello() | {"scene": {"name": "\x1b]0;mine\x07\x9b2J"}}
    written = screen(scope(evil, batch(0, 5)), "told \x1b[2J", 60, 20)
    assert "?]0;mine??2J" in written and "told ?[2J" in written
    assert written.count("\x1b]") == 0 and "\x07" not in written and "\x9b" not in written


def test_without_a_terminal_it_says_what_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ws://127.0.0.1:1", "--live"]) == 1
    assert "use --out FILE" in capsys.readouterr().err


def test_live_comes_back_fits_every_window_and_ends_at_q() -> None:
    from tests.clients.terminal import Terminal

    scripts = (Script([GREETING, batch(0, 40)], code=1011), Script([GREETING, batch(40, 32)], wait=True))
    with running(*scripts) as feed:
        terminal = Terminal("clients.ppi", feed.url, "--live")
        try:
            terminal.until(lambda: b"0 lost; the radar ended the feed" in terminal.written)
            terminal.until(lambda: terminal.screen().text(19).startswith("q ends; 72 spokes came, 0 lost; back after 0."))
            assert terminal.screen().text(0).startswith("test scene, test radar: range 2 km, rings 500 m, north up")
            wide = terminal.screen().pixels()
            assert wide[2:38, 12:48].any(axis=(1, 2)).all() and not wide[:, :11].any() and not wide[:, 49:].any()
            assert (wide.astype(int).sum(axis=2) > 300).sum() >= 3  # the targets
            terminal.resize(30, 40)
            terminal.until(lambda: terminal.screen().text(16).startswith("q ends; 72 spokes came"))
            assert terminal.screen().pixels()[2:32].any(axis=(1, 2)).all()
            terminal.resize(10, 5)
            terminal.until(lambda: terminal.screen().text(0) == "at least 2")
            terminal.type(b"q")
            assert terminal.ended() == 0 and terminal.is_as_before()
        finally:
            terminal.close()
        assert [query.get("since") for query in feed.queries] == [None, "a:40"]
        assert feed.queries[0]["bins"] == "512"
    written = terminal.written.decode()
    assert written.startswith(ENTER) and written.count(LEAVE) == 1
    assert "in all: 72 spokes came, 0 announced as lost, 0 lost without a word" in written.partition(LEAVE)[2]


@pytest.mark.parametrize(
    ("script", "keys", "status", "said"),
    [
        (Script([GREETING, batch(0, 40)], wait=True), b"\x03", 0, "in all: 40 spokes came"),
        (Script([GREETING, batch(0, 40)], code=4400), b"", 1, "the radar refused"),
    ],
)
def test_live_leaves_the_terminal_as_it_was(script: Script, keys: bytes, status: int, said: str) -> None:
    from tests.clients.terminal import Terminal

    with running(script) as feed:
        terminal = Terminal("clients.ppi", feed.url, "--live")
        try:
            if keys:
                terminal.until(lambda: b"40 spokes came" in terminal.written)
                terminal.type(keys)
            assert terminal.ended() == status and terminal.is_as_before()
        finally:
            terminal.close()
    after = terminal.written.decode().partition(LEAVE)[2]
    assert said in after and "Traceback" not in after and "\x1b" not in after


@pytest.mark.parametrize("controlling", [True, False])
def test_live_ends_when_its_terminal_is_gone(controlling: bool) -> None:
    from tests.clients.terminal import PATIENCE, Terminal

    with running(Script([GREETING, batch(0, 40)], wait=True)) as feed:
        terminal = Terminal("clients.ppi", feed.url, "--live", controlling=controlling)
        try:
            terminal.until(lambda: b"40 spokes came" in terminal.written)
            terminal.vanish()
            assert terminal.process.wait(PATIENCE) in (0, 1)
        finally:
            terminal.close()
