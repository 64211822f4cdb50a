"""Nothing yields NaN: radar settings and places at random, at the antenna, under the ground and past the horizon too."""

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import radar_service as rs
from radar_service.world.error import SceneError
from tests.scenes import scene

PLACES = st.one_of(st.sampled_from([0.0, 1e-9, -1.0, 1.0, 30.0]), st.floats(-3000.0, 3000.0))
HEIGHTS = st.one_of(st.sampled_from([0.0, 15.0, -5.0, 1e-9]), st.floats(-20.0, 200.0))
SHAPES: list[dict[str, Any]] = [
    {"shape": "point", "rcs_dbsm": 10},
    {"shape": "point", "rcs_dbsm": -100, "swerling": 2},
    {"shape": "point", "rcs_dbsm": 100, "speed_kn": 2000, "course_deg": 77},
    {"shape": "box", "length_m": 1e-3, "width_m": 1e-3, "height_m": 1e-3, "material": "concrete"},
    {"shape": "box", "length_m": 40, "width_m": 40, "height_m": 60, "material": "concrete", "scattering": "diffuse"},
    {"shape": "plate", "width_m": 5, "height_m": 3, "scattering": "optics"},
    {"shape": "trihedral", "edge_m": 0.3, "speed_kn": 3, "course_deg": 10},
    {"shape": "hull", "length_m": 30, "beam_m": 6, "height_m": 9, "rcs_dbsm": 20, "speed_kn": 12, "course_deg": 200},
]
WAVEFORMS: list[dict[str, Any]] = [
    {"pulse_s": 2e-6, "bandwidth_hz": 2e6},
    {"pulse_s": 10e-6, "bandwidth_hz": 10e6, "window": "taylor"},
    {"pulse_s": 1e-6, "bandwidth_hz": 20e6, "sample_rate_hz": 20e6, "window": "nuttall"},
    {"modulation": "nlfm", "pulse_s": 2e-6, "bandwidth_hz": 2e6, "window": "hann", "compression": "inverse"},
    {"pulses": [{"modulation": "none", "pulse_s": 0.08e-6, "range_max_m": 100}, {"pulse_s": 2e-6, "bandwidth_hz": 10e6}]},
    {"modulation": "none", "pulse_s": 0.08e-6, "bandwidth_hz": 12e6},
    {"modulation": "none", "pulse_s": 1.2e-6},
    {"modulation": "none", "pulse_s": 1.2e-6, "bandwidth_hz": 1e6, "sample_rate_hz": 60e6},
]
REPETITIONS: list[dict[str, Any]] = [{}, {"prf_hz": 1000}, {"prf_hz": 50_000, "second_time_around": True}]
PATTERNS = st.sampled_from(["sinc2", "printed", "gaussian", "taylor", "cosine", "cosine2", [[0, 0], [20, -3], [30, -300]]])


@st.composite
def worlds(draw: st.DrawFn) -> dict[str, Any]:
    """A scene file's content, of a radar with few cells and up to three bodies."""
    radar = {
        **draw(st.sampled_from(WAVEFORMS)),
        **draw(st.sampled_from(REPETITIONS)),
        "range_max_m": draw(st.sampled_from([10.0, 300.0, 2500.0])),
        "range_min_m": draw(st.sampled_from([1e-6, 1.0, 1000.0])),
        "azimuths": draw(st.sampled_from([4, 9, 16])),
        "beamwidth_deg": draw(st.sampled_from([3.0, 40.0, 90.0])),
        "coarse_azimuths": True,
        "beamwidth_el_deg": draw(st.sampled_from([0.05, 25.0, 180.0])),
        "pattern": draw(PATTERNS),
        "tilt_deg": draw(st.sampled_from([-45.0, 0.0, 45.0])),
        "height_m": draw(st.sampled_from([1e-3, 15.0, 200.0])),
        "polarization": draw(st.sampled_from(["h", "v"])),
        "eclipsing": draw(st.booleans()),
        "rpm": draw(st.sampled_from([0.01, 24.0, 600.0])),
    }
    environment = {
        "earth": draw(st.sampled_from(["4/3", "flat", 1e-3])),
        "multipath": draw(st.booleans()),
        "noise": draw(st.booleans()),
        "sea_state": draw(st.sampled_from([0, 3, 9])),
        "rain_mm_h": draw(st.sampled_from([0.0, 1e-9, 300.0])),
        "gas_db_per_km": draw(st.sampled_from(["itu", 0.0, 10.0])),
    }
    kinds = draw(st.lists(st.sampled_from(SHAPES), min_size=1, max_size=3))
    bodies = [
        {**kind, "name": f"b{i}", "position_m": [draw(PLACES), draw(PLACES), draw(HEIGHTS)]} for i, kind in enumerate(kinds)
    ]
    own = draw(st.sampled_from([{}, {"speed_kn": 25.0, "course_deg": 45.0}]))
    return {"radar": radar, "environment": environment, "own_ship": own, "bodies": bodies}


QUIET: dict[str, Any] = {"deadline": None, "derandomize": True, "database": None, "suppress_health_check": list(HealthCheck)}


@settings(max_examples=6, **QUIET)
@given(worlds())
def test_every_field_is_finite_or_the_scene_is_refused(world: dict[str, Any]) -> None:
    check_finite(world)


@pytest.mark.study
@settings(max_examples=1000, **QUIET)
@given(worlds())
def test_every_field_of_a_thousand_scenes_is_finite(world: dict[str, Any]) -> None:
    check_finite(world)


def check_finite(world: dict[str, Any]) -> None:
    """Where the loader takes a scene, every sample, every truth and every plan of it is made of finite numbers."""
    bodies = world.pop("bodies")
    try:
        made = scene(bodies, **world)
    except SceneError as fault:
        assert str(fault).startswith(("radar.", "body[", "environment.", "own_ship."))
        return
    with np.errstate(invalid="raise", divide="raise", over="raise"):
        sim = rs.Simulator(made)
        scan = sim.scan()
        truth = sim.truth(1.5)
    assert np.isfinite(scan.field).all() and np.isfinite(scan.power).all()
    assert all(np.isfinite([body.range, body.azimuth, body.elevation]).all() for body in truth.bodies)
    assert str(sim.plan)
