"""The lines of a plan about effects: which are modelled, with errors by hand."""

import math
from dataclasses import replace
from typing import Any

import pytest

import radar_service as rs
from radar_service.plan.cost_model import Costs, EngineStatistics
from radar_service.plan.effects import effects, missed_area
from radar_service.records.fidelity import PRESETS
from radar_service.records.plan_item import PlanItem
from tests.scenes import point, scene

COSTS = Costs(1.0, 2.0, 4.0, 32.0, effects={"clutter": 8.0, "interference": 16.0})


def items(made: rs.Scene, name: str = "balanced", statistics: EngineStatistics | None = None) -> dict[str, PlanItem]:
    """The items of a scene at a preset, by what they are about."""
    return {item.what: item for item in effects(made, PRESETS[name], statistics or EngineStatistics())}


def everything(**radar: Any) -> rs.Scene:
    return scene(
        [point("t", 0, 500, speed_kn=20, course_deg=0)],
        radar={"eclipsing": True, **radar},
        environment={"noise": True, "multipath": True, "sea_state": 3, "rain_mm_h": 4, "gas_db_per_km": 0.01},
        interference=[{"bearing_deg": 40, "prf_hz": 2000.0, "rpm": 30, "level_db": 60, "beamwidth_deg": 2}],
    )


def test_what_is_not_requested_is_not_modelled() -> None:
    """The receiver is the cost of range where there is no noise."""
    result = items(scene([point("t", 0, 500)]), statistics=EngineStatistics(costs=COSTS))
    assert (result["range"].microseconds, result["noise"].microseconds) == (4.0, None)
    off = {"eclipsing", "multipath", "gas and rain loss", "noise", "sea clutter", "rain clutter"}
    assert {what for what, item in result.items() if not item.modelled} == off
    assert result["multipath"].how == "not requested" and "motion" not in result and "interference" not in result


def test_what_is_requested_is_modelled_with_its_cost() -> None:
    result = items(everything(), statistics=EngineStatistics(costs=COSTS))
    assert {what for what, item in result.items() if not item.modelled} == {"Doppler within the pulse"}
    costs = {what: item.microseconds for what, item in result.items() if item.microseconds is not None}
    assert costs == {"motion": 1.0, "noise": 4.0, "sea clutter": 8.0, "interference": 16.0}


def test_a_flat_earth_raises_targets_by_the_parabola() -> None:
    """3400^2 / (2 x 4/3 x 6371 km) = 0.680 m."""
    made = scene([point("t", 0, 3400)], radar={"range_max_m": 5000})
    assert "a flat earth would raise targets at 3.4 km by 0.68 m" in items(made)["earth"].how
    assert not items(scene([point("t", 0, 3400)], environment={"earth": "flat"}))["earth"].modelled


def test_a_seaway_is_named_with_the_ships_that_it_moves() -> None:
    hull = {"name": "h", "shape": "hull", "length_m": 9, "beam_m": 3, "height_m": 3, "position_m": [0, 300, 0]}
    sea = {"sea_state": 2, "seaway": True}
    item = items(scene([hull, point("t", 0, 500)], environment=sea))["seaway"]
    assert item.modelled and item.how.startswith("2 ships by closed-form responses to 64 waves of 0.469 m in 7.5 s")
    assert "Froude" not in item.how
    fast = items(scene([hull | {"course_deg": 0, "speed_kn": 9}], environment=sea))["seaway"]
    assert "1 faster than Froude 0.4 answer as at that" in fast.how  # sqrt(g L) = 9.4 m/s, of which 0.4 are 7.3 kn
    none = items(scene([point("t", 0, 500)], own_ship={"hull": {"floats": False}}, environment=sea))["seaway"]
    assert not none.modelled and none.how == "no ship floats"
    assert "seaway" in items(scene([hull], environment=sea), "documented") and "seaway" not in items(scene([hull]))


