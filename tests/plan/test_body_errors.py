"""Errors predicted for bodies over a run: against the engine where it has them, else by hand."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.passage_nodes import MAX_PHASE, Part
from radar_service.numerics.constants import KNOT
from radar_service.plan.body_errors import (
    HORIZON,
    NODES,
    BodyError,
    aspects_db,
    body_error,
    body_remarks,
    body_run,
)
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.settings_search import fidelity_for
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import NEAREST
from radar_service.scattering.surface_sampling import density_db
from radar_service.world.steering import Steering
from tests.plan.scenes import HOUSE, SHIP, WAY, made
from tests.plan.test_predictions import error_db
from tests.scenes import point, scene

FINE = {"azimuths": 360, "beamwidth_deg": 3.9}
PLATE = {"name": "p", "shape": "plate", "width_m": 2, "height_m": 1, "heading_deg": 0, "scattering": "optics"}


def error_of(body: dict[str, Any], scatterers: int | None = None, **sections: Any) -> BodyError:
    world = made([body], **sections)
    return body_error(world.bodies[0], world, PRESETS["balanced"], scatterers)


def every_azimuth(passages: BeamPassages, n: int, crossing: int, time: float) -> tuple[Part, ...]:
    """Nodes at all azimuths within 12 beamwidths of a crossing, for `BeamPassages._scheduled`."""
    return (Part(-np.inf, np.inf, crossing + np.arange(-47, 48)),)


PASSES = {
    "5 m at 300 m": {"width_m": 5, "position_m": [-60, 300, 9], "speed_kn": 12, "course_deg": 90},
    "1 m at 90 m": {"width_m": 1, "position_m": [-20, 90, 9], "speed_kn": 25, "course_deg": 90},
    "5 m at 90 m": {"width_m": 5, "position_m": [-20, 90, 9], "speed_kn": 25, "course_deg": 90},
    "1 m ahead": {"width_m": 1, "position_m": [5, 600, 9], "speed_kn": 30, "course_deg": 180},
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", PASSES)
def test_aspects_err_no_more_than_predicted_at_any_time(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against one evaluation at every azimuth, while the body passes. The prediction is made before the first scan."""
    world = made([PLATE | PASSES[name]], FINE)
    chosen, errors = fidelity_for(world, ErrorBudget()), []
    for scan in (1, 4):
        planned, exact = (rs.Simulator(world, chosen) for _ in range(2))
        for sim in (planned, exact):
            sim.skip_to(scan)
        field = planned.scan().field
        with monkeypatch.context() as patch:
            patch.setattr(BeamPassages, "_scheduled", every_azimuth)
            errors.append(error_db(field, exact.scan().field))
    assert max(errors) < aspects_db(world)


def test_bodies_that_keep_their_aspect_have_no_such_error() -> None:
    at_rest = made([PLATE | {"position_m": [0, 500, 9]}])
    assert aspects_db(at_rest) == -math.inf
    assert error_of(PLATE | {"position_m": [0, 500, 9]}).field_db is None


def test_slow_and_far_bodies_err_less() -> None:
    near, far = (aspects_db(made([PLATE | {"position_m": [-50, north, 9], "speed_kn": 12, "course_deg": 90}]))
                 for north in (100, 1300))  # fmt: skip
    assert near == pytest.approx(20 * math.log10(NODES * MAX_PHASE**2), abs=0.1) and -65.0 <= far < -50.0


def test_surfaces_that_come_nearer_have_fewer_scatterers_in_a_cell() -> None:
    """From 762 m to 76 m: a tenth of them; where the body has more than that, by its least number, it is what it has."""
    house = HOUSE | {"heading_deg": 0, "position_m": [76.2, 758.2, 0], "speed_kn": 10, "course_deg": 180}
    error = error_of(house)
    assert error.power_db == pytest.approx(density_db(0.4), rel=0.01) and "0.4 scatterers" in error.remarks[0]
    assert (error_of(house, 100_000).power_db or 0.0) == pytest.approx(density_db(4.0))
    assert error_of(HOUSE).remarks == ()


def test_declared_hulls_err_between_visibility_steps_where_they_move() -> None:
    ship = SHIP | {"rcs_dbsm": 30, "position_m": [-30, 500, 0]}
    assert error_of(ship).power_db == 0.0
    assert error_of(ship | WAY, 400).power_db == pytest.approx(0.2)
    wide = error_of(ship | {"length_m": 200, "speed_kn": 12, "course_deg": 180}, 400)
    assert wide.power_db == pytest.approx(0.4) and "wider than the beam" in wide.remarks[0]
    assert error_of(ship | WAY, 1).power_db == 0.0


