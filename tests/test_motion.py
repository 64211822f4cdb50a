"""Ships that roll, pitch, yaw and turn, through the whole engine and against own arithmetic."""

from typing import Any

import numpy as np

import radar_service as rs
from radar_service.numerics.constants import KNOT
from radar_service.numerics.types import Floats
from radar_service.world.body import Body
from tests.reference.point_scene import error_db, polar_of
from tests.scenes import point, scene

SWAY = {"roll_deg": 12, "roll_period_s": 9, "pitch_deg": 5, "pitch_period_s": 6, "yaw_deg": 4, "yaw_period_s": 17}


def turn(axis: str, angle: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Right-handed rotation matrices (K, 3, 3) about an axis, from Rodrigues' formula."""
    n = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}[axis]
    cross = np.cross(np.eye(3), n)
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    return c * np.eye(3) + (1 - c) * np.outer(n, n) + s * cross


def deck(time: np.ndarray[Any, Any], heading: float) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Deck-to-map matrices and headings at each time of a ship swaying as SWAY says."""
    roll, pitch, yaw = (
        np.deg2rad(SWAY[f"{k}_deg"]) * np.sin(2 * np.pi * time / SWAY[f"{k}_period_s"]) for k in ("roll", "pitch", "yaw")
    )
    return turn("z", -(heading + yaw)) @ turn("x", pitch) @ turn("y", roll), heading + yaw


def test_a_swaying_ship_sees_points_as_the_closed_form_does() -> None:
    """Mast, tilted beam and lifted elevation at every instant, own rotations: -40 dB (required); the elevation gain is a
    parabola over 16 azimuths, the bearing too, and the pattern is taken along the tilted antenna's own axes."""
    rng, bodies = np.random.default_rng(4), []
    for i in range(6):
        r, azimuth, up = rng.uniform(150, 1900), rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 30)
        bodies.append(point(f"p{i}", r * np.sin(azimuth), r * np.cos(azimuth), up, 40 * np.log10(r / 100)))
    own = {"heading_deg": 40, "course_deg": 40, "speed_kn": 8, **SWAY}
    made = scene(bodies, radar={"range_max_m": 2000, "beamwidth_el_deg": 9}, own_ship=own)
    sim = rs.Simulator(made)
    sim.scan()
    scan = sim.scan()
    ahead = np.deg2rad(40)

    def polar(of: rs.Scene, body: Body, time: Floats) -> tuple[Floats, Floats, Floats]:
        """About the antenna's own axes; bearings true."""
        to_map, heading = deck(time, ahead)
        way = 8 * KNOT * time[:, None] * np.array([np.sin(ahead), np.cos(ahead), 0])
        offset = body.motion.position[0] - way - of.radar.height * to_map[:, :, 2]
        offset[:, 2] -= np.sum(offset[:, :2] ** 2, axis=1) / (2 * 4 / 3 * 6_371_000.0)
        x, y, z = np.einsum("kij,ki->jk", to_map, offset)
        return np.linalg.norm(offset, axis=1), np.arctan2(x, y) + heading, np.arctan2(z, np.hypot(x, y))

    assert error_db(made, scan, every=3, polar=polar) < -45
    np.testing.assert_allclose(scan.heading, deck(scan.time, ahead)[1] % (2 * np.pi), atol=1e-12)


def test_yaw_turns_the_ship_but_not_the_picture() -> None:
    """The gyro keeps the feed in true bearings: yaw moves the heading and the blind sector, a target stays put."""
    own = {"yaw_deg": 20, "yaw_period_s": 5.0}
    ring = [point(f"p{a}", 800 * np.sin(a), 800 * np.cos(a), rcs_dbsm=-20) for a in range(1, 7)]  # received all round
    radar = {"range_max_m": 1000, "blind_sectors_deg": [[90, 100]], "beamwidth_deg": 6}
    made = scene([point("t", 0, 800), *ring], radar=radar, own_ship=own)
    still = scene([point("t", 0, 800), *ring], radar=radar)
    swung, upright = rs.Simulator(made).scan(), rs.Simulator(still).scan()
    assert np.argmax(swung.power.max(axis=1)) == np.argmax(upright.power.max(axis=1)) == 0
    silent = swung.azimuth[swung.power.max(axis=1) == 0.0]
    expected = (swung.azimuth - swung.heading) % (2 * np.pi)
    inside = (expected >= np.deg2rad(90) - 1e-9) & (expected <= np.deg2rad(100) + 1e-9)
    np.testing.assert_array_equal(silent, swung.azimuth[inside])
    assert inside.sum() > 3 and abs(np.rad2deg(swung.heading[180]) - 20 * np.sin(2 * np.pi * swung.time[180] / 5)) < 1e-9


def test_a_turning_ship_is_where_its_arc_puts_it() -> None:
    """A point on a rounded square: the field at every azimuth is the closed form at its position by own arithmetic (-50 dB)."""
    corners = [{"position_m": list(p), "speed_kn": 15} for p in [(700, 500), (700, 700), (500, 700)]]
    body = point("t", 500, 500, waypoints=corners, loop=True, turn_radius_m=60)
    made = scene([body], radar={"range_max_m": 1500, "rpm": 48, "azimuths": 360, "beamwidth_deg": 3.9})
    sim = rs.Simulator(made)

    def polar(of: rs.Scene, body: Body, time: Floats) -> tuple[Floats, Floats, Floats]:
        return polar_of(of, np.array([[*on_the_square(15 * KNOT * t), 0.0] for t in time]))

    for number in range(12):  # 15 s at 15 kn: a straight of 80 m and an arc of 94 m
        scan = sim.scan()
        if number in (0, 4, 8, 11):  # on the arc, over its end, on the straight
            assert error_db(made, scan, polar=polar) < -50, number


def on_the_square(geometry: float) -> tuple[float, float]:
    """East, north after `geometry` metres round the square 500..700 with corners of radius 60, sailed leftward from the middle of
    the arc at (500, 500)."""
    side, radius = 200.0 - 2 * 60.0, 60.0
    quarter = np.pi / 2 * radius
    number, rest = divmod(geometry + quarter / 2, side + quarter)  # a corner and the straight after it
    k = int(number) % 4
    centre = np.array([(560.0, 560.0), (640.0, 560.0), (640.0, 640.0), (560.0, 640.0)][k])
    ahead = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][k])  # along the straight after the corner
    outward = np.array([ahead[1], -ahead[0]])
    if rest > quarter:
        position = centre + radius * outward + (rest - quarter) * ahead
    else:
        before = np.pi / 2 - rest / radius  # of the arc still to sail
        position = centre + radius * (np.cos(before) * outward - np.sin(before) * ahead)
    return float(position[0]), float(position[1])
