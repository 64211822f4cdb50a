"""Weights of legs are the factors by which the echo stage tells the paths apart."""

import numpy as np
import pytest

from radar_service.frames import polar_from_map
from radar_service.propagation.leg_weight import LegWeight
from radar_service.propagation.legs import direct_leg, sea_leg
from radar_service.propagation.multipath import two_ray_factor
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.propagation.sea_surface import rms_wave_height
from tests.scenes import radar

EARTH = 4 / 3 * 6_371_000.0


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("state", [0, 3])
def test_both_legs_make_the_two_ray_factor(polarization: str, state: int) -> None:
    made = radar(polarization=polarization, beamwidth_el_deg=20.0)
    antenna = np.array([0.0, 0.0, made.height])
    position = np.array([[0.0, 300.0, 4.0], [500.0, 100.0, 12.0], [0.0, 4000.0, 9.0]])
    polar = polar_from_map(position, antenna, EARTH)
    legs = direct_leg(position, antenna, EARTH), sea_leg(position, antenna, EARTH)
    weight = LegWeight(made, state)
    k = 2 * np.pi / made.wavelength
    direct, sea = (
        weight(leg, by_sea) * np.exp(-1j * k * leg.length) for leg, by_sea in zip(legs, (False, True), strict=True)
    )
    exact = two_ray_factor(
        polar.distance, position[:, 2], made.height, made.wavelength, earth_radius=EARTH, polarization=polarization,
        wave_height=rms_wave_height(state), elevation_gain=lambda e: elevation_gain(made, e),
    )  # fmt: skip
    np.testing.assert_allclose((direct + sea) / direct, exact, rtol=1e-6)
