"""Constants against CODATA, as scipy has it, and against their definitions."""

import pytest
from scipy import constants as codata

from radar_service.numerics import constants


def test_constants_are_those_of_codata_and_of_the_mile() -> None:
    """All exact by definition."""
    assert (constants.SPEED_OF_LIGHT, constants.BOLTZMANN) == (codata.c, codata.k)
    assert (constants.NAUTICAL_MILE, constants.KNOT) == (codata.nautical_mile, codata.knot)


def test_noise_density_at_the_reference_temperature() -> None:
    """k T0 is -204 dBW/Hz (-203.98; IEEE Std 686 takes 290 K for this round number): half the last digit."""
    assert constants.BOLTZMANN * constants.REFERENCE_TEMPERATURE == pytest.approx(10**-20.398, rel=0.0012)


def test_the_earth_has_its_mean_radius() -> None:
    """A degree of a great circle is 60 nautical miles to 0.1 %, as the mile was first defined; WGS 84: (2 a + b) / 3."""
    assert constants.EARTH_RADIUS * codata.degree == pytest.approx(60 * constants.NAUTICAL_MILE, rel=1e-3)
    assert constants.EARTH_RADIUS == pytest.approx(
        (2 * 6_378_137.0 + 6_356_752.3) / 3, abs=10.0
    )  # rounded to a km, less 9 m
