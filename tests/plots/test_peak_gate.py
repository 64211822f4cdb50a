"""The gate of a plot about its peak."""

import numpy as np
import pytest

from radar_service.plots.detections import Detections, detections_of
from radar_service.plots.peak_gate import about_peak
from tests.plots.test_detections import scan_of_power


def cells(power: list[list[float]]) -> Detections:
    return detections_of(scan_of_power(np.array(power), number=0), np.array([[0.5]]))


def test_weak_cells_and_islands_are_left_out() -> None:
    """20 dB: the cell of 0.9 is too weak, that of 50 is apart from the peak, and a corner connects."""
    some = cells([[100.0, 2.0, 0.9, 0.9, 50.0], [0.0, 0.0, 2.0, 0.0, 0.0]])
    kept = about_peak(some, np.zeros(len(some), dtype=np.int64), 20.0)
    assert sorted(some.power[kept].tolist()) == [2.0, 2.0, 100.0]


@pytest.mark.parametrize(("gate_db", "count"), [(0.1, 1), (3.1, 2), (60.0, 4)])
def test_a_deeper_gate_has_more_cells(gate_db: float, count: int) -> None:
    assert about_peak(cells([[100.0, 50.0, 10.0, 1.0]]), np.zeros(4, dtype=np.int64), gate_db).sum() == count


def test_parts_that_touch_are_gated_each_for_itself() -> None:
    """20 dB below the peaks of 100 and 1; a cell of the other part connects nothing."""
    kept = about_peak(cells([[100.0, 0.9, 2.0, 1.0, 0.9]]), np.array([0, 1, 0, 1, 1]), 20.0)
    assert kept.tolist() == [True, False, False, True, True]


def test_no_detections_have_no_gate() -> None:
    assert len(about_peak(cells([[0.0]]), np.empty(0, dtype=np.int64), 20.0)) == 0
