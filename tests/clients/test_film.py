"""Scans become films: the beam goes round, echoes fade, a second of film is a second of simulation."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from clients.ppi import FeedError, ReceivedScan, ScanCollector
from clients.ppi.__main__ import main
from clients.ppi.film import AFTERGLOW, film
from tests.clients import fake_feed
from tests.clients.fake_feed import Script, gap, hello, picture, running

AZIMUTHS, RATE = 72, 30.0  # spokes of a scan, spokes a second


def scans(messages: list[dict[str, Any]]) -> list[ReceivedScan]:
    collector = ScanCollector()
    for message in messages:
        collector.take(message)
    return list(collector.scans)


def test_frames_follow_the_beam_and_fade() -> None:
    greeting, data = hello(), np.full((AZIMUTHS, 100), 200, dtype=np.uint8)
    two = scans([greeting, *(fake_feed.spokes(greeting, data, first, 18, 40.0) for first in range(18, 162, 18))])
    frames = list(film(two, fps=10))
    assert len(frames) == 48  # 143 spokes after the first at 30 a second are 4.77 s
    for frame in frames:
        newest = int(np.floor(frame.time * RATE + 1e-5))  # as many spokes off, at most, as rounding makes
        last = newest - (newest - np.arange(AZIMUTHS)) % AZIMUTHS  # the newest spoke of each row
        np.testing.assert_array_equal(frame.filled, last >= 18)
        age = (frame.time * RATE - last) / AZIMUTHS  # revolutions
        expected = np.where(last >= 18, 200 * (1 - (1 - AFTERGLOW) * np.minimum(age, 1.0)), 0.0)
        assert np.abs(frame.picture - expected[:, None]).max() <= 0.5 + 1e-4  # rounding to whole numbers, and float32
        assert frame.heading == pytest.approx(np.radians(40.0), abs=4.8e-5)  # half of 1/65536 turn
    assert frames[-1].time == 161 / RATE and frames[-1].filled.all()


def test_what_did_not_come_stays_undrawn() -> None:
    greeting, data = hello(), picture()
    lost = [fake_feed.spokes(greeting, data, 0, 20), gap(greeting, 20, 12), fake_feed.spokes(greeting, data, 32, 40)]
    *_, last = film(scans([greeting, *lost]), fps=5)
    assert np.flatnonzero(~last.filled).tolist() == list(range(20, 32))


def test_power_is_shown_on_one_scale_throughout() -> None:
    """The second scan is 30 dB weaker: half of a picture of 60 dB."""
    greeting, strong = hello(encoding="f32"), np.full((AZIMUTHS, 100), 1e-9, dtype=np.float32)
    both = [fake_feed.spokes(greeting, data, first, AZIMUTHS) for data, first in ((strong, 0), (strong / 1000, AZIMUTHS))]
    *_, last = film(scans([greeting, *both]), fps=10)
    assert last.picture[-1].min() >= 127 and last.picture[-1].max() <= 128


def test_a_film_without_end_is_refused() -> None:
    greeting = hello()
    late = fake_feed.spokes(greeting, picture(), 36, 36)
    late["time"] = [1e9 + k for k in range(36)]
    with pytest.raises(FeedError, match="at most 20000"):
        next(film(scans([greeting, fake_feed.spokes(greeting, picture(), 0, 36), late]), fps=10))


def test_command_writes_a_film(tmp_path: Path) -> None:
    out, greeting = tmp_path / "a.gif", hello()
    with running(
        Script([greeting, *(fake_feed.spokes(greeting, picture(), 36 * k, 36) for k in range(4))], wait=True)
    ) as feed:
        assert main([feed.url, "--scans", "2", "--out", str(out), "--fps", "5", "--size", "200"]) == 0
    with Image.open(out) as made:
        assert (made.size, made.n_frames, made.info["duration"]) == ((200, 200), 24, 200)  # type: ignore[attr-defined]
        first = np.asarray(made.convert("RGB")).astype(int)
        made.seek(23)
        last = np.asarray(made.convert("RGB")).astype(int)
    lit = np.abs(last - first).sum(axis=2) > 60
    assert lit[:, :95].any() and lit[:, 105:].any()  # the grey that no spoke had reached, on either side


def test_command_refuses_an_mp4_without_ffmpeg_before_it_connects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SystemExit):
        main(["ws://127.0.0.1:1", "--out", str(tmp_path / "a.mp4")])
    assert "install it (apt-get install ffmpeg)" in capsys.readouterr().err
