"""Mesh files: formats, transforms, what is dropped and warned of, and what is refused."""

import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh

from radar_service.scene.error import SceneError
from radar_service.scene.gltf_check import check_gltf
from radar_service.scene.mesh import mesh_from_bytes

CUBE = trimesh.creation.box((1.0, 2.0, 3.0))


def exported(kind: str, **options: Any) -> bytes:
    content = CUBE.export(file_type=kind, **options)
    return content.encode() if isinstance(content, str) else bytes(content)


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


def test_obj_polygons_negative_numbers_and_continued_lines() -> None:
    content = (
        b"mtllib ../../etc/passwd\nusemtl x\nv 0 0 0\nv 1 0 0 # east\nv 1 1 0\nv 0 1 0\ng a\nf -4/1/1 -3//2 \\\n -2 -1\n"
    )
    mesh = mesh_from_bytes(content, "a.obj", "m").mesh
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


def test_glb_places_every_node() -> None:
    scene = trimesh.Scene()
    scene.add_geometry(CUBE, transform=trimesh.transformations.translation_matrix([10, 0, 0]))
    scene.add_geometry(CUBE.copy(), transform=trimesh.transformations.translation_matrix([0, 20, 0]))
    mesh = mesh_from_bytes(scene.export(file_type="glb"), "a.glb", "m").mesh
    assert len(mesh.faces) == 24
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [-0.5, -1, -1.5], atol=1e-6)  # float32 of the format
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [10.5, 21, 1.5], atol=1e-5)


@pytest.mark.parametrize(
    "extra, said",
    [
        (b"f 1 2 2\nf 1 2 1\n", "2 triangles without area dropped"),
        (b"f 4 1 2\n", "1 duplicate triangles dropped"),
        (b"v 9 0 0\nv 9 1 0\nv 9 0 1\nf 9 10 11\n", "not watertight (3 open edges)"),
        (b"f 8 1 4\n", "edges shared by more than two triangles"),
    ],
)
def test_odd_meshes_load_with_a_warning(extra: bytes, said: str) -> None:
    vertices = b"".join(b"v %g %g %g\n" % (x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1))
    loaded = mesh_from_bytes(vertices + CLOSED_FACES + extra, "a.obj", "m")
    assert any(said in finding for finding in loaded.findings), loaded.findings
    assert len(loaded.mesh.faces) == (12 if "dropped" in said else 13)


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


def refused(content: bytes, name: str) -> str:
    with pytest.raises(SceneError) as caught:
        mesh_from_bytes(content, name, "body[0].mesh: a")
    assert str(caught.value).startswith("body[0].mesh: a")
    return str(caught.value)


