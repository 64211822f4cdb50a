"""Areas with a tidal stream: shares and gradients against slow code, and ships whose headings follow the water where they are."""

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
from radar_service.world.currents import NO_CURRENTS, CurrentArea, Currents
from radar_service.world.motion import Motion
from radar_service.world.steering import Steering
from tests.world.test_stream import MOVING, RADAR, SPEEDS, TRACK

STEP = 1e-3  # s and m, of numerical derivatives
SQUARE = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
HORSESHOE = (
    (0.0, 0.0),
    (400.0, 0.0),
    (400.0, 300.0),
    (250.0, 300.0),
    (250.0, 120.0),
    (150.0, 120.0),
    (150.0, 300.0),
    (0.0, 300.0),
)
AREAS = {
    "square": CurrentArea((1.0, 0.5), 60.0, SQUARE),
    "horseshoe": CurrentArea((-1.0, 2.0), 80.0, HORSESHOE),
    "horseshoe the other way round": CurrentArea((-1.0, 2.0), 80.0, HORSESHOE[::-1]),
    "circle": CurrentArea((0.3, -0.7), 120.0, ((50.0, -20.0),), 150.0),
}


def slow_depth(area: CurrentArea, east: float, north: float) -> float:
    """Depth behind the border, by the smallest distance from 2000 points on each edge and the sum of angles."""
    if area.radius:
        return area.radius - math.dist(area.corners[0], (east, north))
    nearest, angle = math.inf, 0.0
    for (x, y), (u, v) in zip(area.corners, area.corners[1:] + area.corners[:1], strict=True):
        share = np.linspace(0.0, 1.0, 2001)
        nearest = min(nearest, float(np.hypot(x + share * (u - x) - east, y + share * (v - y) - north).min()))
        angle += math.remainder(math.atan2(v - north, u - east) - math.atan2(y - north, x - east), 2.0 * math.pi)
    return nearest if abs(angle) > math.pi else -nearest


@pytest.mark.parametrize("name", AREAS)
def test_shares_are_those_of_the_depth_behind_the_border(name: str) -> None:
    """The slow depth errs by the square of half of its step, 0.1 m, over twice the distance, and at most by 0.1 m: a share by
    1.5 / 60 of it. The derivative errs where the nearest edge changes, so a few points may."""
    area = AREAS[name]
    points = np.random.default_rng(5).uniform(-300.0, 600.0, (300, 2))
    share, gradient = area.share(points)
    for (east, north), value in zip(points.tolist(), share.tolist(), strict=True):
        u = min(max(slow_depth(area, east, north) / area.border + 0.5, 0.0), 1.0)
        assert value == pytest.approx(u * u * (3.0 - 2.0 * u), abs=2.5e-3)
    steps = [(area.share(points + step)[0] - area.share(points - step)[0]) / (2 * STEP) for step in STEP * np.eye(2)]
    errors = np.abs(np.stack(steps, axis=1) - gradient).max(axis=1)
    assert (share > 0.01).sum() > 20 and ((share > 0.01) & (share < 0.99)).sum() > 10
    assert np.sort(errors)[-3] < 1e-7  # the square of the step times the third derivative, 12 / border^3


def test_the_border_itself_and_corners_have_half_of_the_stream() -> None:
    on = np.array([[100.0, 0.0], [0.0, -100.0], [100.0, 100.0]])
    share, gradient = AREAS["square"].share(on)
    assert share.tolist() == [0.5, 0.5, 0.5]
    assert gradient[:2] == pytest.approx(np.array([[-1.5 / 60.0, 0.0], [0.0, 1.5 / 60.0]]), abs=1e-15)
    assert AREAS["circle"].share(np.array([[50.0, -20.0], [50.0, 130.0]]))[0].tolist() == [1.0, 0.5]


def test_neighbours_pass_over_into_each_other_and_streams_add() -> None:
    """Two areas of one stream with a common border are one; a third one adds to them."""
    west, east = (CurrentArea((2.0, 0.0), 50.0, tuple((x + shift, y) for x, y in SQUARE)) for shift in (-100.0, 100.0))
    points = np.stack([np.linspace(-120.0, 120.0, 49), np.full(49, 10.0)], axis=1)
    assert Currents((0.0, 0.0), (west, east)).at(points) == pytest.approx(np.tile([2.0, 0.0], (49, 1)), abs=1e-15)
    circle = CurrentArea((0.0, 1.0), 10.0, ((0.0, 0.0),), 30.0)
    assert Currents((0.5, -0.25), (west, east, circle)).at(np.array([0.0, 0.0, 7.0])).tolist() == [2.5, 0.75]
    assert not NO_CURRENTS and Currents((0.0, 0.1)) and Currents(areas=(circle,))


