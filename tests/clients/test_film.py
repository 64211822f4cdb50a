"""Scans become films: the beam goes round, echoes fade, a second of film is a second of simulation."""

import tracemalloc
from typing import Any

import numpy as np
import pytest

from clients.ppi import FeedError, ReceivedScan
from clients.ppi.film import AFTERGLOW, film
from tests.clients import fake_feed
from tests.clients.fake_feed import collected, gap, hello, picture

AZIMUTHS, RATE = 72, 30.0  # spokes of a scan, spokes a second


def scans(messages: list[dict[str, Any]]) -> list[ReceivedScan]:
    return list(collected(messages).scans)


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


def test_lost_azimuths_stay_undrawn() -> None:
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


def test_a_film_holds_the_power_of_one_scan_at_a_time() -> None:
    """Of 20 scans of float32, four times as large as their brightness: what is held stays below half of their power."""
    greeting, data = hello(encoding="f32"), np.full((AZIMUTHS, 100), 1e-9, dtype=np.float32)
    many = scans([greeting, *(fake_feed.spokes(greeting, data, AZIMUTHS * k, AZIMUTHS) for k in range(20))])
    next(film(many[:2], fps=1))  # what is imported at first use
    tracemalloc.start()
    next(film(many, fps=1))
    held = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(many) == 20 and held < 20 * data.nbytes / 2


def test_a_film_without_end_is_refused() -> None:
    greeting = hello()
    late = fake_feed.spokes(greeting, picture(), 36, 36)
    late["time"] = [1e9 + k for k in range(36)]
    with pytest.raises(FeedError, match="at most 20000"):
        next(film(scans([greeting, fake_feed.spokes(greeting, picture(), 0, 36), late]), fps=10))


def test_a_lost_heading_stays_as_it_was_last_reported() -> None:
    greeting, data = hello(), picture()
    lost = [fake_feed.spokes(greeting, data, 0, 36, 40.0), fake_feed.spokes(greeting, data, 36, 36, np.nan)]
    *_, last = film(scans([greeting, *lost]), fps=5)
    assert last.heading == pytest.approx(np.radians(40.0), abs=4.8e-5)  # half of 1/65536 turn
    never, *_ = film(scans([greeting, fake_feed.spokes(greeting, data, 0, 72, np.nan)]), fps=5)
    assert np.isnan(never.heading)
