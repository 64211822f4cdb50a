"""Video of category 240 against the truth, the cells that were sent, and true north."""

import math
from dataclasses import replace

import numpy as np
import pytest

from radar_service.ports.asterix.blocks import Form, summary, video
from tests.ports.asterix.reading import Video, blocks, record, videos
from tests.ports.reflectors import batches, crossings, radar_of, simulator
from tests.reference.true_north import true_deg


@pytest.mark.parametrize("bits", [8, 16])
def test_the_cell_and_the_sector_of_each_peak_hold_the_truth(bits: int) -> None:
    """Cells are whole, so a peak is within its own: no margin beside the last bit of the azimuth."""
    source = simulator()
    radar, form = radar_of(source), Form(7, bits, 65507)
    got = videos([each for batch in batches(radar, source) for spoke in video(batch, form, 3) for each in spoke])
    assert len(got) == 720 and {(*each.source, len(each.cells)) for each in got} == {(7, 3, source.range.size)}
    image = np.array([each.cells for each in got])
    truth = crossings(source)
    assert len(truth) == 5
    for crossing in truth:
        near = abs(np.arange(image.shape[1]) * got[0].cell - crossing["range"]) < 30.0
        row, cell = np.unravel_index(np.argmax(np.where(near, image, -1)), image.shape)
        peak = got[row]
        assert peak.first + cell * peak.cell <= crossing["range"] < peak.first + (cell + 1) * peak.cell
        bearing = true_deg(crossing["bearing"], [0.0, 0.0], (50.0, 1.0)) / 360.0
        assert (bearing - peak.begin) % 1.0 <= (peak.end - peak.begin) % 1.0 + 2 / 65536
        assert abs((86399.0 + crossing["time"]) % 86400.0 - peak.time) < 1 / 128 + 2.5 / 720


@pytest.mark.parametrize(("bits", "largest"), [(8, 256), (8, 1400), (16, 1400), (16, 1500), (8, 65507), (16, 65507)])
def test_spokes_are_split_where_they_are_too_long(bits: int, largest: int) -> None:
    """All cells come once, in order, in as few blocks as the items allow, and lost blocks can be counted."""
    source = simulator(64)
    radar, form = radar_of(source), Form(0, bits, largest)
    number = 0
    for batch in batches(radar, source):
        expected = batch.video_bytes(batch.epoch.layout(None))
        for k, spoke in enumerate(video(batch, form, 1)):
            assert all(len(each) <= largest for each in spoke) and len(spoke) == math.ceil(source.range.size / form.cells)
            got = videos(spoke)
            assert [each.sequence for each in got] == list(range(number, number + len(got)))
            assert np.allclose([each.first for each in got], np.arange(len(got)) * form.cells * source.range_step, atol=1e-3)
            cells = np.concatenate([each.cells for each in got])
            if bits == 8:
                assert cells.tolist() == expected[k].tolist()
            else:
                level = 10.0 * np.log10(np.maximum(batch.block.power[k], 1e-40) / source.noise_power)
                assert np.allclose(cells, np.clip((level + 100.0) * 100.0, 0.0, 65535.0), atol=0.51)
            number += len(got)


def test_azimuths_count_from_true_north_and_a_lost_heading_sends_nothing() -> None:
    """600 km to the east of the origin map and true north differ by 9 degrees."""
    source = simulator(64)
    batch = next(batches(radar_of(source), source, size=2))
    far, lost = np.array([[6e5, 0.0], [0.0, 0.0]]), np.array([math.nan, 0.5])
    (first,), (second,) = video(replace(batch, block=replace(batch.block, position=far)), Form(), 1)
    for block, place in ((first, far[0]), (second, far[1])):
        (got,) = videos([block])
        middle = got.begin + (got.end - got.begin) % 1.0 / 2.0
        north = true_deg(float(batch.block.azimuth[int(block is second)]), place.tolist(), (50.0, 1.0)) / 360.0
        assert abs((middle - north + 0.5) % 1.0 - 0.5) <= 0.51 / 65536
    assert list(video(replace(batch, block=replace(batch.block, heading=lost)), Form(), 1)) == [[], [second]]


def test_the_summary_says_north_and_law() -> None:
    radar = radar_of(simulator(8))
    for bits in (8, 16):
        (content,) = blocks(summary(radar, Form(0, bits), 2))
        text = record(content)
        assert not isinstance(text, Video) and "reflectors" in text and "true north" in text and f"{bits} bit" in text
