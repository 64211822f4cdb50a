"""Indirect echoes: none where no structure is lit, all round where one is, with those of aspect among them."""

from radar_service.engine.pipeline import tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from tests.scenes import point, scene

RADAR = {"azimuths": 256, "beamwidth_deg": 3.0, "range_max_m": 900, "pattern": "cosine2", "pulse_s": 1e-6,
         "structure": [{"bearing_deg": 90, "distance_m": 5, "width_m": 1.0}]}  # fmt: skip
BOX = {"name": "box", "shape": "box", "length_m": 4, "width_m": 3, "height_m": 5, "material": "steel", "heading_deg": 40,
       "position_m": [-300, 200, 0]}  # fmt: skip


def test_bodies_all_round_are_seen_by_a_lit_structure() -> None:
    """At azimuths that point at the mast there are echoes of a point and of metal, both elsewhere; opposite there are none."""
    prepared = prepare(scene([point("p", 0.0, -400.0), BOX], radar=RADAR), PRESETS["balanced"], 1)
    assert prepared.indirect is not None and len(prepared.indirect) == 2
    lit = prepared.indirect.echoes(tile_azimuths(prepared, 0, 64 // prepared.tile * prepared.tile))
    assert len(lit.range) >= 4 and set(lit.body.tolist()) == {-2}
    assert lit.range.min() > 360.0 and lit.amplitude.any()
    dark = prepared.indirect.echoes(tile_azimuths(prepared, 0, 192 // prepared.tile * prepared.tile))
    assert len(dark.range) == 0 and dark.amplitude.shape[1] == prepared.tile


def test_bodies_that_are_too_faint_have_none() -> None:
    bodies = [point("p", 0.0, -400.0), BOX]
    only = prepare(scene(bodies, radar=RADAR), PRESETS["balanced"], 1, faint=[1])
    assert only.indirect is not None and len(only.indirect) == 1
    assert prepare(scene(bodies, radar=RADAR), PRESETS["balanced"], 1, silent=[0, 1]).indirect is None
    assert prepare(scene(bodies), PRESETS["balanced"], 1).indirect is None
