"""Spokes of an xHD and a HALO against the truth: whatever the azimuths of our radar, no peak is lost, and angles come once."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from radar_service.ports.dialect.announcements import BowSpokes, Samples, true_headings
from radar_service.ports.dialect.dialect import Dialect, Spoke
from radar_service.ports.garmin_xhd.datagrams import XHD
from radar_service.ports.navico_halo.datagrams import HALO
from radar_service.service.spokes import SpokeBatch
from tests.ports.reflectors import GAIN, batches, crossings, radar_of, simulator
from tests.service.fake import FakeEngine, scene


@pytest.mark.sample(6)
@pytest.mark.parametrize("azimuths", [360, 720, 1000, 1440, 4096])
@pytest.mark.parametrize(("dialect", "display_range"), [(XHD, None), (XHD, 750.0), (HALO, None), (HALO, 750.0)])
def test_reflectors_stand_within_a_sample_and_a_spoke(azimuths: int, dialect: Dialect, display_range: float | None) -> None:
    source, turn = simulator(azimuths), dialect.spokes
    radar = radar_of(source, display_range)
    samples, spokes, video = Samples(radar.epoch, dialect.samples), BowSpokes(azimuths, turn), list[np.ndarray]()
    out = list[Spoke]()
    for batch in batches(radar, source):
        video.append(batch.video_bytes(radar.epoch.layout(None)))
        out += spokes.ended(batch, samples.of(batch), samples.metres, true_headings(batch))
    numbers, image = [each.number for each in out], np.array([each.samples for each in out])
    assert set(np.diff(numbers) % turn) == {1} and spokes.lost == 0 and image.shape[1] <= dialect.samples.most
    north = [math.degrees(each.heading) + each.number * 360 / turn for each in out]  # true bearing
    width, step, count = samples.metres / image.shape[1], radar.epoch.layout(None).step, 0
    for crossing in crossings(source):
        sample = int(crossing["range"] / width)
        if not 3 < sample < image.shape[1] - 3:
            continue
        near = image[:, sample - 3 : sample + 4]
        rows, columns = np.nonzero(near == near.max())
        assert near.max() == dialect.samples.levels[max(peak(video, crossing["range"], step))]
        assert set(columns) == {3} or (dialect is HALO and abs(np.median(columns) - 3) * width <= step)
        own = max(turn / azimuths, 1.0)  # a spoke of ours, in theirs
        found = np.median(np.unwrap(np.array(numbers)[rows] / turn * 2 * np.pi)) / (2 * np.pi) * turn
        assert abs(math.remainder(found - crossing["relative_bearing"] / (2 * np.pi) * turn, turn)) <= 0.5 * own + 0.5
        bearing = np.median(np.unwrap(np.radians(np.array(north)[rows])))
        assert abs(math.remainder(bearing - crossing["bearing"], 2 * np.pi)) <= (0.5 * own + 0.5) / turn * 2 * np.pi + 0.001
        count += 1
    assert count == (5 if display_range is None else 2)


def peak(video: list[np.ndarray], distance: float, step: float) -> list[int]:
    """The highest byte of our video near a range [m], in each batch."""
    cell = int(distance / step)
    return [int(rows[:, cell - 8 : cell + 9].max()) for rows in video]


@pytest.mark.parametrize("azimuths", [360, 1000, 1440, 2048, 4096])
def test_no_spoke_is_lost(azimuths: int) -> None:
    """Each of ours has a mark in a sample of its own, so that it is found in theirs, however many are joined."""
    spokes, marks = BowSpokes(azimuths, 1440), np.arange(azimuths) % 700
    rows = np.zeros((azimuths, 700), np.uint8)
    rows[np.arange(azimuths), marks] = 200
    angle = 2.0 * math.pi / azimuths * np.arange(azimuths)
    block = SimpleNamespace(first=0, azimuth=angle, heading=np.zeros(azimuths))
    image = np.zeros((1440, 700), np.uint8)
    for each in spokes.ended(cast(Any, SimpleNamespace(block=block)), rows, 1, block.heading):
        image[each.number] = each.samples
    half = 0.5 * max(1440 / azimuths, 1.0)
    for k in range(azimuths - 4):  # the last ones are not complete
        numbers = np.nonzero(image[:, marks[k]])[0]
        assert (abs((numbers - k * 1440 / azimuths + 720) % 1440 - 720) <= half).any(), k


def test_spokes_that_come_late_or_again_are_left_out_and_a_break_begins_anew() -> None:
    """24 spokes of ours are 60 of theirs each. Numbers from the bow, which heads 030; 5 to 9 come after 10 to 14, and 0 again."""
    engine = FakeEngine(scene())
    radar = radar_of(engine)
    breaks = list[int]()
    samples, spokes = Samples(radar.epoch, XHD.samples), BowSpokes(24, 1440, lambda: breaks.append(1))

    def sent(first: int) -> list[int]:
        batch = SpokeBatch(radar.epoch, 0, replace(engine.block(first % 24, 5), first=first), GAIN)
        return [each.number for each in spokes.ended(batch, samples.of(batch), 1, true_headings(batch))]

    first = sent(0)
    assert len(first) == 4 * 60 and first[0] == (1440 - 2 * 60 - 30) and set(np.diff(first) % 1440) == {1}
    jump = sent(10)
    assert len(jump) == 5 * 60 and np.diff(jump).max() == 1 + 5 * 60  # what was open, and nothing for what did not come
    assert sent(5) == sent(0) == [] and spokes.lost == 10
    assert len(breaks) == 1 and len(sent(48)) == 4 * 60 and len(breaks) == 2  # more than half a turn later: anew


@pytest.mark.parametrize("display_range", [12.0, 100.0, 201.0, 1000.0, 1852.0])
def test_samples_end_at_the_range_and_cells_count_once(display_range: float) -> None:
    source = simulator(8)
    radar = radar_of(source, display_range)
    samples, batch = Samples(radar.epoch, XHD.samples), next(batches(radar, source))
    got = samples.of(batch)
    assert samples.metres == display_range and got.shape[1] == min(705, int(display_range / source.range_step))
    inside = int((source.range < display_range).sum())
    cells = batch.video_bytes(radar.epoch.layout(None))[:, :inside]
    number = (source.range[:inside] / (display_range / got.shape[1])).astype(int)
    expected = np.zeros_like(got)
    np.maximum.at(expected, (slice(None), number), XHD.samples.levels[cells])
    assert np.array_equal(got, expected)


@pytest.mark.parametrize("display_range", [20.0, 100.0, 200.0])
def test_samples_shorter_than_a_cell_have_the_cell_that_they_are_in(display_range: float) -> None:
    engine = FakeEngine(scene())
    radar = radar_of(engine, display_range)
    batch, to = SpokeBatch(radar.epoch, 0, engine.block(0, 24), GAIN), radar.epoch.layout(None)
    cell = np.clip(((np.arange(1024) + 0.5) * (display_range / 1024) / to.step).astype(int), 0, to.bins - 1)
    expected = HALO.samples.levels[batch.video_bytes(to)[:, cell]]
    assert len(set(cell)) < 1024 and (np.diff(expected.astype(int), axis=1) != 0).any()
    assert np.array_equal(Samples(radar.epoch, HALO.samples).of(batch), expected)