def test_dented_plating_is_named_with_the_bodies_that_have_it() -> None:
    """Bodies by physical optics with dents alone: not flat ones, and not one that declares its cross-section."""
    hull = {"shape": "hull", "length_m": 9, "beam_m": 3, "height_m": 3, "position_m": [0, 300, 0]}
    dented = [hull | {"name": "a", "hull_type": "pilot"}, hull | {"name": "b", "plating": {"dent_m": 0.006}}]
    flat = [hull | {"name": "c"}, hull | {"name": "d", "hull_type": "pilot", "plating": {"dent_m": 0}},
            hull | {"name": "e", "hull_type": "pilot", "rcs_dbsm": 10}]  # fmt: skip
    item = items(scene([*dented, *flat]))["dented plating"]
    assert item.modelled and item.how.startswith("walls of 2 bodies, 4 to 6 mm deep between frames")
    assert "dented plating" not in items(scene(flat))


def test_doppler_within_a_pulse_is_stated_where_a_chirp_meets_motion() -> None:
    """10 us and 20 kn: 2 x 10.289 m/s x 1e-5 s / 31.859 mm = 0.006459 cells, times 2 pi / (2 sqrt 3) = 1.81: -38.6 dB."""
    result = items(scene([point("t", 0, 500, speed_kn=20, course_deg=0)]))["Doppler within the pulse"]
    assert "up to 0.0065 range cells" in result.how
    assert result.field_db == pytest.approx(20 * math.log10(math.pi / math.sqrt(3) * 0.006459), abs=0.02)
    assert "Doppler within the pulse" not in items(scene([point("t", 0, 500)]))
    plain = {"modulation": "none", "pulse_s": 1e-7}
    moving = scene([point("t", 0, 500, speed_kn=20, course_deg=0)], radar=plain)
    assert "Doppler within the pulse" not in items(moving)


def test_doppler_moves_echoes_of_nonlinear_chirps_farther() -> None:
    """The group delay rises faster in the middle of the band: 2.06 times for Nuttall's window."""
    moving = [point("t", 0, 500, speed_kn=20, course_deg=0)]
    radars = [{"modulation": modulation, "window": "nuttall"} for modulation in ("lfm", "nlfm")]
    result = [items(scene(moving, radar=radar))["Doppler within the pulse"] for radar in radars]
    assert "up to 0.013 range cells" in result[1].how
    assert 10 ** ((result[1].field_db - result[0].field_db) / 20) == pytest.approx(2.065, abs=1e-3)


def test_the_specification_has_neither_nonlinear_chirps_nor_inverse_filters() -> None:
    radar = {"modulation": "nlfm", "compression": "inverse", "window": "nuttall"}
    made = scene([point("t", 0, 500)], radar=radar)
    result = items(made, "documented")
    assert not result["nonlinear chirp"].modelled and not result["inverse filter"].modelled
    assert "inverse filter leaves the sidelobes of the window alone" in items(made)["range"].how


def test_nearer_pulses_have_an_item_with_their_loss() -> None:
    """Over k T0 F / T: Hamming's 1.34 dB at 10 us; 1.0645 B T / erf^2 = 1.24 dB at 80 ns, and 20.97 dB for its length."""
    pulses = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 1500}, {}]
    made = scene([point("t", 0, 500)], radar={"pulses": pulses})
    assert "0.08 us to 1500 m, where signal to noise is 20.9 dB lower" in items(made)["nearer pulses"].how
    assert not items(made, "documented")["nearer pulses"].modelled
    assert "nearer pulses" not in items(scene([point("t", 0, 500)]))


def test_clutter_below_the_noise_is_missing_by_its_own_power() -> None:
    """Up to 15 dB below the noise: 10 log10(1 + 10^-1.5) = 0.135 dB; exact without noise."""
    assert items(everything())["sea clutter"].power_db == pytest.approx(0.135, abs=5e-4)
    assert items(scene(environment={"sea_state": 3}))["sea clutter"].power_db is None


def test_the_documented_engine_has_what_the_specification_has() -> None:
    result = items(everything(), "documented")
    assert {what for what, item in result.items() if item.modelled} == {"signal chain", "beam", "multipath"}
    assert result["sea clutter"].how == "requested, but not in the specification"


def test_rays_miss_a_square_metre_beyond_50_m() -> None:
    """(1 - p)^2000 = 0.05: p = 1.4968e-3; the box is 11.7 x 75 degrees = 0.26730 sr, so R = 1 / sqrt(p box) = 49.99 m."""
    assert "beyond 50 m" in missed_area(scene())