def test_a_much_longer_way_by_the_sea_is_stated_where_it_comes_to_be() -> None:
    """15 m and 10 m up: at 100 m the way by the sea is 2.93 m longer, a cell of 3.0 m; at 2 km 0.15 m."""
    sea = {"environment": {"multipath": True}}
    far = point("t", 0, 2000, 10)
    assert error_of(far, **sea).remarks == ()
    (remark,) = error_of(point("t", 100, 2000, 10, speed_kn=20, course_deg=180), **sea).remarks
    assert "0.98 range cells longer" in remark
    assert error_of(far | {"speed_kn": 20, "course_deg": 0}, **sea).remarks == ()
    crossing = point("t", 2000, 2000, 5, speed_kn=10, course_deg=270)
    assert error_of(crossing, own_ship={"speed_kn": 20, "course_deg": 0}, **sea).remarks == ()


def remarks(scene: rs.Scene, name: str) -> list[str]:
    return body_remarks(scene, PRESETS["balanced"])[name]


def test_the_closest_approach_is_stated_with_rates_where_anything_moves() -> None:
    """10 kn past at 300 m, abeam after 500 m: 97 s; 5.144 m/s over 300 m is 0.98 degrees/s. Rates are those within range."""
    world = made([point("t", 300, 500, speed_kn=10, course_deg=180)])
    assert remarks(world, "t") == ["nearest after 97 s: 300 m; its aspect turns by up to 0.98 degrees/s, its range by 5 m/s"]
    assert remarks(made([point("t", 300, 500)]), "t") == []


def test_what_is_steered_is_judged_beside_the_antenna() -> None:
    (remark,) = remarks(made([point("t", 300, 500, steerable={"max_speed_kn": 10, "max_turn_rate_deg_s": 2})]), "t")
    assert remark.startswith("commands may bring it anywhere") and "by up to 39 degrees/s, its range by 5.1 m/s" in remark


def test_metal_is_judged_by_its_mesh_and_others_by_their_errors() -> None:
    metal = SHIP | {"scattering": "optics", "position_m": [40, 1400, 0], "speed_kn": 20, "course_deg": 180}
    assert any("optics: facets" in remark for remark in remarks(made([metal]), "ship"))
    declared = made([metal | {"scattering": "rcs", "rcs_dbsm": 30}])
    assert any("its phases change at each visibility step" in remark for remark in remarks(declared, "ship"))


# Runs of bodies past the antenna, against hand arithmetic and dense samples of time.
def run_of(body: dict[str, Any], own: dict[str, Any] | None = None, **sections: Any) -> Any:
    made = scene([body], own_ship=own or {}, **sections)
    return body_run(made.bodies[0], made)


def test_a_straight_course_is_nearest_abeam() -> None:
    """40 kn south from 1300 m, 200 m aside: after 63.2 s; the aspect turns by v / d there, the range changes by v far off."""
    speed = 40 * KNOT
    run = run_of(point("t", 200, 1300, speed_kn=40, course_deg=180))
    assert (run.nearest, run.time) == pytest.approx((200.0, 1300 / speed), abs=1e-3)
    assert run.turn == pytest.approx(speed / 200.0, rel=1e-3)
    assert run.radial == pytest.approx(speed, rel=0.02)
    assert run.start == pytest.approx(math.hypot(200, 1300))


def test_lines_that_cross_at_other_times_are_no_approach() -> None:
    """Both go to the same point, 2000 m off, at 20 kn and 10 kn: 2000 m x sin(26.6 degrees) apart, 894 m."""
    run = run_of(point("t", 2000, 2000, speed_kn=10, course_deg=270), {"speed_kn": 20, "course_deg": 0})
    assert run.nearest == pytest.approx(2000 / math.sqrt(5), rel=1e-6)


def test_what_goes_away_is_nearest_now_and_what_rests_does_not_turn() -> None:
    away = run_of(point("t", 0, 700, speed_kn=20, course_deg=0))
    assert (away.nearest, away.time) == (700.0, 0.0)
    still = run_of(point("t", 0, 700))
    assert (still.turn, still.radial, still.nearest) == (0.0, 0.0, 700.0)


def test_sway_turns_the_aspect_of_what_rests() -> None:
    sway = {"roll_deg": 5, "roll_period_s": 8}
    run = run_of(point("t", 0, 700), sway, radar={"height_m": 20})
    assert run.turn == pytest.approx(20 * math.radians(5) * 2 * math.pi / 8 / 700, rel=0.01)


