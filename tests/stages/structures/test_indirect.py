"""Indirect echoes: none where no structure is lit, all round where one is, with those of aspect among them."""

import numpy as np

import radar_service as rs
from radar_service.echo.beam_paths import Beam, Sights
from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.engine.pipeline import tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.settings_search import fidelity_for
from radar_service.records.fidelity import PRESETS
from radar_service.stages.registry import changed_pattern
from radar_service.stages.structures.reflection import IndirectPaths, structure_reflectors
from radar_service.stages.structures.stage import StructureStage, faint_bodies
from tests.scenes import point, radar, scene

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
