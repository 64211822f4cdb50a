"""Messages of `plan` and `check` about the limits that the studies find."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.describe import describe
from radar_service.trace.ray_sampling import missed_area_range
from tests.scenes import point, radar, scene


def test_plan_states_the_range_from_which_rays_miss_a_square_metre() -> None:
    """(1 - p)^2000 = 0.05: p = 1.4968e-3; the box is 11.7 x 75 degrees = 0.26730 sr, so R = 1 / sqrt(p box) = 49.99 m."""
    small = radar()
    assert missed_area_range(small.rays, small.beamwidth, small.beamwidth_el) == pytest.approx(49.99, abs=0.01)
    assert "beyond 50 m" in str(rs.Simulator(scene([point("t", 0, 500)]), "documented").plan)
    assert "a square metre" not in str(rs.Simulator(scene([point("t", 0, 500)])).plan)


def test_plan_states_that_diffraction_is_missing_only_with_multipath() -> None:
    for multipath in (True, False):
        plan = str(rs.Simulator(scene([point("t", 0, 500)], environment={"multipath": multipath})).plan)
        assert ("nothing diffracts" in plan) == multipath


def test_check_states_the_loss_between_spokes() -> None:
    """A beam of one step loses half of the power each way, 6.02 dB; from 1 / 0.72 steps on there is no message."""
    assert "the loss is 6.0 dB" in describe(scene(radar={"beamwidth_deg": 0.5}))
    assert "the loss is" in describe(scene(radar={"beamwidth_deg": 0.69}))
    assert "the loss is" not in describe(scene(radar={"beamwidth_deg": 0.70}))


def test_check_names_a_taylor_pattern() -> None:
    assert "taylor 30 dB, nbar 4" in describe(scene(radar={"pattern": "taylor"}))


def test_a_scene_at_the_limit_of_power_stays_finite() -> None:
    """The strongest scene that loads has a finite field and power."""
    strong = {"power_w": 1e9, "gain_dbi": 80, "range_max_m": 600, "pulse_s": 1e-6, "azimuths": 16, "beamwidth_deg": 40}
    scan = rs.Simulator(scene([point("t", 0, 1.0, rcs_dbsm=100)], radar=strong)).scan()
    assert np.isfinite(scan.power).all() and scan.power.max() > 1e20
