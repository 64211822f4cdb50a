"""Counts of prepared engines by hand, and costs by a clock that ticks once a call."""

import itertools
import math
import time
from typing import Any

import pytest

import radar_service as rs
from radar_service.engine.pipeline import Prepared, prepare, tile_azimuths
from radar_service.fidelity import PRESETS
from radar_service.plan.cost_model import (
    CLUTTER_SHARE,
    SetUp,
    counts_per_body,
    engine_costs,
    engine_counts,
    engine_statistics,
    first_visibility_update,
)
from radar_service.plan.culling import Culling
from radar_service.trace.embree import RayCount
from tests.scenes import point, scene

SMALL = {"azimuths": 120, "beamwidth_deg": 7.5, "range_max_m": 1500, "pulse_s": 2e-6, "rpm": 24}
PLATE = {"name": "plate", "shape": "plate", "width_m": 20, "height_m": 20, "position_m": [0, 600, 8], "heading_deg": 180,
         "rcs_dbsm": 20, "speed_kn": 12, "course_deg": 90}  # fmt: skip
OTHER = {"bearing_deg": 40, "prf_hz": 2000.0, "rpm": 30, "level_db": 60, "beamwidth_deg": 2}


def prepared_from(bodies: list[dict[str, Any]], rays: RayCount | None = None, **sections: Any) -> Prepared:
    made: rs.Scene = scene(bodies, radar=SMALL, **sections)
    return prepare(made, PRESETS["balanced"], 0, rays=rays)


def test_resting_and_moving_points_are_counted() -> None:
    """12 kn for 2.5 s in steps of 5 m: 3.087 visibility updates per scan."""
    bodies = [point("a", 0, 500), point("b", 700, 0), point("c", -300, 300, speed_kn=12, course_deg=90)]
    prepared = prepared_from(bodies)
    counts = engine_counts(SetUp(prepared, Culling(), 17, 4))
    assert (counts.resting_echoes, counts.moving_echoes, counts.shadowed_echoes, counts.scatterers) == (2, 1, 0, 3)
    assert (counts.set_up_rays, counts.look_rays) == (17, 4)
    assert counts.looks_per_scan == pytest.approx(12 * 1852 / 3600 * 2.5 / 5.0)
    assert counts.transform_samples == 2 * prepared.compression.size
    per_body = counts_per_body(prepared)
    assert per_body.scatterers.tolist() == per_body.echoes.tolist() == [1, 1, 1]


def test_a_passing_plate_shadows_the_point_behind_it() -> None:
    prepared = prepared_from([point("behind", 0, 900, 10.0), PLATE])
    assert engine_counts(SetUp(prepared, Culling(), 0, 0)).shadowed_echoes == 1


def test_the_first_visibility_update_is_cached() -> None:
    rays = RayCount()
    prepared = prepared_from([point("behind", 0, 900, 10.0), PLATE], rays)
    cast = rays.rays
    first_visibility_update(prepared)
    update = rays.rays
    assert update > cast
    first_visibility_update(prepared)
    assert rays.rays == update


def test_each_stage_is_timed_once_per_azimuth(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each timed call takes a second. A scene with all stages; the receiver alone is moving and receiver less moving: 0."""
    prepared = prepared_from(
        [point("c", -300, 300, speed_kn=12, course_deg=90)],
        environment={"noise": True, "sea_state": 3},
        interference=[OTHER, OTHER | {"bearing_deg": 90}],
    )
    first_visibility_update(prepared)
    ticks = itertools.count()
    monkeypatch.setattr(time, "thread_time", lambda: float(next(ticks)))
    costs = engine_costs(prepared)
    tile, radar = prepared.tile, prepared.scene.radar
    each = 1e6 / tile
    assert costs.moving == pytest.approx(each) and costs.receiver == 0.0 and costs.profiles == pytest.approx(each)
    assert costs.interference == pytest.approx(2 * each)
    tiles = max(4, math.ceil(radar.azimuths / tile / CLUTTER_SHARE))
    assert costs.clutter == pytest.approx(each / (tiles - 1))
    assert costs.looks == pytest.approx(1e6 * radar.spoke_period / prepared.moving.visibility.interval)


def test_physical_optics_is_priced_by_its_nodes_in_a_scan(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each timed call takes a second: one for each node of each body, besides a second for each visibility update. Its echoes of
    the first update are those at the nodes that the first tile needs."""
    metal = {key: value for key, value in PLATE.items() if key != "rcs_dbsm"} | {"scattering": "optics", "width_m": 3}
    prepared = prepared_from([metal, metal | {"name": "other", "position_m": [-300, -500, 8], "height_m": 2}])
    nodes = [len(each) for each in prepared.moving.passages.first_nodes()]
    assert len(nodes) == 2 and max(nodes) > 1
    first = prepared.moving.passing(tile_azimuths(prepared, 0, 0))
    assert first is not None
    assert engine_counts(SetUp(prepared, Culling(), 0, 0)).moving_echoes == len(first.echoes) > 0
    ticks = itertools.count()
    monkeypatch.setattr(time, "thread_time", lambda: float(next(ticks)))
    radar = prepared.scene.radar
    updates = radar.spoke_period / prepared.moving.visibility.interval
    assert engine_costs(prepared).looks == pytest.approx(1e6 * (updates + sum(nodes) / radar.azimuths))


def test_stages_that_a_scene_lacks_cost_nothing() -> None:
    costs = engine_costs(prepared_from([point("t", 0, 500)]))
    assert (costs.clutter, costs.interference) == (0.0, 0.0)
    assert costs.profiles > 0.0


def test_statistics_have_counts_costs_and_what_was_culled() -> None:
    culling = Culling(effects={"gas": -80.0})
    statistics = engine_statistics(SetUp(prepared_from([point("t", 0, 500)]), culling, 0, 0))
    assert statistics.culling is culling and statistics.counts is not None and statistics.costs is not None
    assert statistics.bodies is not None and statistics.bodies.echoes.tolist() == [1]
