"""Counts of prepared engines by hand."""

from typing import Any

import pytest

import radar_service as rs
from radar_service.engine.preparation import Prepared, prepare
from radar_service.plan.cost_model import (
    SetUp,
    counts_per_body,
    engine_counts,
    engine_statistics,
    first_visibility_update,
)
from radar_service.plan.culling import CulledBody
from radar_service.records.fidelity import PRESETS
from radar_service.trace.embree import RayCount
from tests.scenes import point, scene

SMALL = {"azimuths": 120, "beamwidth_deg": 7.5, "range_max_m": 1500, "pulse_s": 2e-6, "rpm": 24}
PLATE = {"name": "plate", "shape": "plate", "width_m": 20, "height_m": 20, "position_m": [0, 600, 8], "heading_deg": 180,
         "rcs_dbsm": 20, "speed_kn": 12, "course_deg": 90}  # fmt: skip


def prepared_from(bodies: list[dict[str, Any]], rays: RayCount | None = None, **sections: Any) -> Prepared:
    made: rs.Scene = scene(bodies, radar=SMALL, **sections)
    return prepare(made, PRESETS["balanced"], 0, rays=rays)


def test_resting_and_moving_points_are_counted() -> None:
    """12 kn for 2.5 s in steps of 5 m: 3.087 visibility updates per scan."""
    bodies = [point("a", 0, 500), point("b", 700, 0), point("c", -300, 300, speed_kn=12, course_deg=90)]
    prepared = prepared_from(bodies)
    counts = engine_counts(SetUp(prepared, {}, 17, 4))
    assert (counts.resting_echoes, counts.moving_echoes, counts.shadowed_echoes, counts.scatterers) == (2, 1, 0, 3)
    assert (counts.set_up_rays, counts.look_rays) == (17, 4)
    assert counts.looks_per_scan == pytest.approx(12 * 1852 / 3600 * 2.5 / 5.0)
    assert counts.transform_samples == 2 * prepared.compression.size
    per_body = counts_per_body(prepared)
    assert per_body.scatterers.tolist() == per_body.echoes.tolist() == [1, 1, 1]


def test_a_passing_plate_shadows_the_point_behind_it() -> None:
    prepared = prepared_from([point("behind", 0, 900, 10.0), PLATE])
    assert engine_counts(SetUp(prepared, {}, 0, 0)).shadowed_echoes == 1


def test_the_first_visibility_update_is_cached() -> None:
    rays = RayCount()
    prepared = prepared_from([point("behind", 0, 900, 10.0), PLATE], rays)
    cast = rays.rays
    first_visibility_update(prepared)
    update = rays.rays
    assert update > cast
    first_visibility_update(prepared)
    assert rays.rays == update


def test_statistics_have_counts_costs_and_what_was_culled() -> None:
    culled = {0: CulledBody("always out of range", 0.0, occludes=False)}
    statistics = engine_statistics(SetUp(prepared_from([point("t", 0, 500)]), culled, 0, 0))
    assert statistics.culled is culled and statistics.counts is not None and statistics.costs is not None
    assert statistics.bodies is not None and statistics.bodies.echoes.tolist() == [1]