def motions(folder: Path, keys: dict[str, Any], **scene: Any) -> tuple[Motion, Currents]:
    """The motion of own ship with these keys in two areas and a stream everywhere, which reach over her way."""
    (folder / "t.csv").write_text(TRACK)
    made = load_scene({**CURRENTS, "own_ship": keys, **scene}, folder=folder)
    return made.own_ship, made.environment.currents


CURRENTS: dict[str, Any] = {
    "environment": {"current_kn": 0.5, "current_to_deg": 200},
    "current": [
        {
            "current_kn": 3.0,
            "current_to_deg": 60,
            "corners_m": [[-900, 100], [300, 100], [300, 900], [-900, 900]],
            "border_m": 150,
        },
        {"current_kn": 2.0, "current_to_deg": 310, "position_m": [0, -250], "radius_m": 300, "border_m": 100},
    ],
}


def water_course(motion: Motion, currents: Currents, time: Floats) -> Floats:
    """Course through the water from positions alone: central differences, less the stream there."""
    position = motion.pose(np.concatenate([time + STEP, time - STEP])).position[:, :2]
    over_ground = (position[: len(time)] - position[len(time) :]) / (2.0 * STEP)
    return np.arctan2(*(over_ground - currents.at(motion.pose(time).position)).T)


@pytest.mark.parametrize("kind", MOVING)
def test_the_heading_is_the_course_through_the_water_of_the_place(kind: str, tmp_path: Path) -> None:
    """Less the drift; and it turns as fast as numerical derivatives say. Nobody moves over ground."""
    keys = MOVING[kind]
    motion, currents = motions(tmp_path, keys)
    time = np.linspace(0.5, 170.0, 97)
    t = time[np.abs(time[:, None] - (motion.time % (motion.period or math.inf))).min(axis=1) > 2 * STEP]
    streams = currents.at(motion.pose(t).position)
    assert len(np.unique(streams.round(6), axis=0)) > 10  # she crosses borders
    expected = water_course(motion, currents, t) - math.radians(keys.get("drift_deg", 0.0))
    assert np.abs(wrap_angle(motion.pose(t).heading - expected)).max() < 1e-6
    ahead, behind = motion.pose(t + STEP).heading, motion.pose(t - STEP).heading
    errors = np.sort(np.abs(motion.turn_rate(t) - wrap_angle(ahead - behind) / (2.0 * STEP)))
    assert errors[-2] < 1e-6 and errors[-1] < 1e-4  # one may lie where the nearest edge changes
    without, _ = motions(tmp_path, keys, environment={}, current=[])
    assert motion.pose(time).position.tolist() == without.pose(time).position.tolist()


def test_a_ship_in_a_seaway_follows_the_water_of_the_place_beside_her_yaw(tmp_path: Path) -> None:
    """Upright she heads as without waves; the bounds of her sway hold on any heading, as those of a steered ship."""
    waves = {"environment": {**CURRENTS["environment"], "sea_state": 4, "seaway": True}}
    own = {**MOVING["straight"], "position_m": [100, 300]}
    motion, currents = motions(tmp_path, own, **waves)
    without, _ = motions(tmp_path, own)
    time = np.linspace(0.0, 120.0, 25)
    upright = motion.upright(time)
    assert upright.heading.tolist() == without.upright(time).heading.tolist()
    assert upright.turn_rate == pytest.approx(without.turn_rate(time), abs=0.0)
    assert np.ptp(upright.heading) > 0.1 and motion.sway is not None
    assert motion.pose(time).heading == pytest.approx(upright.heading % (2 * np.pi), abs=0.2)
    on_one_course, _ = motions(tmp_path, own, **waves, current=[])
    assert on_one_course.sway is not None and motion.sway.max_tilt > on_one_course.sway.max_tilt


@pytest.mark.parametrize("kind", MOVING)
def test_an_area_around_all_is_a_stream_everywhere(kind: str, tmp_path: Path) -> None:
    stream = {"current_kn": 3.0, "current_to_deg": 60.0}
    around = [{**stream, "position_m": [0, 0], "radius_m": 100_000}]
    own, _ = motions(tmp_path, MOVING[kind], environment={}, current=around)
    other, _ = motions(tmp_path, MOVING[kind], environment=stream, current=[])
    time = np.linspace(0.0, 500.0, 101)
    assert np.abs(wrap_angle(own.pose(time).heading - other.pose(time).heading)).max() < 1e-12  # rounding
    assert own.turn_rate(time) == pytest.approx(other.turn_rate(time), abs=1e-12)


def test_who_stands_keeps_a_heading(tmp_path: Path) -> None:
    for kind in ("waypoints", "rounded"):
        ship, _ = motions(tmp_path, {**MOVING[kind], "loop": False})
        end = float(ship.time[-1])
        before, after = ship.pose(np.array([end - 1e-6, end + 100.0])).heading
        assert after == pytest.approx(before, abs=1e-8) and ship.turn_rate(end + 1.0)[0] == 0.0
    given, _ = motions(tmp_path, {**SPEEDS, "heading_deg": 10.0})
    assert np.rad2deg(given.pose(np.array([0.0, 90.0])).heading) == pytest.approx(10.0, abs=1e-9)
    resting, _ = motions(tmp_path, {"heading_deg": 77.0})
    assert resting.at_rest


