"""The short modules of stages/structures, each under its name."""

import json
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.beam_paths import Beam, Sights
from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.engine.pipeline import tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.settings_search import fidelity_for
from radar_service.radar_feed import crossing_from_line
from radar_service.records.fidelity import PRESETS
from radar_service.sources.numbers import source_names
from radar_service.stages.registry import changed_pattern
from radar_service.stages.structures.reflection import IndirectPaths, structure_reflectors
from radar_service.stages.structures.stage import StructureStage, StructureTruth, faint_bodies
from radar_service.stages.structures.structure import Structure, fresnel_unit, taken
from tests.scenes import point, radar, scene

# effect: structures in scene files: what they become, and what is refused.
MAST = {"name": "mast", "bearing_deg": -10, "distance_m": 3.0, "width_m": 0.4}
DARK = MAST | {"name": "dark", "reflection": 0.0}


def test_a_structure_in_si_units() -> None:
    two = [MAST, {**MAST, "bearing_deg": 170, "top_m": 0.5, "reflection": 0.3}]
    (mast, low) = radar(structure=two).effects["structures"]
    assert (mast.name, mast.distance, mast.radius, mast.top, mast.reflection) == ("mast", 3.0, 0.2, np.inf, 1.0)
    assert mast.bearing == pytest.approx(np.radians(-10))
    assert (low.top, low.reflection) == (0.5, 0.3)


@pytest.mark.parametrize(
    "settings, message",
    [
        ({"structure": [{**MAST, "distance_m": 0.3}]}, r"structure\[0\].distance_m: 0.3 m; the antenna of 0.415 m would strike"),
        ({"structure": [{**MAST, "width_m": 0}]}, r"radar.structure\[0\].width_m: .*0.01"),
        ({"structure": [{**MAST, "reflection": 1.5}]}, r"radar.structure\[0\].reflection: .*1"),
        ({"structure": [{**MAST, "material": "steel"}]}, r"radar.structure\[0\].material"),
        ({"structure": [MAST, {**MAST, "bearing_deg": 352}]}, r"structure\[1\].bearing_deg: 352 is 2 degrees from .* 7.6"),
        ({"structure": [MAST], "pattern": "gaussian"}, r'structure: pattern gaussian has no aperture .* "sinc2", "taylor"'),
        ({"structure": [MAST], "pattern": [[0, 0], [4, -20]]}, r"structure: pattern a table of 2 rows"),
    ],
)  # fmt: skip
def test_impossible_structures_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        radar(**settings)


# structure: what structures take: edges in closed form.
WAVELENGTH = 0.0319
MIDDLE = np.zeros(1)


def test_half_the_field_is_left_at_the_edge_of_a_shadow() -> None:
    """Behind a wide structure whose edge is straight ahead the field is 1/2; at its top too, and a quarter at both together."""
    distance, radius = 60.0, 30.0
    aside = np.array([np.arcsin(radius / distance)])
    for top, left in ((np.inf, 0.5), (0.0, 0.75)):
        field = 1.0 - taken(Structure("wall", 0.0, distance, radius, top), WAVELENGTH, aside, MIDDLE)[0, 0]
        far_edge = 1.0 / (np.pi * 2.0 * radius / fresnel_unit(WAVELENGTH, distance * np.cos(aside[0])))  # what it still adds
        assert abs(field - left) < far_edge


@pytest.mark.parametrize("below", [0.5, 1.0, 2.0])
def test_a_top_below_the_beam_is_a_knife_edge(below: float) -> None:
    """Loss behind a screen whose top is over the way by so many Fresnel units: ITU-R P.526-15, eq. 31, which errs by 0.1 dB."""
    distance, radius = 20.0, 15.0
    unit = float(fresnel_unit(WAVELENGTH, distance))
    wall = Structure("wall", 0.0, distance, radius, below * unit)
    lit = 1.0 - taken(wall, WAVELENGTH, np.zeros(1), MIDDLE)[0, 0]
    loss_db = 6.9 + 20.0 * np.log10(np.sqrt((below - 0.1) ** 2 + 1.0) + below - 0.1)
    sides_db = 20.0 * np.log10(1.0 + 2.0 / (np.pi * radius / unit) / abs(lit))  # what its two side edges let pass
    assert abs(20.0 * np.log10(abs(lit)) + loss_db) < 0.1 + sides_db
    assert sides_db < 2.0