def test_the_nearest_part_of_a_body_counts() -> None:
    plate = {"name": "p", "shape": "plate", "width_m": 100, "height_m": 5, "rcs_dbsm": 20, "position_m": [0, 400, 0]}
    assert run_of(plate).nearest == pytest.approx(350.0)


@pytest.mark.parametrize("seed", range(6))
def test_no_sample_of_a_track_is_nearer_or_faster(seed: int) -> None:
    """Way points of both ships, looped or not: a hundred samples a second are never nearer by 0.1 %, nor turn faster by 2 %, than
    the run says, while it lasts."""
    rng = np.random.default_rng(seed)

    def track() -> list[dict[str, Any]]:
        return [{"position_m": rng.uniform(-900, 900, 2).tolist(), "speed_kn": float(rng.uniform(5, 40))} for _ in range(4)]

    body = point("t", 0, 0) | {"position_m": [*rng.uniform(-900, 900, 2), 5.0], "waypoints": track(), "loop": seed % 2 == 0}
    own = {"position_m": rng.uniform(-900, 900, 2).tolist(), "waypoints": track()} if seed % 3 else {}
    made = scene([body], own_ship=own)
    run = body_run(made.bodies[0], made)
    time = np.arange(0.0, 400.0, 0.01)
    apart = made.bodies[0].motion.pose(time).position[:, :2] - made.antenna(time)[:, :2]
    distance = np.linalg.norm(apart, axis=1)
    turn = np.abs(np.diff(np.unwrap(np.arctan2(*apart.T)))) / 0.01
    assert run.nearest <= distance.min() * 1.001
    assert run.turn >= 0.98 * turn[distance[1:] > 30.0].max()


def test_loops_that_do_not_repeat_together_end_at_the_horizon() -> None:
    loop = {
        "loop": True,
        "waypoints": [{"position_m": [600, 500], "speed_kn": 9}, {"position_m": [600, 700], "speed_kn": 9}],
    }
    followed = "its loops are followed for 3600 s"
    assert not remarks(scene([point("t", 500, 500) | loop]), "t")[0].endswith(followed)
    under_way = scene([point("t", 500, 500) | loop], own_ship={"speed_kn": 1, "course_deg": 90})
    assert remarks(under_way, "t")[0].endswith(followed)
    time = np.arange(0.0, HORIZON)
    apart = under_way.bodies[0].motion.pose(time).position[:, :2] - under_way.antenna(time)[:, :2]
    distance = np.linalg.norm(apart, axis=1)
    assert (
        body_run(under_way.bodies[0], under_way).approach <= distance.min() + 1e-3
    )  # at its last corners, far from the first


@pytest.mark.parametrize("seed", range(4))
def test_what_is_steered_stays_within_its_bounds(seed: int) -> None:
    """Own ship and a box are commanded at random about each other; the bounds hold, whatever they do."""
    limits = {"max_speed_kn": 25, "max_turn_rate_deg_s": 6}
    box = {"name": "box", "shape": "box", "length_m": 30, "width_m": 8, "height_m": 6, "position_m": [300, 200, 0]}
    given = scene([box | {"steerable": limits}], own_ship={"steerable": limits | {"max_speed_kn": 30}})
    run, random, made = body_run(given.bodies[0], given), np.random.default_rng(seed), Steering(given)
    for spoke in range(0, 20_000, 300):
        values = {"speed_kn": random.uniform(0, 25), "turn_rate_deg_s": random.uniform(-6, 6)}
        made.add(spoke, ("box", None)[random.integers(2)], values, reached=spoke)
    time = np.arange(0.0, 69.0, 0.01)
    body, own = made.past.bodies[0], made.past.own_ship
    offset = (body.middles_at(time) - own.pose(time).position)[:, :2]
    distance = np.hypot(*offset.T)
    away = np.maximum(distance - body.radius, NEAREST)
    aspect = np.unwrap(np.arctan2(*offset.T) - body.motion.pose(time).heading)
    assert np.abs(np.gradient(distance, time)).max() <= run.radial
    assert np.abs(np.gradient(aspect, time))[distance > body.radius + NEAREST].max() <= run.turn
    assert (2.0 * given.radar.height * np.abs(np.gradient(distance, time)) / away**2).max() <= run.sea_turn
    assert run.nearest == run.approach == 0.0 <= distance.min()


def test_own_ship_under_command_bounds_bodies_at_rest_too() -> None:
    steered = run_of(point("t", 0, 700), {"steerable": {"max_speed_kn": 10}})
    assert (steered.nearest, steered.start) == (0.0, 700.0)
    assert steered.radial == pytest.approx(10 * KNOT) and steered.turn == pytest.approx(2 * 10 * KNOT / NEAREST)
