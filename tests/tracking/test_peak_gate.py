"""The gate of a plot about its peak."""

import numpy as np
import pytest

from radar_service.tracking.detections import Detections, detections_of
from radar_service.tracking.peak_gate import about_peak
from tests.tracking.test_detections import scan_of_power


def cells(power: list[list[float]]) -> Detections:
    return detections_of(scan_of_power(np.array(power), number=0), np.array([[0.5]]))


def test_weak_cells_and_islands_are_left_out() -> None:
    """20 dB: the cell of 0.9 is too weak, that of 50 is apart from the peak, and a corner connects."""
    kept = about_peak(cells([[100.0, 2.0, 0.9, 0.9, 50.0], [0.0, 0.0, 2.0, 0.0, 0.0]]), 20.0)
    assert sorted(kept.power.tolist()) == [2.0, 2.0, 100.0]


@pytest.mark.parametrize(("gate_db", "count"), [(0.1, 1), (3.1, 2), (60.0, 4)])
def test_a_deeper_gate_has_more_cells(gate_db: float, count: int) -> None:
    assert len(about_peak(cells([[100.0, 50.0, 10.0, 1.0]]), gate_db)) == count
