"""Visibility of moving bodies: how often it is renewed, and which echoes a snapshot finds around a boresight."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.visibility import VisibilitySnapshot, mast_speed, visibility_interval
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.constants import KNOT
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes
from tests.scenes import point, scene
from tests.test_motion import SWAY

RADAR = {"range_max_m": 2000, "azimuths": 360, "beamwidth_deg": 4, "height_m": 20}


def under_way(own_ship: dict[str, Any] | None = None, count: int = 24) -> rs.Scene:
    bodies = []
    for k in range(count):
        azimuth = 2 * np.pi * k / count
        position = (300 + 50 * k) * np.array([np.sin(azimuth), np.cos(azimuth)])
        bodies.append(point(f"p{k}", float(position[0]), float(position[1]), course_deg=15 * k, speed_kn=10))
    return scene(bodies, radar=RADAR, own_ship=own_ship or {})


def prepared(made: rs.Scene) -> Prepared:
    return prepare(made, PRESETS["balanced"], 3)


def test_the_interval_follows_from_the_top_speeds() -> None:
    """Own ship 12 kn, the fastest body 30 kn: 5 m take 5 / 21.6 s. At 1 mm/s it is one scan."""
    bodies = [point("a", 0, 500, course_deg=0, speed_kn=30), point("b", 500, 0, course_deg=90, speed_kn=20)]
    made = scene(bodies, radar=RADAR, own_ship={"course_deg": 180, "speed_kn": 12})
    assert visibility_interval(made, 5.0) == pytest.approx(5.0 / (42 * KNOT), rel=1e-12)
    slow = scene([point("a", 0, 500, course_deg=0, speed_kn=0.001)], radar=RADAR)
    assert visibility_interval(slow, 5.0) == slow.radar.rotation_period
    assert visibility_interval(scene([point("a", 0, 500)], radar=RADAR), 5.0) == made.radar.rotation_period


def test_sway_counts_as_speed_of_the_mast() -> None:
    """20 m of mast: roll 12 degrees in 9 s and pitch 5 in 6 s move its top by 2.92 and 1.83 m/s at most."""
    made = under_way({"heading_deg": 40, **SWAY})
    roll, pitch = (20 * np.deg2rad(a) * 2 * np.pi / t for a, t in ((12, 9), (5, 6)))
    assert mast_speed(made) == pytest.approx(roll + pitch, rel=1e-12)
    assert visibility_interval(made, 5.0) == pytest.approx(5.0 / (roll + pitch + 10 * KNOT), rel=1e-12)


@pytest.mark.parametrize(
    "own", [{"course_deg": 200, "speed_kn": 25}, {"heading_deg": 40, "course_deg": 40, "speed_kn": 8, **SWAY}]
)
def test_nothing_moves_farther_than_a_step_within_an_interval(own: dict[str, Any]) -> None:
    """Every body relative to the antenna, over two hours of random instants; and some move by more than a half of it."""
    made = under_way(own)
    interval = visibility_interval(made, 5.0)
    start = np.random.default_rng(1).uniform(0, 7200, 3000)
    moved = []
    for body in made.bodies:
        relative = [body.motion.pose(t).position - made.antenna(t) for t in (start, start + interval)]
        moved.append(np.linalg.norm(relative[1] - relative[0], axis=1).max())
    assert 2.5 < max(moved) <= 5.0 * (1 + 1e-9)


def test_around_finds_all_echoes_within_the_sector_past_south() -> None:
    """Against every azimuth one by one, at boresights all round and more than once round; near ones are always there."""
    rng = np.random.default_rng(2)
    azimuth = rng.uniform(-np.pi, np.pi, 500)
    far, near = np.arange(40, 500), np.arange(40)
    order = far[np.argsort(azimuth[far])]
    echoes = BodyEchoes.of_points(np.zeros((500, 3)), np.ones(500, dtype=complex), np.zeros(500, dtype=np.int64))
    snapshot = VisibilitySnapshot(echoes, np.zeros((500, 3)), order=order, azimuth=azimuth[order], near=near, nearest=0.0)
    for boresight in [*np.linspace(-2 * np.pi, 4 * np.pi, 61), np.pi, -np.pi]:
        for half in (1e-3, 0.3, 2.0, 3.1):
            off = np.abs((azimuth - boresight + np.pi) % (2 * np.pi) - np.pi)
            expected = {*near.tolist(), *far[off[far] <= half].tolist()}
            result = snapshot.around(float(boresight), half)
            assert len(result) == len(set(result.tolist())) and set(result.tolist()) == expected
    assert sorted(snapshot.around(1.0, np.pi)) == list(range(500))


@pytest.mark.parametrize("number", [0, 3, 17, 400])
def test_a_snapshot_has_all_echoes_that_the_beam_meets_in_its_step(number: int) -> None:
    """Of those visible all round, each whose bearing comes within the beam's extent of the boresight at some time of the
    step, from a rolling ship under way; with positions of the middle of the step."""
    made = under_way({"heading_deg": 40, "course_deg": 40, "speed_kn": 8, **SWAY})
    engine = prepared(made)
    visibility, moving = engine.moving.visibility, engine.moving
    snapshot, everything = moving.snapshot(number), visibility.all_round(number)
    met = set()
    half = np.deg2rad(12 * 4)
    for time in np.linspace(number, number + 1, 50) * visibility.interval:
        boresight = 2 * np.pi * time / made.radar.rotation_period
        for b in everything.body.tolist():
            east, north, _ = made.bodies[b].motion.pose(time).position[0] - made.antenna(time)[0]
            if abs((np.arctan2(east, north) - boresight + np.pi) % (2 * np.pi) - np.pi) <= half:
                met.add(b)
    assert met and met <= set(snapshot.echoes.body.tolist())
    time = (number + 0.5) * visibility.interval
    for e, b in enumerate(snapshot.echoes.body):
        np.testing.assert_allclose(snapshot.position[e], made.bodies[b].motion.pose(time).position[0], rtol=0, atol=1e-9)


def test_a_step_is_computed_once() -> None:
    engine = prepared(under_way())
    first = engine.moving.snapshot(2)
    assert engine.moving.snapshot(2) is first and engine.moving.snapshot(3) is not first