def test_nothing_is_taken_far_from_the_structure() -> None:
    mast = Structure("mast", 0.0, 3.0, 0.1)
    assert abs(taken(mast, WAVELENGTH, np.radians([75.0]), MIDDLE)[0, 0]) < 1e-30
    assert abs(taken(mast, WAVELENGTH, np.zeros(1), MIDDLE)[0, 0]) > 0.5


# indirect: indirect echoes: none where no structure is lit, all round where one is, with those of aspect among them.
RADAR = {"azimuths": 256, "beamwidth_deg": 3.0, "range_max_m": 900, "pattern": "cosine2", "pulse_s": 1e-6,
         "structure": [{"bearing_deg": 90, "distance_m": 5, "width_m": 1.0}]}  # fmt: skip
BOX = {"name": "box", "shape": "box", "length_m": 4, "width_m": 3, "height_m": 5, "material": "steel", "heading_deg": 40,
       "position_m": [-300, 200, 0]}  # fmt: skip


def test_bodies_all_round_are_seen_by_a_lit_structure() -> None:
    """At azimuths that point at the mast there are echoes of a point and of metal, both elsewhere; opposite there are none."""
    prepared = prepare(scene([point("p", 0.0, -400.0), BOX], radar=RADAR), PRESETS["balanced"], 1)
    stage = prepared.stages["structures"]
    assert isinstance(stage, StructureStage) and len(stage.indirect) == 2
    lit = stage.echoes(tile_azimuths(prepared, 0, 64 // prepared.tile * prepared.tile))
    assert len(lit.range) >= 4 and set(lit.body.tolist()) == {2}
    assert lit.range.min() > 360.0 and lit.amplitude.any()
    dark = stage.echoes(tile_azimuths(prepared, 0, 192 // prepared.tile * prepared.tile))
    assert len(dark.range) == 0 and dark.amplitude.shape[1] == prepared.tile


def indirect(made: rs.Scene, fidelity: rs.Fidelity, silent: tuple[int, ...] = ()) -> int:
    """How many bodies have indirect echoes."""
    stage = prepare(made, fidelity, 1, silent).stages["structures"]
    assert isinstance(stage, StructureStage) and stage.has_echoes == (len(stage.indirect) > 0)
    return len(stage.indirect)


def test_bodies_whose_indirect_echoes_stay_below_the_noise_have_none() -> None:
    """A strong and a weak point under an error budget: indirect echoes of the strong one alone. Nor have silent bodies any."""
    bodies = [point("strong", 0, 500, rcs_dbsm=60.0), point("weak", 700, 0, rcs_dbsm=-50.0)]
    made = scene(bodies, radar=RADAR | {"power_w": 20.0}, environment={"noise": True})
    fidelity = fidelity_for(made, ErrorBudget(0.5))
    faint = faint_bodies(made, fidelity)
    assert set(faint) == {1} and faint[1] < -20.0 and faint_bodies(made, PRESETS["balanced"]) == {}
    assert indirect(made, fidelity) == 1 and indirect(made, PRESETS["balanced"]) == 2
    assert indirect(made, PRESETS["balanced"], (0, 1)) == 0 and indirect(made, fidelity, (0,)) == 0


def test_absorbers_reflect_nothing() -> None:
    made = radar(structure=[MAST, {**DARK, "bearing_deg": 90}])
    assert [each.structure.name for each in structure_reflectors(made)] == ["mast"]
    assert "indirect" not in source_names(scene([point("p", 0, 500)], radar={"structure": [DARK]})).values()


def test_indirect_paths_are_there_and_back_and_one_way_by_a_structure() -> None:
    """Of one echo abeam of a mast that is lit: f^2 at R + d, and 2 g f at R + d / 2, g of the direct beam and d the detour, which
    changes as own ship turns."""
    made = radar(structure=[{"bearing_deg": 30, "distance_m": 2, "width_m": 0.3}], azimuths=720)
    (reflector,) = structure_reflectors(made)
    shadow = changed_pattern(made, 1.0)
    assert shadow is not None
    heading, boresight = np.radians([0.0, 1.0, 2.0]), np.radians([30.0, 30.5, 31.0])
    bearing = np.radians([[72.0, 72.0, 72.0]])
    echoes = BeamWeightedEchoes(
        np.array([100.0]), np.zeros((1, 3), dtype=np.float32), np.ones((1, 3), dtype=np.complex64), np.array([0])
    )
    received = IndirectPaths(made, Beam(made, shadow), -2).received(echoes, Sights(bearing, boresight, heading))
    field, ray = reflector.field(bearing - heading, boresight - heading)
    direct = shadow.one_way(bearing - heading, bearing - boresight)
    assert abs(direct[0, 1]) > 0.01 and abs(field[0, 1]) > 0.01  # both count
    np.testing.assert_allclose(received.amplitude, np.concatenate([field**2, 2.0 * direct * field]), rtol=1e-5)
    np.testing.assert_allclose(received.range, 100.0 + np.array([1.0, 0.5]) * ray.detour[0, 1])
    change = ray.detour[0] - ray.detour[0, 1]
    np.testing.assert_allclose(received.range_migration, np.outer([1.0, 0.5], change), atol=1e-7)
    assert set(received.body.tolist()) == {-2}


# truth: the truth of false echoes against what is received, and by hand.
FINE_RADAR = {"azimuths": 512, "beamwidth_deg": 2.0, "range_max_m": 1500, "pattern": "cosine2", "pulse_s": 2e-7,
              "bandwidth_hz": 30e6}  # fmt: skip
FUNNEL = {"name": "funnel", "bearing_deg": 0, "distance_m": 6, "width_m": 1.0}
MULTIPLE = {"own_rcs_dbsm": 40, "range_m": 600, "orders": 3}


def test_an_echo_of_a_ship_astern_stands_ahead_by_twice_the_way_to_the_funnel() -> None:
    """180 degrees off the funnel: farther by twice 5.5 m, in its bearing; level by the power of the tube, -33 dB two ways."""
    made = scene([point("t", 0, -800)], radar=FINE_RADAR | {"structure": [FUNNEL]}, own_ship={"heading_deg": 0})
    truth = StructureTruth(made)
    (echo,) = truth.false_echoes(0, 800.0, np.pi, 0.0)
    assert (echo.kind, echo.by, echo.range) == ("indirect", "funnel", pytest.approx(811.0, abs=0.01))
    assert echo.bearing == pytest.approx(0.0, abs=1e-6) or echo.bearing == pytest.approx(2 * np.pi, abs=1e-6)
    assert truth.false_echoes(0, 800.0, 0.1, 0.0) == []  # ahead it is behind the funnel


def test_what_the_truth_says_is_received() -> None:
    """Peaks of the cells labelled as indirect and as multiple: range within a cell, bearing within a beam, level within 1 dB."""
    body = point("t", -290, -390, rcs_dbsm=60.0)
    radar = FINE_RADAR | {"structure": [FUNNEL], "multiple_echoes": MULTIPLE}
    sim = rs.Simulator(scene([body], radar=radar, own_ship={"speed_kn": 8, "course_deg": 20}), "balanced", labels=True)
    scan, (crossing,) = sim.scan(), sim.crossings(0)
    assert crossing.false_echoes is not None and scan.labels is not None
    kinds = [echo.kind for echo in crossing.false_echoes]
    assert kinds == ["indirect", "multiple", "multiple"]  # the fourth trace is too far
    direct = scan.power[scan.labels == 256].max()
    step = sim.scene.radar.range_step
    for label, echo in zip((7, 8, 8), crossing.false_echoes, strict=True):
        column = round(echo.range / step - 0.5)
        window = np.where(scan.labels == label, scan.power, 0.0)[:, column - 6 : column + 7]
        row, peak = np.unravel_index(int(window.argmax()), window.shape)
        assert abs((peak + column - 6 + 0.5) * step - echo.range) < 1.5 * step
        off = (row * 2 * np.pi / 512 - echo.bearing + np.pi) % (2 * np.pi) - np.pi
        assert abs(np.degrees(off)) < 3.0
        assert 10 * np.log10(window.max() / direct) == pytest.approx(echo.level_db, abs=1.0)
    assert crossing_from_line(json.loads(json.dumps(crossing.as_dict()))) == crossing


def test_scenes_without_them_have_no_keys() -> None:
    sim = rs.Simulator(scene([point("t", 0, 500)], radar=FINE_RADAR), "fast")
    assert not {"false_echoes", "structure_db"} & sim.crossings(0)[0].as_dict().keys()
