"""The cell that a bin shows, against a plain loop over the cells."""

import math

import numpy as np
import pytest

from radar_service.display.video import Controls, decibels, display_video, layout, sea_attenuation_db
from radar_service.stream.codecs.native.encoding import encode
from radar_service.stream.codecs.native.shown_cells import shown_cells

NOISE, CELLS = 1e-15, 97
BY_HAND = Controls(gain=80, sea=60, gain_auto=False, sea_auto=False)


def spokes(seed: int = 0) -> np.ndarray:
    """Power [W] of cells that say little about their neighbours."""
    return (1e-13 * 10.0 ** np.random.default_rng(seed).uniform(-3, 3, (4, CELLS))).astype(np.float32)


@pytest.mark.parametrize("encoding", ["u8-log", "f16", "f32", "c64"])
@pytest.mark.parametrize("bins", [None, 96, 40, 7, 1])
def test_it_is_the_strongest_cell_of_the_bin(encoding: str, bins: int | None) -> None:
    power = spokes()
    field, to = np.sqrt(power).astype(np.complex64), layout(CELLS, 5.0, 10.0, bins, 900.0)
    cells = shown_cells(encoding, power, field, to, Controls(), NOISE, None)
    sent = encode(encoding, power, field, to, Controls(), NOISE)
    assert cells.shape == (4, to.bins) == sent.shape
    for k in range(4):
        for b in range(to.bins):
            group = [n for n in range(to.samples) if math.floor((n + 0.5) * to.bins / to.samples) == b]
            assert cells[k, b] == max(group, key=lambda n: power[k, n])
    if encoding == "c64":
        np.testing.assert_array_equal(sent, np.take_along_axis(field, cells, axis=1))


@pytest.mark.parametrize("stretch", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("bins", [None, 40, 7])
def test_video_shows_the_cell_that_is_strongest_after_the_controls(bins: int | None, stretch: float) -> None:
    """Sea control makes near cells weaker, echo stretch shows cells also behind them."""
    power, to = spokes(1), layout(CELLS, 5.0, 10.0, bins)
    controls = Controls(gain=80, sea=60, gain_auto=False, sea_auto=False, echo_stretch=stretch)
    cells = shown_cells("u8", power, power.astype(np.complex64), to, controls, NOISE, None)
    lengthened = math.ceil(0.01 * stretch * CELLS)
    level = decibels(power) - sea_attenuation_db(5.0 + 10.0 * np.arange(CELLS), 60.0).astype(np.float32)
    for k in range(4):
        for b in range(to.bins):
            group = [n for n in range(CELLS) if math.floor((n + 0.5) * to.bins / CELLS) == b]
            shown = range(max(0, group[0] - lengthened), group[-1] + 1)
            assert cells[k, b] == max(shown, key=lambda n: level[k, n])
    byte = display_video(power, layout(CELLS, 5.0, 10.0), Controls(**vars(controls) | {"echo_stretch": 0.0}), NOISE)
    np.testing.assert_array_equal(display_video(power, to, controls, NOISE), np.take_along_axis(byte, cells, axis=1))


def test_scan_correlation_decides_too() -> None:
    """A cell that was not there in the scan before is shown below its neighbour that was."""
    power = np.full((1, 2), 1e-12, dtype=np.float32) * np.array([[2.0, 1.0]], dtype=np.float32)
    to, field = layout(2, 5.0, 10.0, 1), power.astype(np.complex64)
    controls = Controls(gain=80, gain_auto=False, sea_auto=False, scan_correlation=True)
    before = power * np.array([[1e-3, 1.0]], dtype=np.float32)
    assert shown_cells("u8", power, field, to, controls, NOISE, earlier=None).tolist() == [[0]]
    assert shown_cells("u8", power, field, to, controls, NOISE, earlier=before).tolist() == [[1]]


def test_of_equal_cells_the_first_one_is_shown() -> None:
    power = np.ones((1, 6), dtype=np.float32)
    to = layout(6, 5.0, 10.0, 2)
    assert shown_cells("f32", power, power.astype(np.complex64), to, Controls(), NOISE, None).tolist() == [[0, 3]]
    nothing = np.zeros_like(power)
    assert shown_cells("u8", nothing, nothing.astype(np.complex64), to, BY_HAND, NOISE, None).tolist() == [[0, 3]]
