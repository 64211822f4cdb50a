"""What is left out for good: paths that never come near, bodies under the noise; and what must not be."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.fidelity import PRESETS
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.closest_approach import closest_approach, nearest_and_top
from radar_service.plan.culling import culled_bodies, greatest_power, negligible_effects
from radar_service.plan.settings_search import fidelity_for
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import point, scene

LOW = {"azimuths": 60, "beamwidth_deg": 15, "pulse_s": 1e-6}


def reasons(made: rs.Scene, error_db: float = 0.5) -> dict[str, str]:
    """Why bodies are left out, by name."""
    found = culled_bodies(made, fidelity_for(made, ErrorBudget(error_db)))
    return {made.bodies[key].name: omission.reason for key, omission in found.items()}


@pytest.mark.parametrize(
    ("own", "other", "apart"),
    [
        ({}, {"position_m": [3000, 4000, 0]}, 5000.0),
        ({}, {"position_m": [-9000, 2000, 0], "speed_kn": 10, "course_deg": 90}, 2000.0),  # passes abeam
        ({}, {"position_m": [3000, 4000, 0], "speed_kn": 10, "course_deg": 0}, 5000.0),  # goes away
        (
            {"speed_kn": 10, "course_deg": 90},
            {"position_m": [500, 700, 0], "speed_kn": 10, "course_deg": 180},
            0.0,
        ),  # crosses
        ({"speed_kn": 10, "course_deg": 0}, {"position_m": [800, -900, 0], "speed_kn": 20, "course_deg": 0}, 800.0),
        ({}, {"position_m": [100, 0, 0], "waypoints": [{"position_m": [100, 300], "speed_kn": 9}]}, 100.0),
    ],
)
def test_nearest_approach_of_two_paths(own: dict[str, Any], other: dict[str, Any], apart: float) -> None:
    """By hand; lines are compared, not times. Rounding of a leg of 1e8 m: 1e-8 m."""
    made = scene([point("t", 0, 0) | other], own_ship=own)
    assert closest_approach(made.own_ship, made.bodies[0].motion) == pytest.approx(apart, abs=1e-5)


def test_no_pair_of_random_courses_ever_comes_nearer_than_said() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        ways = [{"position_m": rng.uniform(-5000, 5000, 2).tolist() + [0.0], "speed_kn": float(rng.uniform(0, 30)),
                 "course_deg": float(rng.uniform(0, 360))} for _ in range(2)]  # fmt: skip
        own = {"position_m": ways[0].pop("position_m")[:2]} | ways[0]  # type: ignore[index]
        made = scene([{"name": "b", "shape": "box", "length_m": 80, "width_m": 30, "height_m": 9} | ways[1]], own_ship=own)
        said, top = nearest_and_top(made.bodies[0], made)
        time = np.linspace(0, 4000, 2000)
        gap = made.bodies[0].motion.pose(time).position - made.antenna(time)
        assert np.hypot(gap[:, 0], gap[:, 1]).min() - math.hypot(40, 15) >= said - 1e-6
        assert top == 9.0


def test_a_turning_ship_keeps_its_distance() -> None:
    """Waypoints with a turn radius: the arc comes 200 m nearer than the chord between its ends, and no more than it is long."""
    track = [{"position_m": [x, y], "speed_kn": 10} for x, y in ((3000, 3000), (1000, 0), (3000, -3000))]
    made = scene([point("t", 3000, 0, waypoints=track, turn_radius_m=900, loop=True)])
    time = np.linspace(0, 20_000, 20_000)
    place = made.bodies[0].motion.pose(time).position
    assert closest_approach(made.own_ship, made.bodies[0].motion) <= np.hypot(place[:, 0], place[:, 1]).min()


def test_the_horizon_by_hand() -> None:
    """15 and 10 m: 4.12 (sqrt 15 + sqrt 10) = 28.99 km."""
    assert scene().horizon(10.0) == pytest.approx(28_990, abs=10)


@pytest.mark.parametrize(("height", "distance", "gone"), [(10, 28_900, False), (10, 29_100, True), (100, 29_100, False)])
def test_bodies_beyond_the_horizon(height: float, distance: float, gone: bool) -> None:
    made = scene([point("t", 0, distance, height)], radar=LOW | {"range_max_m": 60_000, "sample_rate_hz": 55e6})
    assert ("t" in reasons(made)) == gone
    assert (rs.Simulator(made, "balanced").scan().power.max() == 0.0) == gone


@pytest.mark.parametrize("environment", [{"earth": "flat"}, {"earth": "flat", "noise": True}])
def test_a_flat_earth_has_no_horizon(environment: dict[str, Any]) -> None:
    made = scene([point("t", 0, 29_100, 1.0, 60)], radar=LOW | {"range_max_m": 40_000}, environment=environment)
    assert not reasons(made)


def test_out_of_range_unless_earlier_pulses_are_heard() -> None:
    far = point("t", 0, 12_000)
    assert "out of range" in reasons(scene([far], radar=LOW | {"range_max_m": 5000}))["t"]
    folded = LOW | {"range_max_m": 5000, "prf_hz": 20_000, "second_time_around": True}
    assert not reasons(scene([far], radar=folded))


def test_presets_leave_nothing_out() -> None:
    made = scene([point("t", 0, 90_000)])
    for name in ("documented", "fast", "balanced", "reference"):
        assert not culled_bodies(made, PRESETS[name]), name


def test_the_greatest_power_is_greater_than_any_seen() -> None:
    """Speckle over 8 seeds, without the sea's mirror and with it, as near as it comes."""
    box = {"name": "b", "shape": "box", "length_m": 8, "width_m": 5, "height_m": 4, "position_m": [0, 700, 0],
           "material": "concrete", "scattering": "diffuse"}  # fmt: skip
    for body in (box, point("b", 0, 700, 9, 10, swerling=2)):
        for mirror, least in ((False, 5e-3), (True, 1e-4)):  # the mirror may be dark where it could be 16 times as bright
            made = scene([body], radar=LOW | {"range_max_m": 900}, environment={"multipath": mirror})
            seen = max(rs.Simulator(made, seed=seed).scan().power.max() for seed in range(8))
            assert least < seen / greatest_power(made.bodies[0], made, 3) < 1.0


