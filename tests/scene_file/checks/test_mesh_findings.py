"""Sentences about mesh files: each finding once, open edges of many meshes in one line, holes in height maps as warnings."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.checks.mesh_findings import axis_findings, mesh_notes, mesh_warnings
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.body import MeshBodyModel
from radar_service.world.poses import pose_at
from radar_service.world.shapes import box

OPEN, WINDING = "not watertight (3 open edges)", "winding inconsistent across 2 edges"
HOLES, KEPT = "7 samples without data become sea", "6 of 200 triangles kept, those above the sea and within radar coverage"


def test_a_mesh_without_findings_gives_no_sentence() -> None:
    meshes = [("body[0].mesh", "a.obj", ())]
    assert [*mesh_notes(meshes), *mesh_warnings(meshes)] == []


def test_a_single_open_mesh_is_noted_with_its_edges() -> None:
    meshes = [("body[0].mesh", "a.obj", ()), ("body[1].mesh", "b.obj", (OPEN, WINDING))]
    assert list(mesh_notes(meshes)) == [f"body[1].mesh: b.obj: {OPEN}, {WINDING}"] and not list(mesh_warnings(meshes))


def test_many_open_meshes_are_counted_in_one_line_and_other_findings_stay() -> None:
    meshes = [(f"body[{k}].mesh", "a.obj", (OPEN, WINDING) if k == 3 else (OPEN,)) for k in range(19)]
    assert list(mesh_notes(meshes)) == [
        f"body[3].mesh: a.obj: {WINDING}", "19 meshes are not watertight: body[0].mesh, body[1].mesh and 17 more",
    ]  # fmt: skip
    assert list(mesh_notes(meshes[:2])) == ["2 meshes are not watertight: body[0].mesh, body[1].mesh"]


def test_findings_of_a_file_are_told_once_for_all_its_bodies() -> None:
    """Two files of the same findings stay apart, and so do two findings of one file (another scale may be to blame)."""
    meshes = [(f"body[{k}].mesh", "ab"[k % 2] + ".obj", (WINDING,)) for k in range(7)] + [("body[7].mesh", "a.obj", (KEPT,))]
    assert list(mesh_notes(meshes)) == [
        f"body[0].mesh, body[2].mesh and 2 more: a.obj: {WINDING}", f"body[1].mesh, body[3].mesh and 1 more: b.obj: {WINDING}",
        f"body[7].mesh: a.obj: {KEPT}",
    ]  # fmt: skip


def test_missing_ground_is_a_warning_and_ground_out_of_reach_a_note() -> None:
    maps = [("body[0].heightmap", "h.tif", (HOLES, KEPT))]
    assert list(mesh_warnings(maps)) == [f"body[0].heightmap: h.tif: {HOLES}"]
    assert list(mesh_notes(maps)) == [f"body[0].heightmap: h.tif: {KEPT}"]


def test_the_scene_that_serve_runs_by_default_has_no_warning() -> None:
    harbour = load_scene("harbour")
    assert harbour.warnings == () and sum("not watertight" in note for note in harbour.notes) == 1


LONG_IN_X, LONG_IN_Y = box(2.0, 6.0, 1.0), box(6.0, 2.0, 1.0)  # length along y, then beam


def body(**keys: Any) -> MeshBodyModel:
    return MeshBodyModel.model_validate({"name": "b", "mesh": "b.obj", **keys})


@pytest.mark.parametrize(
    ("keys", "noted"),
    [({}, True), ({"up": "z"}, False), ({"up": "y"}, False), ({"mesh": "b.obj"}, False), ({"mesh": "B.GLB"}, True)],
)
def test_a_glb_without_up_is_noted(keys: dict[str, Any], noted: bool) -> None:
    findings = axis_findings(body(**{"mesh": "b.glb", **keys}), LONG_IN_Y)
    assert [f.split(":")[1] for f in findings] == [' set up = "y", or up = "z" if this file has z up'] * noted


@pytest.mark.parametrize(
    ("keys", "noted"),
    [
        ({"speed_kn": 5}, True), ({}, False), ({"speed_kn": 5, "drift_deg": 90}, False), ({"speed_kn": 5, "drift_deg": 5}, True),
        ({"speed_kn": 5, "course_deg": 0, "heading_deg": 270}, False), ({"track": "a.csv"}, True),
        ({"waypoints": [{"position_m": [9, 9], "speed_kn": 3}]}, True),
    ],
)  # fmt: skip
def test_a_mesh_that_sails_by_its_side_is_noted(keys: dict[str, Any], noted: bool) -> None:
    findings = axis_findings(body(**keys), LONG_IN_X)
    assert [f.split(":")[0] for f in findings] == ["under way by its side"] * noted
    assert axis_findings(body(**keys), LONG_IN_Y) == ()


def test_the_remedy_points_x_along_the_course(tmp_path: Path) -> None:
    """At 37 degrees, also while she turns; the note reaches the scene without it and is gone with it."""
    points = [f"v {x} {y} {z}\n" for x in (0, 6) for y in (0, 2) for z in (0, 1)]
    (tmp_path / "b.obj").write_text("".join(points) + "f 1 2 3\nf 5 6 7\n")
    boat = {"name": "b", "mesh": "b.obj", "position_m": [0, 500, 0], "course_deg": 37, "speed_kn": 4, "turn_rate_deg_s": 1}
    plain, turned = (rs.load_scene({"body": [{**boat, **more}]}, folder=tmp_path) for more in ({}, {"drift_deg": 90}))
    assert any("drift_deg = 90" in note for note in plain.notes) and not any("drift_deg" in note for note in turned.notes)
    bow = pose_at(turned.bodies[0], 0.0).map_from_frame(np.array([[1.0, 0.0, 0.0]]))[0] - [0, 500, 0]
    assert bow[:2] == pytest.approx([math.sin(math.radians(37)), math.cos(math.radians(37))], abs=1e-9)  # rounding