def test_second_time_echoes_fold_at_the_unambiguous_range() -> None:
    """c / (2 x 10 kHz) = 14 990 m."""
    folded = items(scene(radar={"prf_hz": 10_000, "second_time_around": True}))["second-time echoes"]
    assert folded.modelled and "beyond 14990 m" in folded.how
    assert not items(scene(radar={"prf_hz": 10_000}))["second-time echoes"].modelled
    assert "second-time echoes" not in items(scene())


def test_beacons_have_a_line_with_those_that_cannot_answer() -> None:
    """An answer of a thousandth of the noise is left out: 0.0087 dB of two in one cell. A SART does not answer in S band."""
    racons = [point(letter, 0, 500, racon={"letter": letter}) for letter in "KD"]
    bodies, s_band = [*racons, point("raft", 50, 90, sart={})], {"frequency_hz": 3.05e9}
    statistics = EngineStatistics(costs=replace(COSTS, effects={"interference": 16.0, "beacon": 64.0}))
    item = items(scene(bodies, radar=s_band, environment={"noise": True}), statistics=statistics)["beacons"]
    assert item.modelled and item.microseconds == 64.0 and item.power_db == pytest.approx(10 * math.log10(1.002))
    assert item.how.startswith("2 racons, 1 sart: ") and item.how.endswith(
        "not triggered by this radar's carrier or pulse: raft"
    )
    silent = items(scene(bodies[2:], radar=s_band), statistics=statistics)["beacons"]
    assert not silent.modelled and silent.power_db is None
    assert items(scene(bodies))["beacons"].power_db is None and "beacons" not in items(scene([point("t", 0, 500)]))


STRUCTURES = [{"name": "mast", "bearing_deg": 0, "distance_m": 3, "width_m": 0.3}, {"name": "wall", "bearing_deg": 180,
              "distance_m": 9, "width_m": 4.0, "reflection": 0.0}]  # fmt: skip


def test_structures_and_false_echoes_are_named_with_levels_and_cost() -> None:
    radar = {"beamwidth_deg": 1.5, "pattern": "taylor", "structure": STRUCTURES, "multiple_echoes": {"own_rcs_dbsm": 30}}
    made = scene([point("t", 0, 500)], radar=radar)
    result = items(made, statistics=EngineStatistics(costs=replace(COSTS, effects={"structures": 7.0})))
    assert "mast 7.0 dB" in result["structures"].how and "wall 11" in result["structures"].how
    assert result["structures"].field_db == -54.0
    assert "mast -50 dB" in result["indirect echoes"].how and "wall" not in result["indirect echoes"].how
    assert result["indirect echoes"].microseconds == 7.0 and "1 of 1 bodies" in result["indirect echoes"].how
    assert "2 of each of 1 ships within 2000 m, by 30 dBsm" in result["multiple echoes"].how
    box = {"name": "b", "shape": "box", "length_m": 9, "width_m": 3, "height_m": 3, "position_m": [0, 300, 0],
           "scattering": "optics", "material": "steel"}  # fmt: skip
    metal = scene([box], radar=radar)
    for name, each in (("balanced", metal), ("reference", metal), ("balanced", made)):
        held = "the aspect of the beam's crossing" in items(each, name)["indirect echoes"].how
        assert held == (name == "balanced" and each is metal)
    assert not items(made, "documented")["structures"].modelled and not items(made, "documented")["multiple echoes"].modelled


def test_multipath_says_that_land_reflects_where_there_is_land() -> None:
    """A wooden hull is no land; a box of sand is."""
    hull = {"name": "hull", "shape": "hull", "material": "wood", "length_m": 20, "beam_m": 5, "height_m": 3}
    sand = {"name": "spit", "shape": "box", "material": "sand", "length_m": 90, "width_m": 40, "height_m": 1}
    texts = [items(scene(bodies, environment={"multipath": True}))["multipath"].how for bodies in ([hull], [hull, sand])]
    assert texts[1] == texts[0] + "; land reflects in place of the sea, as rough as its material"
