"""The stage of clutter: what it adds to tiles, by source, and its lines of the plan."""

from typing import Any

import pytest

import radar_service as rs
from radar_service.engine.pipeline import contributions, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from radar_service.stages.clutter.effect import RAIN, SEA
from radar_service.stages.clutter.stage import ClutterStage
from tests.alone import clutter_of
from tests.scenes import scene

RADAR = {"azimuths": 90, "beamwidth_deg": 8, "range_max_m": 2000}
MAST = {"name": "mast", "bearing_deg": 20, "width_m": 1.0, "distance_m": 4}


def powers(environment: dict[str, Any], **radar: Any) -> dict[int, float]:
    """The power of all sources in the first tile [W]."""
    prepared = prepare(scene(radar=RADAR | radar, environment=environment), PRESETS["fast"], 0)
    fields = contributions(prepared, tile_azimuths(prepared, 0, 0)).added.fields
    return {number: float(power.sum()) for field in fields for number, power in field.powers().items()}


@pytest.mark.parametrize(
    ("environment", "sources"),
    [
        ({}, set()),
        ({"sea_state": 4}, {SEA}),
        ({"rain_mm_h": 4.0}, {RAIN}),
        ({"sea_state": 4, "rain_mm_h": 4.0}, {SEA, RAIN}),
    ],
)
def test_sea_and_rain_are_each_their_own_source(environment: dict[str, Any], sources: set[int]) -> None:
    open_air, behind = powers(environment), powers(environment, structure=[MAST])
    assert {number for number, power in open_air.items() if power > 0.0} == sources
    assert all(0.0 < behind[number] < 0.9 * open_air[number] for number in sources)


def test_clutter_below_its_floor_adds_nothing() -> None:
    made = scene(radar=RADAR | {"power_w": 1e-12}, environment={"noise": True, "sea_state": 1})
    prepared = prepare(made, PRESETS["fast"], 0)
    assert clutter_of(prepared) is None and not contributions(prepared, tile_azimuths(prepared, 0, 0)).added


def test_the_specification_names_only_clutter_that_is_requested() -> None:
    def lines(name: str, **environment: Any) -> dict[str, bool]:
        made: rs.Scene = scene(environment=environment)
        return {item.what: item.modelled for item in ClutterStage.plan(made, PRESETS[name], None)}

    assert lines("balanced", rain_mm_h=4.0) == {"sea clutter": False, "rain clutter": True}
    assert lines("documented", rain_mm_h=4.0) == {"rain clutter": True} and lines("documented") == {}


def test_the_plan_says_where_the_texture_is_extrapolated_and_that_waves_show() -> None:
    def how(**keys: Any) -> str:
        made = scene(radar=RADAR, environment={"sea_state": 3, **keys})
        return next(iter(ClutterStage.plan(made, PRESETS["balanced"], None))).how

    assert "(Ward), extrapolated to cells 1.58 to 210 m across (measured: 100 to 800 m)" in how() and "waves" not in how()
    assert "shape 4, in the rows of the waves that move ships" in how(seaway=True, sea_texture_shape=4)
