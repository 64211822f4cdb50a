"""Geodesic placement against published numbers and against spherical and series formulas of its own."""

import math

import numpy as np

from radar_service.world.geo import geographic_from_map, map_from_geographic


def test_flinders_peak_to_buninyong() -> None:
    """The worked example of the Geocentric Datum of Australia technical manual: 54 972.271 m at 306 52 05.37."""
    # The manual uses GRS80; its flattening differs from WGS 84 by 1.6e-11, under a micrometre here.
    flinders = (-(37 + 57 / 60 + 3.72030 / 3600), 144 + 25 / 60 + 29.52440 / 3600)
    buninyong = (-(37 + 39 / 60 + 10.15610 / 3600), 143 + 55 / 60 + 35.38390 / 3600)
    east, north = map_from_geographic(*buninyong, flinders)
    bearing_deg = math.degrees(math.atan2(east, north)) % 360
    assert abs(math.hypot(east, north) - 54972.271) < 1e-3  # m: last printed digit, and rounding of the printed places
    assert abs(bearing_deg - (306 + 52 / 60 + 5.37 / 3600)) < 0.01 / 3600  # last printed digit


def test_quarter_of_the_meridian() -> None:
    """From the equator to the pole is 10 001 965.729 m on WGS 84 (meridian quadrant, published to the millimetre)."""
    east, north = map_from_geographic(90.0, 7.0, (0.0, 7.0))
    assert abs(math.hypot(east, north) - 10_001_965.729) < 1e-3
    assert abs(east) < 1e-3


def test_short_distances_follow_the_radii_of_curvature() -> None:
    """One second of arc north and east at 50.9 N are M and N cos(latitude) times the angle (ellipsoidal geometry)."""
    a, f, latitude = 6_378_137.0, 1 / 298.257223563, math.radians(50.9)
    e2 = f * (2 - f)
    w = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    second = 1.0 / 3600.0
    positions = map_from_geographic(np.array([50.9 + second, 50.9]), np.array([1.4, 1.4 + second]), (50.9, 1.4))
    north = a * (1 - e2) / w**3 * math.radians(second)
    east = a / w * math.cos(latitude) * math.radians(second)
    # the next term of the series is tan(latitude)/(2 N) s^2 = 5e-5 m north for the place in the east
    np.testing.assert_allclose(positions, [[0.0, north], [east, 0.0]], atol=1e-4)


def test_both_conversions_cancel() -> None:
    rng = np.random.default_rng(1)
    positions = rng.uniform(-2e5, 2e5, (50, 4, 2))
    back = geographic_from_map(positions, (48.3, -122.5))
    again = map_from_geographic(back[..., 0], back[..., 1], (48.3, -122.5))
    np.testing.assert_allclose(again, positions, atol=1e-6)  # m: nanometres of the solver, 1e-14 of a longitude in degrees


def test_heights_are_ignored_and_the_origin_is_itself() -> None:
    np.testing.assert_allclose(geographic_from_map(np.array([0.0, 0.0, 99.0]), (10.0, 20.0)), [10.0, 20.0], atol=1e-12)
