"""Triangles of mesh files: formats, transforms, removed faces and warnings."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from radar_service.scene_file.readers import formats
from tests.plug_ins import join
from tests.scene_file.readers.mesh_files import CUBE, exported, mesh_from_bytes


@pytest.mark.parametrize(
    "name, content",
    [
        ("a.obj", exported("obj")),
        ("a.STL", exported("stl")),
        ("a.stl", exported("stl_ascii")),
        ("a.ply", exported("ply")),
        ("a.ply", exported("ply", encoding="ascii")),
        ("a.glb", exported("glb")),
        ("solid.stl", b"solid by habit".ljust(80) + exported("stl")[80:]),
    ],
)
def test_formats(name: str, content: bytes) -> None:
    loaded = mesh_from_bytes(content, name, "m")
    assert loaded.findings == ()
    assert len(loaded.mesh.faces) == 12
    np.testing.assert_allclose(np.ptp(loaded.mesh.vertices, axis=0), [1, 2, 3], rtol=1e-6)  # STL holds float32
    a, b, c = loaded.mesh.vertices[loaded.mesh.faces].transpose(1, 0, 2)
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(6.0, rel=1e-6)  # outward, whole


def test_scale_and_up() -> None:
    content = b"v 1 2 3\nv 2 2 3\nv 1 5 3\nf 1 2 3\n"
    mesh = mesh_from_bytes(content, "a.obj", "m", scale=0.5, up="y").mesh
    np.testing.assert_array_equal(mesh.vertices, 0.5 * np.array([[1, -3, 2], [2, -3, 2], [1, -3, 5]]))


def test_a_format_may_have_another_unit_and_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    """In inches with y up, unless the scene says otherwise."""
    join(monkeypatch, "readers", "obj", replace(formats.formats_of("obj")[0], unit=0.0254, up="y"))
    content = b"v 1 2 3\nv 2 2 3\nv 1 5 3\nf 1 2 3\n"
    cases: list[tuple[dict[str, Any], list[float]]] = [
        ({}, [0.0254, -0.0762, 0.0508]),
        ({"scale": 1.0}, [1, -3, 2]),
        ({"scale": 2.0, "up": "z"}, [2, 4, 6]),
    ]
    for keys, first in cases:
        mesh = mesh_from_bytes(content, "a.obj", "m", **keys).mesh
        np.testing.assert_allclose(mesh.vertices[0], first, rtol=1e-15)  # one product


def test_glb_places_every_node() -> None:
    scene = trimesh.Scene()
    scene.add_geometry(CUBE, transform=trimesh.transformations.translation_matrix([10, 0, 0]))
    scene.add_geometry(CUBE.copy(), transform=trimesh.transformations.translation_matrix([0, 20, 0]))
    mesh = mesh_from_bytes(scene.export(file_type="glb"), "a.glb", "m").mesh
    assert len(mesh.faces) == 24
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [-0.5, -1, -1.5], atol=1e-6)  # float32 of the format
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [10.5, 21, 1.5], atol=1e-5)


@pytest.mark.parametrize(
    "extra, message",
    [
        (b"f 1 2 2\nf 1 2 1\n", "2 triangles without area dropped"),
        (b"f 4 1 2\n", "1 duplicate triangles dropped"),
        (b"v 9 0 0\nv 9 1 0\nv 9 0 1\nf 9 10 11\n", "not watertight (3 open edges)"),
        (b"f 8 1 4\n", "edges shared by more than two triangles"),
    ],
)
def test_defective_meshes_load_with_a_warning(extra: bytes, message: str) -> None:
    vertices = b"".join(b"v %g %g %g\n" % (x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1))
    loaded = mesh_from_bytes(vertices + CLOSED_FACES + extra, "a.obj", "m")
    assert any(message in finding for finding in loaded.findings), loaded.findings
    assert len(loaded.mesh.faces) == (12 if "dropped" in message else 13)


# The unit cube on vertices 1 to 8, numbered 1 + 4x + 2y + z, wound outward.
CLOSED_FACES = (
    b"f 1 2 4\nf 1 4 3\nf 5 7 8\nf 5 8 6\nf 1 5 6\nf 1 6 2\nf 3 4 8\nf 3 8 7\nf 1 3 7\nf 1 7 5\nf 2 6 8\nf 2 8 4\n"
)


def test_inconsistent_winding_is_counted() -> None:
    vertices = b"".join(b"v %g %g %g\n" % (x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1))
    assert mesh_from_bytes(vertices + CLOSED_FACES, "a.obj", "m").findings == ()
    turned = CLOSED_FACES.replace(b"f 1 2 4\n", b"f 4 2 1\n")
    assert mesh_from_bytes(vertices + turned, "a.obj", "m").findings == ("winding inconsistent across 3 edges",)


def test_thin_triangles_far_out_are_kept() -> None:
    """A triangle of 1 mm, 100 km from the mesh's origin, has an area; scale says nothing about being degenerate."""
    content = b"v 100000 0 0\nv 100000.001 0 0\nv 100000 0.001 0\nf 1 2 3\n"
    assert len(mesh_from_bytes(content, "a.obj", "m").mesh.faces) == 1
