"""The live view runs on a terminal, survives a break and a change of size, and leaves the terminal as it was."""

import sys

import pytest

from clients.ppi.__main__ import main
from clients.ppi.live import ENTER, LEAVE, screen
from tests.clients.fake_feed import GREETING, Script, batch, hello, ppi_of, running

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="terminals of Windows are others")


def test_text_from_a_radar_cannot_command_the_terminal() -> None:
    hostile = hello() | {"scene": {"name": "\x1b]0;mine\x07\x9b2J"}}
    written = screen(ppi_of(hostile, batch(0, 5)), "notice \x1b[2J", 60, 20)
    assert "?]0;mine??2J" in written and "notice ?[2J" in written
    assert written.count("\x1b]") == 0 and "\x07" not in written and "\x9b" not in written


def test_live_without_a_terminal_names_the_remedy(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ws://127.0.0.1:1", "--live"]) == 1
    assert "use --out FILE" in capsys.readouterr().err


def test_live_reconnects_fits_every_window_and_ends_at_q() -> None:
    from tests.clients.terminal import Terminal

    scripts = (Script([GREETING, batch(0, 40)], code=1011), Script([GREETING, batch(40, 32)], wait=True))
    with running(*scripts) as feed:
        terminal = Terminal("clients.ppi", feed.url, "--live")
        try:
            terminal.until(lambda: b"0 lost; the radar ended the feed" in terminal.written)
            terminal.until(lambda: terminal.screen().text(19).startswith("q ends; 72 spokes received, 0 lost; back after "))
            assert terminal.screen().text(0).startswith("test scene, test radar: range 1.08 NM, rings 0.25 NM, north")
            wide = terminal.screen().pixels()
            assert wide[2:38, 12:48].any(axis=(1, 2)).all() and not wide[:, :11].any() and not wide[:, 49:].any()
            assert (wide.astype(int).sum(axis=2) > 300).sum() >= 3  # the targets
            terminal.resize(30, 40)
            terminal.until(lambda: terminal.screen().text(16).startswith("q ends; 72 spokes received"))
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
    assert "in all: 72 spokes received, 0 lost and announced, 0 lost and not announced" in written.partition(LEAVE)[2]


@pytest.mark.parametrize(
    ("script", "keys", "status", "text"),
    [
        (Script([GREETING, batch(0, 40)], wait=True), b"\x03", 0, "in all: 40 spokes received"),
        (Script([GREETING, batch(0, 40)], code=4400), b"", 1, "the radar refused"),
    ],
)
def test_live_leaves_the_terminal_as_it_was(script: Script, keys: bytes, status: int, text: str) -> None:
    from tests.clients.terminal import Terminal

    with running(script) as feed:
        terminal = Terminal("clients.ppi", feed.url, "--live")
        try:
            if keys:
                terminal.until(lambda: b"40 spokes received" in terminal.written)
                terminal.type(keys)
            assert terminal.ended() == status and terminal.is_as_before()
        finally:
            terminal.close()
    after = terminal.written.decode().partition(LEAVE)[2]
    assert text in after and "Traceback" not in after and "\x1b" not in after


@pytest.mark.parametrize("controlling", [True, False])
def test_live_ends_when_its_terminal_is_gone(controlling: bool) -> None:
    from tests.clients.terminal import PATIENCE, Terminal

    with running(Script([GREETING, batch(0, 40)], wait=True)) as feed:
        terminal = Terminal("clients.ppi", feed.url, "--live", controlling=controlling)
        try:
            terminal.until(lambda: b"40 spokes received" in terminal.written)
            terminal.vanish()
            assert terminal.process.wait(PATIENCE) in (0, 1)
        finally:
            terminal.close()
