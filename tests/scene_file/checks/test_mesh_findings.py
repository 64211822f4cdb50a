"""Sentences about mesh files: each finding once, open edges of many meshes in one line, holes in height maps as warnings."""

from radar_service.scene_file.checks.mesh_findings import mesh_notes, mesh_warnings
from radar_service.scene_file.load import load_scene

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
