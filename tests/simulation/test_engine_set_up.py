"""What a simulator computes with, by scene and fidelity."""

import pytest

from radar_service.engine.documented import DocumentedEngine
from radar_service.records.fidelity import PRESETS
from radar_service.simulation.engine_set_up import chosen_fidelity, engine_set_up, pipeline_set_up
from radar_service.sources.labels import LabellingEngine, LabellingStitchedEngine
from tests.scenes import point, scene

ONE = {"azimuths": 32, "beamwidth_deg": 20, "range_max_m": 600, "pulse_s": 1e-6}
TWO = {
    "azimuths": 32,
    "beamwidth_deg": 20,
    "range_max_m": 600,
    "pulses": [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 300}, {"pulse_s": 1e-6}],
}


@pytest.mark.parametrize(
    ("radar", "fidelity", "kind"),
    [(ONE, "balanced", LabellingEngine), (TWO, "fast", LabellingStitchedEngine), (TWO, "balanced", LabellingStitchedEngine),
     (ONE, "documented", DocumentedEngine)],
)  # fmt: skip
def test_the_engine_is_that_of_the_fidelity_and_the_pulses(radar: dict, fidelity: str, kind: type) -> None:
    made = scene([point("p", 100, 200)], radar=radar)
    engine, set_up, line_of_sight, pulses = engine_set_up(made, PRESETS[fidelity], fidelity, 0)
    assert type(engine) is kind and (set_up is None) == (fidelity == "documented")
    expected = [] if set_up is None else [300, 600] if radar is TWO else [600]
    assert [prepared.scene.radar.range_max for prepared in pulses] == expected
    assert set_up is None or set_up.prepared.line_of_sight is line_of_sight
    (start, field, power), *_ = engine.tiles(0)
    assert start == 0 and field.shape == power.shape and field.shape[1] == made.radar.bins == len(engine.range)


def test_auto_is_planned_and_names_are_presets() -> None:
    made = scene([point("p", 100, 200)], radar=ONE)
    assert chosen_fidelity(made, "fast") is PRESETS["fast"] and chosen_fidelity(made, PRESETS["fast"]) is PRESETS["fast"]
    assert chosen_fidelity(made, "auto").name == "auto"
    with pytest.raises(ValueError, match="fidelity"):
        chosen_fidelity(made, "best")


def test_rays_of_set_up_and_of_the_first_update_are_counted_apart() -> None:
    wall = {"name": "wall", "shape": "box", "length_m": 4, "width_m": 100, "height_m": 20, "position_m": [0, 200, 0]}
    made = scene([{**wall, "material": "concrete"}, point("mover", 50, 400, speed_kn=5)], radar=ONE)
    set_up = pipeline_set_up(made, PRESETS["balanced"], 0)
    assert set_up.prepared.seed == 0 and not set_up.culled
