"""Warnings about mesh files: each defect once, open edges of many meshes in one line."""

from radar_service.scene.checks.mesh_defects import mesh_warnings
from radar_service.scene.load import load_scene

OPEN, WINDING = "not watertight (3 open edges)", "winding inconsistent across 2 edges"


def test_a_mesh_without_defects_gives_no_warning() -> None:
    assert list(mesh_warnings([("body[0].mesh", "a.obj", ())])) == []


def test_a_single_open_mesh_is_told_with_its_edges() -> None:
    meshes = [("body[0].mesh", "a.obj", ()), ("body[1].mesh", "b.obj", (OPEN, WINDING))]
    assert list(mesh_warnings(meshes)) == [f"body[1].mesh: b.obj: {OPEN}, {WINDING}"]


def test_many_open_meshes_are_counted_in_one_line_and_other_defects_stay() -> None:
    meshes = [(f"body[{k}].mesh", "a.obj", (OPEN, WINDING) if k == 3 else (OPEN,)) for k in range(19)]
    assert list(mesh_warnings(meshes)) == [
        f"body[3].mesh: a.obj: {WINDING}", "19 meshes are not watertight: body[0].mesh, body[1].mesh and 17 more",
    ]  # fmt: skip
    assert list(mesh_warnings(meshes[:2])) == ["2 meshes are not watertight: body[0].mesh, body[1].mesh"]


def test_the_scene_that_serve_runs_by_default_has_no_warning() -> None:
    assert load_scene("harbour").warnings == ()
