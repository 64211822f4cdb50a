"""Rain clutter's physics by hand."""

import numpy as np
import pytest

from radar_service.stages.clutter.clutter import RAIN_HEIGHT, beam_height, reflectivity

EARTH = 4 / 3 * 6_371_000.0


def test_reflectivity_by_hand() -> None:
    """4 mm/h: Z = 200 x 4^1.6 = 1837.9 mm^6/m^3 = 32.64 dBZ; eta = pi^5 x 0.93 x 1.8379e-15 / 0.0318589^4 = 5.077e-7/m."""
    assert reflectivity(4.0, 0.0318589) == pytest.approx(5.077e-7, rel=1e-3)  # four printed digits
    assert reflectivity(16.0, 0.0318589) / reflectivity(4.0, 0.0318589) == pytest.approx(4**1.6, rel=1e-12)
    assert reflectivity(0.0, 0.0318589) == 0.0
    with pytest.raises(ValueError, match="rain_mm_h: -1 is not allowed"):
        reflectivity(-1.0, 0.0318589)


def test_a_beam_that_fits_into_the_rain_is_held_whole() -> None:
    """Gaussian of 2 degrees looking 1.15 degrees up at 40 km, where rain reaches from 0.16 below to 4.0 degrees above the
    horizontal: integral of G^2 = w sqrt(pi / (8 ln 2)); 1e-3 of it lies outside."""
    width = np.deg2rad(0.5)
    elevation = np.linspace(-0.5, 0.5, 20_001)
    gain = np.exp(-4 * np.log(2) * ((elevation - np.deg2rad(1.5)) / width) ** 2)
    held = beam_height(np.array([40_000.0]), 15.0, EARTH, elevation, gain)
    assert held[0] == pytest.approx(width * np.sqrt(np.pi / (8 * np.log(2))), rel=1e-3)


def test_rain_reaches_from_the_sea_to_its_height() -> None:
    """With a gain of 1 everywhere it is the angle between the two; at 10 km on a flat earth asin(0.0015) + asin(0.2985); on
    the bent one both are seen lower by R/(2 ae); past the horizon the sea's edge, sqrt(2 h / ae) down, is the floor."""
    elevation = np.linspace(-np.pi / 2, np.pi / 2, 200_001)
    gain = np.ones_like(elevation)
    at = np.array([10_000.0, 30_000.0])
    flat = beam_height(at, 15.0, np.inf, elevation, gain)
    assert flat[0] == pytest.approx(np.arcsin(15 / 10_000) + np.arcsin((RAIN_HEIGHT - 15) / 10_000), abs=1e-8)
    bent = beam_height(at, 15.0, EARTH, elevation, gain)
    top = np.arcsin((RAIN_HEIGHT - 15) / 30_000 - 30_000 / (2 * EARTH))
    assert bent[1] == pytest.approx(top + np.sqrt(2 * 15 / EARTH), abs=1e-8)
    assert beam_height(np.array([400_000.0]), 15.0, EARTH, elevation, gain)[0] == 0.0  # all rain below the horizon


def test_close_by_the_whole_sphere_is_rain() -> None:
    """10 m from an antenna 15 m up nothing is sea and nothing above the rain: the angle is half a turn."""
    elevation = np.linspace(-np.pi / 2, np.pi / 2, 2001)
    assert beam_height(np.array([10.0]), 15.0, EARTH, elevation, np.ones_like(elevation))[0] == pytest.approx(
        np.pi, abs=1e-9
    )