@pytest.mark.parametrize(
    "content, said",
    [
        (b"", "is empty"),
        (b"   \n", "is empty"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
        (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "none of its 1 triangles has an area"),
        (b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "1 vertices are not finite"),
        (b"v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n", "1 vertices are not finite"),
        (b"v 0 0 0\nv 1 0 1e400\nv 0 1 0\nf 1 2 3\n", "1 vertices are not finite"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 3e6\nf 1 2 3\n", "a vertex lies 3e+06 m from the mesh's origin"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "faces refer to vertices 0 to 3, but there are only 3"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "numbered from 1"),
        (b"v 0 0 0\nf -1 -2 -1\n", "line 2: a face counts back"),
        (b"v 0 0 0\nf 1 2 0\n", "line 2: a face needs three or more vertices, numbered from 1"),
        (b"v 0 0 0\nf 1 2 x\n", "line 2: a face needs vertex numbers"),
        (b"v 0 0\nf 1 2 3\n", "line 1: a vertex of 2 numbers"),
        (b"v 0 0 zero\nf 1 1 1\n", "in a vertex"),
        (b"# nothing here\nhello\n", "looks like text of another kind"),
        (b"<html></html>", "looks like JSON or XML"),
        (b"\x89PNG\r\n\x1a\n\0\0", "looks like PNG"),
        (exported("stl"), "looks like stl"),
        (exported("glb"), "looks like glb"),
        (exported("ply"), "looks like ply"),
    ],
)
def test_bad_obj_files(content: bytes, said: str) -> None:
    assert said in refused(content, "a.obj")


def stl_claiming(count: int) -> bytes:
    return exported("stl")[:80] + struct.pack("<I", count) + exported("stl")[84:]


@pytest.mark.parametrize(
    "name, content, said",
    [
        ("a.stl", stl_claiming(4_000_000_000), "is not STL"),
        ("a.stl", stl_claiming(11), "cut short or padded (684 bytes, not 634)"),
        ("a.stl", exported("stl")[:-20], "cut short or padded (664 bytes, not 684)"),
        ("a.stl", b"\0" * 84, "no triangles"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nendsolid a\n", "body[0]"),
        ("a.stl", struct.pack("<80xI", 1) + struct.pack("<12f2x", *[float("nan")] * 12), "not finite"),
        ("a.ply", exported("ply").replace(b"element face 12", b"element face -1"), "a count from 0 is needed"),
        ("a.ply", exported("ply").replace(b"element face 12", b"element face 4000000"), "promises at least"),
        (
            "a.ply",
            exported("ply").replace(b"element face 12", b"element face 9999999"),
            "9999999 triangles; at most 5000000",
        ),
        ("a.ply", exported("ply").replace(b"element vertex 8", b"element vertex 99999999"), "promises at least"),
        ("a.ply", exported("ply").replace(b"property float x", b"property quad x"), "unknown"),
        ("a.ply", exported("ply").replace(b"end_header", b"fin_header"), "does not end"),
        ("a.ply", exported("ply")[:-30], "body[0]"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", "no triangles"),
        ("a.gltf", b"{}", ".gltf is not read"),
        ("a.zip", b"PK\x03\x04", ".zip is not read"),
        ("a.exe", b"MZ", 'its ending ".exe"'),
        ("noending", b"v 0 0 0", 'its ending ""'),
    ],
)
def test_bad_stl_and_ply_files(name: str, content: bytes, said: str) -> None:
    assert said in refused(content, name)


def glb_with(change: Callable[[dict[str, Any]], object]) -> bytes:
    """The cube as GLB with its JSON changed."""
    content = exported("glb")
    size = struct.unpack_from("<I", content, 12)[0]
    tree = json.loads(content[20 : 20 + size])
    change(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + size :]
    return (
        b"glTF" + struct.pack("<II", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest
    )


def chain(tree: dict[str, Any]) -> None:
    count = 20_000
    tree["nodes"] = [{"children": [k + 1]} for k in range(count)] + [{"mesh": 0}]
    tree["scenes"] = [{"nodes": [0]}]


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda t: t["accessors"][0].update(count=2**30), "ends at byte"),
        (lambda t: t["accessors"][0].update(count=-3), "-3 where a count belongs"),
        (lambda t: t["accessors"][0].update(count=1.5), "1.5 where a count belongs"),
        (lambda t: t["accessors"][0].pop("bufferView"), "has no buffer view"),
        (lambda t: t["accessors"][0].update(sparse={"count": 1}), "is sparse"),
        (lambda t: t["accessors"][0].update(componentType=7), "is not glTF"),
        (lambda t: t["bufferViews"][0].update(byteLength=10**12), "a buffer view ends at byte"),
        (lambda t: t["bufferViews"][0].update(byteOffset=-4), "-4 where a count belongs"),
        (lambda t: t["buffers"][0].update(uri="../secret.bin"), 'keeps data outside ("../secret.bin")'),
        (lambda t: t["buffers"][0].update(uri="file:///etc/passwd"), "keeps data outside"),
        (lambda t: t["buffers"].append({"byteLength": 4}), "has 2 buffers"),
        (lambda t: t.update(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
        (lambda t: t["meshes"][0]["primitives"][0].update(mode=5), "strips or fans"),
        (lambda t: t["meshes"][0]["primitives"][0].update(mode=0), "no triangles"),
        (lambda t: t["meshes"][0]["primitives"][0].update(indices=99), "is not glTF"),
        (lambda t: t["meshes"][0]["primitives"][0]["attributes"].pop("POSITION"), "is not glTF"),
        (lambda t: t["nodes"].extend([{}] * 100_001), "nodes; at most 100000"),
        (chain, "more than 100 deep or in a circle"),
        (lambda t: t.update(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]), "more than 100 deep or in a circle"),
        (lambda t: t.update(nodes=[{"children": [2]}, {"children": [2]}, {"mesh": 0}]), "hangs under two others"),
        (lambda t: t.update(nodes=7), "is not glTF"),
    ],
)
def test_bad_glb_files(change: Callable[[dict[str, Any]], object], said: str) -> None:
    assert said in refused(glb_with(change), "a.glb")


def test_glb_lengths() -> None:
    content = exported("glb")
    assert "a chunk claims 4294967295 bytes" in refused(content[:12] + b"\xff\xff\xff\xff" + content[16:], "a.glb")
    assert "not GLB version 2" in refused(content[:-4], "a.glb")
    assert "not GLB version 2" in refused(b"glTF" + struct.pack("<II", 2, 12), "a.glb")
    deep = b"[" * 100_000
    head = b"glTF" + struct.pack("<II", 2, 20 + len(deep)) + struct.pack("<I4s", len(deep), b"JSON")
    assert "its JSON is broken" in refused(head + deep, "a.glb")


def test_instances_count_as_often_as_they_are_placed() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=4)  # 5120 triangles
    scene = trimesh.Scene()
    scene.add_geometry(sphere, geom_name="s")
    for k in range(999):
        scene.add_geometry(sphere, geom_name="s", node_name=f"n{k}", transform=np.eye(4))
    content = scene.export(file_type="glb")
    count = json.loads(content[20 : 20 + struct.unpack_from("<I", content, 12)[0]])["nodes"]
    copies = sum("mesh" in node for node in count)
    said = refused(content, "a.glb")
    assert f"{copies * 5120} triangles; at most 5000000" in said


def test_accessors_that_share_bytes_are_summed() -> None:
    """1100 accessors over one megabyte unpack to more than a gigabyte, whatever the file's size."""
    accessor = {"bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 2**18}
    tree = {"buffers": [{}], "bufferViews": [{"byteLength": 2**20}], "accessors": [accessor] * 1100}
    with pytest.raises(SceneError, match="its accessors unpack to 1153433600 bytes"):
        check_gltf(tree, 2**20, "m")
