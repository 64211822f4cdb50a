"""Detections of a scan."""

import numpy as np

from radar_service.plots.detections import detections_of, no_detections
from radar_service.scans.scan import Scan


def scan_of_power(power: np.ndarray, number: int = 3) -> Scan:
    """A scan (A, N) with own ship at (10 A, 20)."""
    count, cells = power.shape
    time, zero = 5.0 + np.arange(count), np.zeros(count)
    position = np.stack([10.0 * np.arange(count), np.full(count, 20.0)], axis=1)
    azimuth = np.arange(count) * (2 * np.pi / count)
    return Scan(
        number, time, azimuth, zero, position, zero, zero, np.arange(cells) + 0.5, 1.0, np.sqrt(power).astype(np.complex64),
        power.astype(np.float32),
    )  # fmt: skip


def test_cells_above_the_threshold_are_detections() -> None:
    power = np.zeros((4, 5))
    power[1, 2], power[3, 0], power[2, 2] = 9.0, 5.0, np.nan
    result = detections_of(scan_of_power(power), np.array([[4.0]]))
    assert result.spoke.tolist() == [13, 15] and result.cell.tolist() == [2, 0] and result.power.tolist() == [9.0, 5.0]
    assert (
        result.time.tolist() == [6.0, 8.0]
        and result.east.tolist() == [10.0, 30.0]
        and result.threshold.tolist() == [4.0, 4.0]
    )
    assert detections_of(scan_of_power(power), np.full((4, 5), 5.0)).cell.tolist() == [2]


def test_detections_are_joined_and_chosen() -> None:
    power = np.eye(4)
    one = detections_of(scan_of_power(power), np.array([[0.5]]))
    both = no_detections().and_then(one).and_then(one.only(one.cell > 1))
    assert len(both) == 6 and both.cell.tolist() == [0, 1, 2, 3, 2, 3]
