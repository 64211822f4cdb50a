"""Errors in SI units."""

import math
from typing import Any

import pytest

import radar_service as rs
from radar_service.world.error_settings import ErrorSettings

EVERY: dict[str, dict[str, Any]] = {
    "gyro": {"bias_deg": 0.5, "calibration_deg": 0.3, "calibration_phase_deg": 40.0, "noise_deg": 0.12, "noise_time_s": 7.0,
             "latency_s": 0.2},
    "log": {"bias_kn": -0.5, "scale_percent": 3.0, "least_kn": 0.1, "noise_kn": 0.1, "noise_time_s": 5.0, "latency_s": 1.0},
    "position": {"bias_m": [3.0, -4.0], "noise_m": 2.5, "noise_time_s": 90.0, "latency_s": 0.5},
    "antenna": {"misalignment_deg": -1.1, "backlash_deg": 0.05, "encoder_noise_deg": 0.03, "encoder_step_deg": 0.2},
    "feed": {"drop_rate": 0.1, "burst_rate": 0.01, "burst_spokes": 12, "repeat_rate": 0.05, "late_rate": 0.04, "late_s": 0.3,
             "swap_rate": 0.02, "stuck_sector_deg": [10.0, 20.0], "heading_lost_s": [[1.0, 2.0], [5.0, 6.0]],
             "bytes_per_s": 5000.0, "cut_after_s": 30.0},
}  # fmt: skip


def settings(errors: Any) -> ErrorSettings:
    """The errors of a scene with these tables."""
    made = rs.load_scene({"errors": errors}).errors
    assert made is not None
    return made


def test_values_become_si_and_radians() -> None:
    its = settings(EVERY)
    assert its.gyro and its.log and its.position and its.antenna and its.feed
    assert its.gyro.calibration_phase == pytest.approx(math.radians(40), rel=1e-12)
    assert (its.log.bias, its.log.scale) == pytest.approx((-0.5 * 1852 / 3600, 0.03), rel=1e-12)
    assert its.position.bias == (3.0, -4.0) and its.antenna.misalignment == pytest.approx(math.radians(-1.1), rel=1e-12)
    assert its.feed.stuck_sector == pytest.approx((math.radians(10), math.radians(20)), rel=1e-12)
    assert (its.feed.bytes, its.feed.cut_after, its.feed.late) == (5000.0, 30.0, 0.3)
