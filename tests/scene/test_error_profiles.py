"""Profiles of errors: their values and their source."""

from typing import get_args

import pytest

import radar_service as rs
from radar_service.scene.error_profiles import PROFILES
from radar_service.scene.errors_model import ErrorsModel

DEGREE, KNOT = 0.017453292519943295, 1852 / 3600


def test_each_profile_can_be_chosen() -> None:
    names, _ = get_args(ErrorsModel.model_fields["profile"].annotation)
    assert set(get_args(names)) == set(PROFILES)


def test_the_arpa_resolution_gives_these_sensor_errors() -> None:
    """A.823(19), appendix 3: gyro 0.5 degrees, sigma 0.12; log 0.5 knots, 3 sigma 0.2; backlash 0.05, steps 0.2, encoder 0.03."""
    its = rs.load_scene({"errors": {"profile": "imo-a823"}}).errors
    assert its is not None and its.gyro is not None and its.log is not None and its.antenna is not None
    assert (its.gyro.bias, its.gyro.noise) == pytest.approx((0.5 * DEGREE, 0.12 * DEGREE), rel=1e-12)
    assert (its.log.bias, 3 * its.log.noise) == pytest.approx((0.5 * KNOT, 0.2 * KNOT), rel=1e-12)
    antenna = its.antenna.backlash, its.antenna.encoder_step, its.antenna.encoder_noise
    assert antenna == pytest.approx((0.05 * DEGREE, 2 * 0.1 * DEGREE, 0.03 * DEGREE), rel=1e-12)
    assert its.position is None and its.feed is None
