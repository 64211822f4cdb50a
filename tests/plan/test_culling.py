"""What is left out for good: paths that never come near, bodies under the noise; and what must not be."""

from typing import Any

import pytest

import radar_service as rs
from radar_service.echo.closest_approach import max_power
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.culling import cull
from radar_service.plan.settings_search import fidelity_for
from radar_service.records.fidelity import PRESETS
from tests.scenes import point, scene

LOW = {"azimuths": 60, "beamwidth_deg": 15, "pulse_s": 1e-6}


def reasons(made: rs.Scene, error_db: float = 0.5) -> dict[str, str]:
    """Why bodies are left out, by name."""
    bodies = cull(made, fidelity_for(made, ErrorBudget(error_db)))
    return {made.bodies[key].name: culled.reason for key, culled in bodies.items()}


@pytest.mark.parametrize(("height", "distance", "gone"), [(10, 28_900, False), (10, 29_100, True), (100, 29_100, False)])
def test_bodies_beyond_the_horizon(height: float, distance: float, gone: bool) -> None:
    """15 and 10 m: 4.12 (sqrt 15 + sqrt 10) = 28.99 km."""
    made = scene([point("t", 0, distance, height)], radar=LOW | {"range_max_m": 60_000, "sample_rate_hz": 55e6})
    assert ("t" in reasons(made)) == gone
    assert (rs.Simulator(made, "balanced").scan().power.max() == 0.0) == gone


@pytest.mark.parametrize("environment", [{"earth": "flat"}, {"earth": "flat", "noise": True}])
def test_a_flat_earth_has_no_horizon(environment: dict[str, Any]) -> None:
    made = scene([point("t", 0, 29_100, 1.0, 60)], radar=LOW | {"range_max_m": 40_000}, environment=environment)
    assert not reasons(made)


def test_out_of_range_unless_earlier_pulses_are_received() -> None:
    far = point("t", 0, 12_000)
    assert "out of range" in reasons(scene([far], radar=LOW | {"range_max_m": 5000}))["t"]
    folded = LOW | {"range_max_m": 5000, "prf_hz": 20_000, "second_time_around": True}
    assert not reasons(scene([far], radar=folded))


def test_an_effect_that_a_scene_asks_for_is_never_left_out() -> None:
    """Gas of 0.1 mdB/km, a mast far below the beam, a sea that hardly reflects: who needs none of them switches it off."""
    radar = LOW | {"structure": [MAST | {"top_m": -30.0}], "multiple_echoes": {"own_rcs_dbsm": -20}}
    made = scene([point("t", 0, 900)], radar=radar, environment={"gas_db_per_km": 1e-4, "multipath": True, "sea_state": 6})
    assert rs.Simulator(made, "auto").scene.environment == made.environment
    choices = {choice["what"]: choice["modelled"] for choice in rs.Simulator(made, "auto").unmeasured_info.plan["choices"]}
    assert all(choices[what] for what in ("multipath", "gas and rain loss", "structures", "multiple echoes"))


def test_presets_leave_nothing_out() -> None:
    made = scene([point("t", 0, 90_000)])
    for name in ("documented", "fast", "balanced", "reference"):
        assert cull(made, PRESETS[name]) == {}, name


def test_the_greatest_power_is_greater_than_any_seen() -> None:
    """Speckle over 8 seeds, without multipath and with it, at the closest approach."""
    box = {"name": "b", "shape": "box", "length_m": 8, "width_m": 5, "height_m": 4, "position_m": [0, 700, 0],
           "material": "concrete", "scattering": "diffuse"}  # fmt: skip
    for body in (box, point("b", 0, 700, 9, 10, swerling=2)):
        for multipath, minimum in ((False, 5e-3), (True, 1e-4)):  # in a null where a lobe is 16 times as strong
            made = scene([body], radar=LOW | {"range_max_m": 900}, environment={"multipath": multipath})
            seen = max(rs.Simulator(made, seed=seed).scan().power.max() for seed in range(8))
            assert minimum < seen / max_power(made.bodies[0], made, PRESETS["balanced"]) < 1.0


def test_bodies_under_the_noise_are_left_out_together_only_as_far_as_the_budget_goes() -> None:
    """Each of 40 adds 0.05 dB: no more than 0.5 dB of them may be missing, and only where there is noise at all."""
    made = scene([point(f"p{k}", 100 * k - 2000, 12_000, 15, -35) for k in range(40)], radar=LOW | {"range_max_m": 14_000},
                 environment={"noise": True})  # fmt: skip
    result = cull(made, fidelity_for(made, ErrorBudget()))
    worst = [culled.error_db for culled in result.values()]
    assert 1 < len(result) < 40 and worst == sorted(worst) and 0.4 < worst[-1] <= 0.5
    assert len(reasons(made, 0.2)) < len(result) < len(reasons(made, 2.0))
    assert not reasons(scene([point("p", 0, 12_000, 15, -60)], radar=LOW | {"range_max_m": 14_000}))


def test_bodies_culled_below_noise_still_occlude() -> None:
    wall = {"name": "wall", "shape": "plate", "width_m": 60, "height_m": 60, "position_m": [0, 9000, 20], "rcs_dbsm": -60,
            "speed_kn": 0.5, "course_deg": 0}  # fmt: skip
    radar, noise = LOW | {"range_max_m": 12_000}, {"noise": True}
    made = scene([wall, point("behind", 0, 11_000, 15, 40)], radar=radar, environment=noise)
    assert list(reasons(made)) == ["wall"]
    alone = scene([point("behind", 0, 11_000, 15, 40)], radar=radar, environment=noise)
    assert rs.Simulator(made).scan().power.max() < 0.1 * rs.Simulator(alone).scan().power.max()


MAST = {"bearing_deg": 0, "distance_m": 3, "width_m": 0.2}
