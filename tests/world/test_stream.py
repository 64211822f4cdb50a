"""A tidal stream: course and speed are over ground, the heading is that of the motion through the water."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.constants import KNOT
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Floats
from radar_service.scene_file.load import load_scene
from radar_service.truth.truth_file import scene_hash
from radar_service.world.motion import Motion
from radar_service.world.seaway import NO_STREAM, crab_angle, through_water, turn_factor
from radar_service.world.steering import Steering

STREAM: dict[str, Any] = {"current_kn": 3.0, "current_to_deg": 60.0}
TO = 3.0 * KNOT * np.array([math.sin(math.radians(60.0)), math.cos(math.radians(60.0))])
STEP = 1e-3  # s, of numerical derivatives
SPEEDS: dict[str, Any] = {"course_deg": 200.0, "speed_kn": 9.0}
RADAR = {"azimuths": 8, "range_max_m": 900, "coarse_azimuths": True}
ROUTE = [{"position_m": p, "speed_kn": s} for p, s in (([0, 500], 8), ([600, 500], 5), ([600, -300], 12))]
TURNS = [{"time_s": 20, "course_deg": 90, "turn_rate_deg_s": 3}, {"time_s": 70, "speed_kn": 4},
         {"time_s": 80, "turn_rate_deg_s": -2}, {"time_s": 130, "speed_kn": 14}]  # fmt: skip
MOVING: dict[str, dict[str, Any]] = {"straight": SPEEDS, "drift": {**SPEEDS, "drift_deg": -7.0},
                                     "circle": {**SPEEDS, "turn_rate_deg_s": 2.0}, "waypoints": {"waypoints": ROUTE},
                                     "rounded": {"waypoints": ROUTE, "turn_radius_m": 90, "loop": True, "drift_deg": 4.0},
                                     "manoeuvres": {**SPEEDS, "manoeuvre": TURNS}, "track": {"track": "t.csv"}}  # fmt: skip
TRACK = "time_s,east_m,north_m\n0,0,0\n60,200,100\n150,100,500\n300,900,500\n"


def motions(folder: Path, keys: dict[str, Any], **environment: Any) -> tuple[Motion, Motion]:
    """The motion of own ship with these keys, and that of a body with the same."""
    (folder / "t.csv").write_text(TRACK)
    body = {"name": "b", "shape": "point", "rcs_dbsm": 0, **keys}
    made = load_scene({"environment": STREAM | environment, "own_ship": keys, "body": [body]}, folder=folder)
    return made.own_ship, made.bodies[0].motion


def water_course(motion: Motion, time: Floats) -> Floats:
    """Course through the water from positions alone: central differences, less the stream."""
    position = motion.pose(np.concatenate([time + STEP, time - STEP])).position[:, :2]
    over_ground = (position[: len(time)] - position[len(time) :]) / (2.0 * STEP)
    return np.arctan2(*(over_ground - TO).T)


def test_a_course_across_the_stream_is_the_worked_triangle() -> None:
    """10 knots to the north over ground in a stream of 2 knots to the east: the ship heads to port, by atan(2 / 10)."""
    own = load_scene({"environment": {"current_kn": 2, "current_to_deg": 90}, "own_ship": {"speed_kn": 10, "course_deg": 0}})
    truth = rs.Simulator(own).truth(7.0).own_ship
    assert math.degrees(truth.heading) == pytest.approx(360.0 - math.degrees(math.atan(0.2)), abs=1e-9)  # rounding
    assert truth.water_speed == pytest.approx(math.sqrt(104.0) * KNOT, rel=1e-12) and truth.water_course == truth.heading
    assert (math.degrees(truth.course) % 360.0, truth.speed) == pytest.approx((0.0, 10.0 * KNOT), abs=1e-9)


@pytest.mark.parametrize("kind", MOVING)
def test_the_heading_is_the_course_through_the_water(kind: str, tmp_path: Path) -> None:
    """Less the drift; the numerical derivative errs by the square of its step times the jerk, below 1e-6 m/s."""
    keys = MOVING[kind]
    time = np.linspace(0.5, 170.0, 97)
    for motion in motions(tmp_path, keys):
        near = np.abs(time[:, None] - (motion.time % (motion.period or math.inf))).min(axis=1) < 2 * STEP
        t = time[~near]
        expected = water_course(motion, t) - math.radians(keys.get("drift_deg", 0.0))
        assert np.abs(wrap_angle(motion.pose(t).heading - expected)).max() < 1e-6
        ahead, behind = motion.pose(t + STEP).heading, motion.pose(t - STEP).heading
        assert motion.turn_rate(t) == pytest.approx(wrap_angle(ahead - behind) / (2.0 * STEP), abs=1e-6)


@pytest.mark.parametrize("kind", MOVING)
def test_a_stream_moves_nobody_over_ground(kind: str, tmp_path: Path) -> None:
    time = np.linspace(0.0, 400.0, 41)
    for with_stream, without in zip(
        motions(tmp_path, MOVING[kind]), motions(tmp_path, MOVING[kind], current_kn=0.0, current_to_deg=None), strict=True
    ):
        assert with_stream.pose(time).position.tolist() == without.pose(time).position.tolist()
        assert with_stream.pose(time).velocity.tolist() == without.pose(time).velocity.tolist()


def test_who_stands_keeps_a_heading(tmp_path: Path) -> None:
    """A buoy that of the file; a ship at its last waypoint the one with which it arrived; and a heading that is given stays."""
    for motion in motions(tmp_path, {"heading_deg": 77.0}):
        assert motion.at_rest and motion.pose(5.0).heading[0] == pytest.approx(math.radians(77.0), abs=1e-12)
    for kind in ("waypoints", "rounded"):
        ship, _ = motions(tmp_path, {**MOVING[kind], "loop": False})
        end = float(ship.time[-1])
        before, after = ship.pose(np.array([end - 1e-6, end + 100.0])).heading
        assert after == pytest.approx(before, abs=1e-9) and ship.pose(end + 1.0).speed[0] == 0.0
    for motion in motions(tmp_path, {**SPEEDS, "heading_deg": 10.0}):
        assert math.degrees(motion.pose(9.0).heading[0]) == pytest.approx(10.0, abs=1e-9)


def test_commands_steer_over_ground_and_the_heading_follows() -> None:
    """A turn, a stop, a new start and a heading that is ordered; the stop keeps the heading."""
    own = load_scene({"environment": STREAM, "own_ship": {**SPEEDS, "steerable": {"max_turn_rate_deg_s": 4.0}}})
    steering = Steering(own)
    for time, command in (
        (10.0, {"course_deg": 300.0}), (60.0, {"speed_kn": 0.0}), (80.0, {"speed_kn": 6.0}),
        (100.0, {"heading_deg": 310.0}),
    ):  # fmt: skip
        steering.add(None, None, command, reached=10**9, time=time)
    motion = steering.past.own_ship
    t = np.array([5.0, 20.0, 33.0, 50.0, 90.0])
    assert np.abs(wrap_angle(motion.pose(t).heading - water_course(motion, t))).max() < 1e-6
    headings = motion.pose(np.array([59.999, 60.001, 79.999])).heading
    assert headings == pytest.approx(headings[0], abs=1e-9)
    assert np.rad2deg(motion.pose(np.array([100.5, 150.0])).heading) == pytest.approx(310.0, abs=1e-9)
    steering.add(None, None, {"course_deg": 0.0}, reached=10**9, time=160.0)  # the leeway that was ordered stays
    leeway = wrap_angle(motion.pose(155.0).heading - water_course(motion, np.array([155.0])))
    later = np.array([165.0, 230.0])
    assert wrap_angle(motion.pose(later).heading - water_course(motion, later)) == pytest.approx(leeway[0], abs=1e-6)


def test_the_log_measures_the_water() -> None:
    """A log that shows a tenth too much errs by a tenth of the speed through the water, here 8 of 10 knots over ground."""
    scene = {"environment": {"current_kn": 2, "current_to_deg": 0}, "own_ship": {"speed_kn": 10, "course_deg": 0},
             "radar": RADAR, "errors": {"log": {"scale_percent": 10.0}}}  # fmt: skip
    scan = simulator_of(scene).scan()
    assert scan.speed == pytest.approx(10.8 * KNOT, rel=1e-12)


def test_the_truth_tells_both_of_bodies_and_own_ship() -> None:
    """A buoy that stands goes through the water as fast as the stream, the other way."""
    body = {"name": "buoy", "shape": "point", "rcs_dbsm": 20, "position_m": [500, 0, 2]}
    simulator = simulator_of({"environment": STREAM, "own_ship": SPEEDS, "body": [body], "radar": RADAR})
    over_ground = 9.0 * KNOT * np.array([math.sin(math.radians(200.0)), math.cos(math.radians(200.0))])
    water = over_ground - TO
    (buoy,) = simulator.truth(1.0).bodies
    (crossing,), snapshot = simulator.crossings(0), simulator.snapshot(0)
    for one in (buoy, crossing, snapshot.bodies[0]):
        assert one.water_speed == pytest.approx(3.0 * KNOT, rel=1e-12) and one.speed == 0.0
        assert one.water_course == pytest.approx(math.radians(240.0), abs=1e-12)
    for own in (simulator.truth(1.0).own_ship, crossing.own_ship, snapshot.own_ship):
        assert own.water_speed == pytest.approx(math.hypot(*water), rel=1e-12)
        assert own.water_course == pytest.approx(math.atan2(*water) % (2 * math.pi), abs=1e-12)
        assert own.speed == pytest.approx(9.0 * KNOT, rel=1e-12)
    still = simulator_of({"own_ship": SPEEDS, "body": [body], "radar": RADAR})
    assert still.truth(1.0).own_ship.water_speed is None and still.crossings(0)[0].water_course is None


def test_what_drifts_with_the_stream_has_no_other_course() -> None:
    velocity = np.array([[0.0, 0.0], [3.0, 4.0], [-3.0, -4.0]])
    assert crab_angle(velocity, (3.0, 4.0)).tolist() == [0.0, 0.0, 0.0]
    assert turn_factor(velocity, (3.0, 4.0)).tolist() == [1.0, 1.0, 0.5]
    course, speed = through_water(velocity[1], np.array(0.7), (3.0, 4.0))
    assert (float(course), float(speed)) == (0.7, 0.0)


def test_a_scene_without_a_stream_keeps_its_hash() -> None:
    plain, with_stream = ({"own_ship": SPEEDS}, {"own_ship": SPEEDS, "environment": STREAM})
    hashes = [scene_hash(load_scene(each)) for each in (plain, with_stream)]
    assert hashes[0] != hashes[1] and load_scene(plain).own_ship.stream == NO_STREAM


def simulator_of(scene: dict[str, Any]) -> rs.Simulator:
    return rs.Simulator(load_scene(scene), fidelity="fast")