def test_commands_steer_over_ground_and_the_heading_follows_the_place() -> None:
    """A turn, a jump into another area, a stop, a new start, and leeway that is ordered; `segment_at` goes on from there."""
    own = load_scene({**CURRENTS, "own_ship": {"course_deg": 0, "speed_kn": 12, "steerable": {"max_turn_rate_deg_s": 4.0}}})
    steering, currents = Steering(own), own.environment.currents
    for time, command in (
        (10.0, {"course_deg": 300.0}), (40.0, {"position_m": [160.0, -420.0], "course_deg": 20.0}), (100.0, {"speed_kn": 0.0}),
        (120.0, {"speed_kn": 6.0}), (130.0, {"heading_deg": 310.0}),
    ):  # fmt: skip
        steering.add(None, None, command, reached=10**9, time=time)
    motion = steering.past.own_ship
    t = np.array([5.0, 15.0, 35.0, 45.0, 57.0, 75.0, 90.0, 125.0])
    assert np.abs(wrap_angle(motion.pose(t).heading - water_course(motion, currents, t))).max() < 1e-6
    assert len(np.unique(currents.at(motion.pose(t).position).round(3), axis=0)) == 5
    assert 0.05 < currents.areas[1].share(motion.pose(110.0).position[:, :2])[0][0] < 0.95  # she stands on a border
    headings = motion.pose(np.array([99.999, 100.001, 119.999])).heading
    assert headings == pytest.approx(headings[0], abs=1e-5)  # she turns until she stands
    leeway = wrap_angle(motion.pose(t[-1:] + 10.0).heading - water_course(motion, currents, t[-1:] + 10.0))
    assert np.rad2deg(motion.pose(130.0).heading) == pytest.approx(310.0, abs=1e-9)
    later = np.array([150.0, 300.0])
    assert wrap_angle(motion.pose(later).heading - water_course(motion, currents, later)) == pytest.approx(
        leeway[0], abs=1e-6
    )


def test_log_and_truth_are_those_of_the_water_of_the_place() -> None:
    """The first body stands in the square, the other one outside of all; own ship leaves the circle."""
    bodies = [{"name": name, "shape": "point", "rcs_dbsm": 20, "position_m": place}
              for name, place in (("in", [-300, 500, 2]), ("out", [700, -600, 2]))]  # fmt: skip
    own = {"course_deg": 80, "speed_kn": 10, "position_m": [-280, -250]}
    scene = {**CURRENTS, "radar": RADAR, "own_ship": own, "body": bodies, "errors": {"log": {"scale_percent": 10.0}}}
    simulator = rs.Simulator(load_scene(scene), fidelity="fast")
    base = 0.5 * KNOT * np.array([math.sin(math.radians(200)), math.cos(math.radians(200))])
    square = base + 3.0 * KNOT * np.array([math.sin(math.radians(60)), math.cos(math.radians(60))])
    inside, outside = simulator.truth(1.0).bodies
    assert inside.water_speed == pytest.approx(math.hypot(*square), rel=1e-12)
    assert outside.water_speed == pytest.approx(0.5 * KNOT, rel=1e-12)
    speeds = []
    for _ in range(3):
        scan = simulator.scan()
        for time, speed in zip(scan.time.tolist(), scan.speed.tolist(), strict=True):
            truth = simulator.truth(time).own_ship
            assert truth.water_speed is not None
            assert speed - truth.speed == pytest.approx(0.1 * truth.water_speed, rel=1e-9)
            assert truth.water_course == pytest.approx(truth.heading, abs=1e-12)
            speeds.append(truth.water_speed)
    assert max(speeds) - min(speeds) > 0.1
    (crossing, *_) = simulator.crossings(0)
    assert crossing.water_speed is not None and crossing.own_ship.water_speed in [pytest.approx(s, abs=0.05) for s in speeds]


def test_scenes_without_areas_keep_their_hash() -> None:
    """A scene with a stream has that of the commit before areas: nothing of it is rounded. An area changes it."""
    own = {"course_deg": 0.0, "speed_kn": 9.0, "steerable": {}}
    scene = {"own_ship": own, "environment": {"current_kn": 3.0, "current_to_deg": 0.0}}
    assert scene_hash(load_scene(scene)) == HASH
    assert scene_hash(load_scene(scene | {"current": CURRENTS["current"]})) != HASH


HASH = "90e531eb6b6bddfc99dd12d6865e416acf6a4b618cd4a1c092044b27ed7eacca"
