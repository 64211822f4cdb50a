"""The antenna by azimuth number: S, crossings and corners against own loops and closed forms."""

from typing import Any

import numpy as np
import pytest

from radar_service.echo.boresight_track import BoresightTrack, TrackPart
from radar_service.numerics.types import Floats
from radar_service.scattering.model import BearingWedge
from radar_service.scattering.resting_points import MapCells, RestingPoints
from tests.scenes import scene
from tests.test_motion import SWAY, deck

RADAR = {"azimuths": 2048, "rpm": 24, "beamwidth_deg": 1.2, "range_max_m": 3000}
HEIGHT = 15.0  # m, of the antenna by default
KNOT = 1852 / 3600


def track(**own_ship: Any) -> BoresightTrack:
    return BoresightTrack(scene(radar=RADAR, own_ship=own_ship))


def crossings(part: TrackPart, position: Floats) -> Floats:
    """The azimuth numbers at which boresight points at positions (N, 3), which face the antenna."""
    cells, order = MapCells.of(position)
    toward, none = part.polynomial[0, :3] - position[order], np.zeros(len(order))
    kinds = none.astype(np.int32), none.astype(np.int32), none > 0.0, none.astype(np.float32), none.astype(np.float32)
    points = RestingPoints(cells, position[order], toward.astype(np.float32), *kinds, none.astype(np.complex64))
    which, crossing, _ = part.passed(points, BearingWedge(toward[0], 0.0, np.pi, 0.0), -np.inf, np.inf, 0.0)
    return crossing[np.argsort(order[which])]


def test_s_changes_as_the_range_of_what_rests_on_boresight() -> None:
    """On a straight course the derivative of S is -v cos(bearing - course), to the error of a difference over 1e-3 azimuths."""
    straight = track(course_deg=200, speed_kn=25)
    number = np.linspace(2100.0, 4000.0, 40)
    step = 1e-3
    rate = (straight.shift(number + step) - straight.shift(number - step)) / (2 * step * straight.scene.radar.spoke_period)
    expected = -25 * KNOT * np.cos(straight.bearing(number) - np.deg2rad(200))
    assert np.abs(rate - expected).max() < 1e-4  # m/s: 1e-10 m of rounding of S over 1.2e-6 s


@pytest.mark.parametrize(
    "own", [{"course_deg": 200, "speed_kn": 25}, {"course_deg": 30, "speed_kn": 8, "turn_rate_deg_s": 3}]
)
def test_boresight_points_at_each_position_at_its_crossing(own: dict[str, Any]) -> None:
    """By the bearing of an own difference of positions; Newton's method leaves 1e-9 azimuths from ten times the way on."""
    moving = track(**own)
    rng, way = np.random.default_rng(1), own["speed_kn"] * KNOT / moving.turn_rate
    part = moving.between(4095.0, 4161.0)
    bearing, distance = moving.bearing(rng.uniform(4097, 4159, 200)), rng.uniform(10 * way, 3000.0, 200)
    middle = moving.antenna(np.array([part.middle]))[0]
    position = middle + np.stack([distance * np.sin(bearing), distance * np.cos(bearing), rng.uniform(-15, 20, 200)], axis=1)
    crossing = crossings(part, position)
    offset = position - moving.scene.own_ship.pose(moving.scene.radar.time_of_spokes(crossing)).position
    off = np.arctan2(offset[:, 0], offset[:, 1]) - crossing * 2 * np.pi / 2048
    assert np.abs(np.angle(np.exp(1j * off))).max() < 1e-8  # rad: 3e-6 azimuths


def test_a_swaying_antenna_crosses_where_its_tilted_boresight_points() -> None:
    """By own rotations of the deck: 12 degrees in 9 s, and pitch and yaw."""
    moving = track(heading_deg=40, course_deg=40, speed_kn=8, **SWAY)
    part = moving.between(3000.0, 3066.0)
    middle = moving.antenna(np.array([part.middle]))[0]
    bearing = moving.bearing(np.linspace(3002, 3064, 25))
    distance = np.geomspace(150, 3000, 25)
    position = middle + np.stack([distance * np.sin(bearing), distance * np.cos(bearing), np.linspace(-15, 20, 25)], axis=1)
    crossing = crossings(part, position)
    for n, point in zip(crossing, position, strict=True):
        time = moving.scene.radar.time_of_spokes(np.array([n]))
        matrices, headings = deck(time, np.deg2rad(40))
        own = moving.scene.own_ship.pose(time).position[0] * [1, 1, 0] + HEIGHT * matrices[0][:, 2]
        offset = point - own
        offset[2] -= (offset[0] ** 2 + offset[1] ** 2) / (2 * 4 / 3 * 6_371_000)
        x, y, _ = matrices[0].T @ offset
        off = np.arctan2(x, y) + headings[0] - n * 2 * np.pi / 2048
        assert abs(np.angle(np.exp(1j * off))) < 1e-6  # rad: 0.5 % of a piece cubed


@pytest.mark.parametrize(
    "own", [{"course_deg": 70, "speed_kn": 8}, {"heading_deg": 40, "course_deg": 40, "speed_kn": 8, **SWAY}]
)
def test_points_on_boresight_are_crossed_there(own: dict[str, Any]) -> None:
    """Height and distance are those requested; the crossing of each is its azimuth again (1e-6 rad, see above)."""
    moving = track(**own)
    number = np.linspace(3001.0, 3063.0, 9)
    points = moving.points_on_boresight(number, np.array([180.0, 2000.0]), 2.0)
    assert np.allclose(points[..., 2], 2.0, rtol=0, atol=1e-9)
    for at, distance in zip(points, (180.0, 2000.0), strict=True):
        ground = np.hypot(*(at - moving.antenna(number))[:, :2].T)
        assert np.allclose(ground, distance, rtol=1e-12)
        assert np.abs(crossings(moving.between(2999.0, 3065.0), at) - number).max() < 1e-6 / moving.scene.radar.azimuth_step


def test_own_ship_moves_before_the_start_as_it_begins() -> None:
    """It rests there; for what the beam passes later it goes on backward, so nothing has a corner."""
    moving = track(course_deg=90, speed_kn=10)
    east = moving.antenna(np.arange(-80.0, 81.0, 40.0))[:, 0]
    assert np.allclose(np.diff(east), 40 * moving.scene.radar.spoke_period * 10 * KNOT, rtol=0, atol=1e-9)
    assert moving.is_smooth(-100.0, 100.0)


def test_corners_of_the_course_are_found() -> None:
    """A waypoint 100 m ahead at 10 kn: after 19.44 s, azimuth 15,925."""
    points = [{"position_m": [100.0, 0.0], "speed_kn": 10.0}, {"position_m": [100.0, 100.0], "speed_kn": 10.0}]
    moving = track(waypoints=points)
    corner = 100 / (10 * KNOT) / moving.scene.radar.spoke_period
    assert not moving.is_smooth(corner - 10.0, corner + 10.0)
    assert moving.is_smooth(corner - 100.0, corner - 10.0) and moving.is_smooth(corner + 10.0, corner + 100.0)