def test_bodies_under_the_noise_are_left_out_together_only_as_far_as_the_budget_goes() -> None:
    """Each of 40 adds 0.05 dB: no more than 0.5 dB of them may be missing, and only where there is noise at all."""
    made = scene([point(f"p{k}", 100 * k - 2000, 12_000, 15, -35) for k in range(40)], radar=LOW | {"range_max_m": 14_000},
                 environment={"noise": True})  # fmt: skip
    found = culled_bodies(made, fidelity_for(made, ErrorBudget()))
    worst = [omission.error_db for omission in found.values()]
    assert 1 < len(found) < 40 and worst == sorted(worst) and 0.4 < worst[-1] <= 0.5
    assert len(reasons(made, 0.2)) < len(found) < len(reasons(made, 2.0))
    assert not reasons(scene([point("p", 0, 12_000, 15, -60)], radar=LOW | {"range_max_m": 14_000}))


def test_what_is_left_out_for_noise_still_hides() -> None:
    wall = {"name": "wall", "shape": "plate", "width_m": 60, "height_m": 60, "position_m": [0, 9000, 20], "rcs_dbsm": -60,
            "speed_kn": 0.5, "course_deg": 0}  # fmt: skip
    radar, noise = LOW | {"range_max_m": 12_000}, {"noise": True}
    made = scene([wall, point("behind", 0, 11_000, 15, 40)], radar=radar, environment=noise)
    assert list(reasons(made)) == ["wall"]
    alone = scene([point("behind", 0, 11_000, 15, 40)], radar=radar, environment=noise)
    assert rs.Simulator(made).scan().power.max() < 0.1 * rs.Simulator(alone).scan().power.max()


@pytest.mark.parametrize(("idle", "hidden"), [((), True), ((0,), False)])
def test_bodies_said_never_to_hide_anything_are_not_asked(idle: tuple[int, ...], hidden: bool) -> None:
    ship = {
        "name": "s",
        "shape": "hull",
        "length_m": 60,
        "beam_m": 20,
        "height_m": 40,
        "position_m": [0, 400, 0],
        "speed_kn": 1,
    }
    occlusion = OcclusionScene(scene([ship]).bodies, np.inf, idle)
    place, antenna = np.array([[0.0, 900.0, 15.0]]), np.array([0.0, 0.0, 15.0])
    assert occlusion.hides(place, antenna, 0.0)[0] == hidden


@pytest.mark.parametrize(("gas", "idle"), [(1e-4, True), (0.01, False)])
def test_gas_is_left_out_only_where_it_moves_nothing(gas: float, idle: bool) -> None:
    """2 x 2 km of 0.01 dB: 0.02 dB, -53 dB of the field, where methods may err by -54; and a hundredth of that."""
    made = scene([point("t", 0, 900)], radar=LOW | {"range_max_m": 1900}, environment={"gas_db_per_km": gas})
    assert ("gas" in negligible_effects(made, fidelity_for(made, ErrorBudget()))) == idle
