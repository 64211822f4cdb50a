"""Geodesic placement against published numbers and against spherical and series formulas of its own."""

import math

import numpy as np
import pytest
from pyproj import Geod

from radar_service.numerics.frames import wrap_angle
from radar_service.world.geo import geographic_from_map, map_bearing, map_from_geographic, true_bearing


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


PLACES = [((50.0, -1.0), (0.0, 0.0)), ((50.0, -1.0), (150e3, -80e3)), ((89.0, 12.0), (9e3, 4e3)), ((-20.0, 180.0), (-300e3, 5e3)),
          ((60.0, 5.0), (1.2e6, 0.9e6)), ((0.0, 0.0), (0.0, 2e5))]  # fmt: skip


@pytest.mark.parametrize(("origin", "place"), PLACES)
def test_true_bearings_are_those_of_geodesics_to_positions_ahead(
    origin: tuple[float, float], place: tuple[float, float]
) -> None:
    """10 m ahead and astern on the map, by the inverse geodesic: 15 nm of its rounding are 1e-9 rad. The earth curves by up to
    0.9 % less than the sphere (at the poles), and so does c / sin(c) - 1 = c^2 / 6; half of that is the angle's error."""
    bearing = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    step = 10.0 * np.stack([np.sin(bearing), np.cos(bearing)], axis=-1)
    here = np.broadcast_to(place, step.shape)
    behind, ahead = (geographic_from_map(here + each, origin) for each in (-step, step))
    middle = geographic_from_map(here, origin)
    to, _, _ = Geod(ellps="WGS84").inv(middle[:, 1], middle[:, 0], ahead[:, 1], ahead[:, 0])
    back, _, _ = Geod(ellps="WGS84").inv(middle[:, 1], middle[:, 0], behind[:, 1], behind[:, 0])
    expected = np.deg2rad(to) + wrap_angle(np.deg2rad(back) + np.pi - np.deg2rad(to)) / 2.0  # without what the way curves
    tolerance = 2e-9 + 0.009 * (np.hypot(*place) / 6.371e6) ** 2 / 12.0
    true = true_bearing(bearing, here, origin)
    assert np.abs(wrap_angle(true - expected)).max() < tolerance
    assert np.abs(wrap_angle(map_bearing(true, here, origin) - bearing)).max() < 1e-12


def test_true_north_turns_by_the_sine_of_the_latitude() -> None:
    """100 km to the east at 50 N: the first term of the series of the convergence, tan(latitude) s / N; the next one is below
    (s / N)^3."""
    n = 6_378_137.0 / math.sqrt(1.0 - 0.00669438 * math.sin(math.radians(50.0)) ** 2)
    turned = float(true_bearing(0.0, np.array([100e3, 0.0]), (50.0, -1.0)))
    assert turned == pytest.approx(math.tan(math.radians(50.0)) * 100e3 / n, abs=(100e3 / n) ** 3)
