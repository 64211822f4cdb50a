"""The short modules of scene_file/readers, each under its name."""

import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from radar_service.numerics.types import Floats, Indices
from radar_service.scene_file.model.body import HeightMapBodyModel
from radar_service.scene_file.readers import formats
from radar_service.scene_file.readers.file_format import (
    IN_PROCESS,
    MAX_FACES,
    Format,
    Triangles,
    check_face_count,
    check_range,
    refusals,
)
from radar_service.scene_file.readers.formats import detected_format, format_of, own_formats
from radar_service.scene_file.readers.glb import check_gltf
from radar_service.scene_file.readers.heightmap import Coverage, HeightMapFile
from radar_service.scene_file.readers.mesh import flat_copies, numbered_edges
from radar_service.scene_file.readers.track import motion_from_track
from radar_service.scene_file.readers.trimesh_parser import trimesh_triangles
from radar_service.world.error import SceneError
from radar_service.world.shapes import cylinder, sphere
from tests.plug_ins import join
from tests.scattering.physical_optics.meshes import ODD, cross_section, loaded, optical, toward
from tests.scene_file.readers.height_maps import npy
from tests.scene_file.readers.mesh_files import CUBE, chain, exported, glb_with, mesh_from_bytes, refused, stl_claiming


# file_format: what all formats share: limits of counts, ranges of vertex numbers, and the refusal of what a parser cannot read.
def test_five_million_triangles_are_allowed() -> None:
    check_face_count(MAX_FACES, "m")
    with pytest.raises(SceneError, match="^m: the mesh has 5000001 triangles; at most 5000000 are allowed: simplify it$"):
        check_face_count(MAX_FACES + 1, "m")


@pytest.mark.parametrize(("faces", "refused"), [([[0, 1, 2]], False), ([[0, 1, 3]], True), ([[-1, 1, 2]], True)])
def test_faces_refer_to_vertices_that_are_there(faces: list[list[int]], refused: bool) -> None:
    if not refused:
        return check_range(np.zeros((3, 3)), np.array(faces), "m")
    with pytest.raises(SceneError, match="^m: faces refer to vertices .*, but there are only 3 "):
        check_range(np.zeros((3, 3)), np.array(faces), "m")


def test_points_on_a_plane_are_refused_only_where_faces_need_them() -> None:
    check_range(np.zeros((3, 2)), np.zeros((0, 3), dtype=np.int64), "m")
    with pytest.raises(SceneError, match="not points in space"):
        check_range(np.zeros((3, 2)), np.array([[0, 1, 2]]), "m")


def test_a_refusal_is_one_line_with_the_reason_if_there_is_one() -> None:
    for error, reason in ((ValueError("a\nb"), "ValueError: a b"), (KeyError(), "KeyError")):
        with pytest.raises(SceneError) as refused, refusals("ply", "m"):
            raise error
        assert str(refused.value) == f"m: the file is not readable as PLY ({reason}); export it again"
    with pytest.raises(MemoryError), refusals("ply", "m"):
        raise MemoryError


# glb: GLB files whose chunks are not what they declare are refused.
def test_glb_lengths() -> None:
    content = exported("glb")
    assert "a chunk declares 4294967295 bytes" in refused(content[:12] + b"\xff\xff\xff\xff" + content[16:], "a.glb")
    assert "not that of GLB version 2" in refused(content[:-4], "a.glb")
    assert "not that of GLB version 2" in refused(b"glTF" + struct.pack("<II", 2, 12), "a.glb")
    deep = b"[" * 100_000
    head = b"glTF" + struct.pack("<II", 2, 20 + len(deep)) + struct.pack("<I4s", len(deep), b"JSON")
    assert "the JSON is invalid" in refused(head + deep, "a.glb")


# ply: PLY files whose header declares what cannot be true are refused.
@pytest.mark.parametrize(
    "name, content, message",
    [
        ("a.ply", exported("ply").replace(b"element face 12", b"element face -1"), "a count from 0 is needed"),
        ("a.ply", exported("ply").replace(b"element face 12", b"element face 4000000"), "declares at least"),
        ("a.ply", exported("ply").replace(b"element face 12", b"element face 9999999"), "9999999 triangles; at most 5000000"),
        ("a.ply", exported("ply").replace(b"element vertex 8", b"element vertex 99999999"), "declares at least"),
        ("a.ply", exported("ply").replace(b"property float x", b"property quad x"), "unknown"),
        ("a.ply", exported("ply").replace(b"end_header", b"fin_header"), "does not end"),
        ("a.ply", exported("ply")[:-30], "body[0]"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", "no triangles"),
    ],
)  # fmt: skip
def test_bad_ply_files(name: str, content: bytes, message: str) -> None:
    assert message in refused(content, name)


# stl: STL files whose size is not the one they declare, or without triangles, are refused.
@pytest.mark.parametrize(
    "name, content, message",
    [
        ("a.stl", stl_claiming(4_000_000_000), "is not STL"),
        ("a.stl", stl_claiming(11), "cut short or padded (684 bytes, not 634)"),
        ("a.stl", exported("stl")[:-20], "cut short or padded (664 bytes, not 684)"),
        ("a.stl", b"\0" * 84, "no triangles"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nendsolid a\n", "body[0]"),
        ("a.stl", struct.pack("<80xI", 1) + struct.pack("<12f2x", *[float("nan")] * 12), "not finite"),
    ],
)
def test_bad_stl_files(name: str, content: bytes, message: str) -> None:
    assert message in refused(content, name)


# trimesh_parser: trimesh as a parser: what it cannot read is a refusal, and files without surfaces have no triangles.


def test_points_are_no_triangles() -> None:
    cloud = trimesh.PointCloud(np.eye(3)).export(file_type="ply")
    assert [array.shape for array in trimesh_triangles("ply", cloud, "m")] == [(0, 3), (0, 3)]


def test_what_it_cannot_read_is_a_refusal() -> None:
    with pytest.raises(SceneError, match=r"^m: the file is not readable as GLB \(.+\); export it again$"):
        trimesh_triangles("glb", b"glTF", "m")


# The reader in this process: what the parsers of meshes and height maps return, at the location of the body.
EVERYWHERE = Coverage(0.0, 0.0, np.inf)
BODY = HeightMapBodyModel(name="land", heightmap="h.npy", extent_m=(20.0, 10.0))


def test_a_height_map_stands_at_its_position() -> None:
    start = np.array([100.0, 200.0, 3.0])
    content = npy(np.full((2, 2), 7.0))
    (land,) = IN_PROCESS.read(HeightMapFile(content, "h.npy", BODY, start, None, EVERYWHERE, "body[0]"))
    assert land.position is not None
    np.testing.assert_allclose(land.position, start)
    low, high = land.mesh.vertices.min(axis=0), land.mesh.vertices.max(axis=0)
    np.testing.assert_allclose(
        [low, high], [[-10.0, -5.0, -4.0], [10.0, 5.0, 7.0]], atol=1e-12
    )  # its skirt ends 1 m below sea


def test_errors_name_the_file() -> None:
    with pytest.raises(SceneError, match=r"^body\[0\].heightmap: h.npy: this is not a NPY file"):
        IN_PROCESS.read(HeightMapFile(b"no array", "h.npy", BODY, np.zeros(3), None, EVERYWHERE, "body[0]"))


# obj: OBJ files: polygons, negative numbers, continued lines, bad lines.
def test_obj_polygons_negative_numbers_and_continued_lines() -> None:
    content = (
        b"mtllib ../../etc/passwd\nusemtl x\nv 0 0 0\nv 1 0 0 # east\nv 1 1 0\nv 0 1 0\ng a\nf -4/1/1 -3//2 \\\n -2 -1\n"
    )
    mesh = mesh_from_bytes(content, "a.obj", "m").mesh
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize(
    "content, message",
    [
        (b"", "is empty"),
        (b"   \n", "is empty"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
        (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "none of the 1 triangles has an area"),
        (b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "1 vertices are not finite"),
        (b"v 0 0 0\nv 1 0 1e400\nv 0 1 0\nf 1 2 3\n", "1 vertices are not finite"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 3e6\nf 1 2 3\n", "a vertex is 3e+06 m from the mesh's origin"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "faces refer to vertices 0 to 3, but there are only 3"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "numbered from 1"),
        (b"v 0 0 0\nf -1 -2 -1\n", "line 2: a face counts back"),
        (b"v 0 0 0\nf 1 2 0\n", "line 2: a face needs three or more vertices, numbered from 1"),
        (b"v 0 0 0\nf 1 2 x\n", "line 2: a face needs vertex numbers"),
        (b"v 0 0\nf 1 2 3\n", "line 1: a vertex has 2 numbers"),
        (b"v 0 0 zero\nf 1 1 1\n", "in a vertex"),
        (b"# nothing here\nhello\n", "looks like text of another kind"),
        (b"<html></html>", "looks like JSON or XML"),
        (b"\x89PNG\r\n\x1a\n\0\0", "looks like PNG"),
        (exported("stl"), "looks like stl"),
        (exported("glb"), "looks like glb"),
        (exported("ply"), "looks like ply"),
    ],
)
def test_bad_obj_files(content: bytes, message: str) -> None:
    assert message in refused(content, "a.obj")


# track: track files: map and geographic positions, headings, bad lines.
TINY = 1e-9  # m: rounding of positions of a few km in float64


def test_track_on_the_map_turns_the_short_way() -> None:
    content = b"\xef\xbb\xbftime_s, east_m, north_m, up_m, heading_deg\r\n10,0,0,1,350\r\n\r\n20,100,0,3,20\r\n"
    motion = motion_from_track(content, "track", None, None)
    pose = motion.pose(np.array([0.0, 15.0, 99.0]))
    np.testing.assert_allclose(pose.position, [[0, 0, 1], [50, 0, 2], [100, 0, 3]], atol=TINY)
    np.testing.assert_allclose(np.rad2deg(pose.heading), [350.0, 5.0, 20.0], atol=1e-9)


def test_track_on_the_earth_heads_along_its_legs() -> None:
    content = b"time_s,latitude_deg,longitude_deg\n0,50.9,1.4\n10,50.9,1.5\n20,50.9,1.5\n30,51.0,1.5\n"
    pose = motion_from_track(content, "track", None, (50.9, 1.4)).pose(np.array([5.0, 15.0, 25.0]))
    # headings bend by the meridian convergence of 0.1 degree of longitude: 0.1 sin(50.9)
    np.testing.assert_allclose((np.rad2deg(pose.heading) + 10) % 360, [100, 100, 10], atol=0.1)
    # 0.1 degree at 50.9 N is 7034.85 m east: pi/180 x N cos(latitude) / 10 on WGS 84
    assert pose.position[2, 0] == pytest.approx(7034.85, abs=8.0)  # the leg north runs 8 m west at half of its length


@pytest.mark.parametrize(
    "content, message",
    [
        (b"", "(none); a track needs time_s"),
        (b"time_s,east_m\n0,0\n", "has the columns time_s, east_m"),
        (b"time_s,east_m,north_m,latitude_deg\n0,0,0,0\n", "a track needs time_s"),
        (b"time_s,east_m,north_m,speed\n0,0,0,0\n", "a track needs time_s"),
        (b"time_s,east_m,north_m\n", "0 rows of data"),
        (b"time_s,east_m,north_m\n0,0,0\n\n0,1,1\n", "line 4: time_s 0 is not above 0 of the row before"),
        (b"time_s,east_m,north_m\n0,0,0\n1,nan,1\n", 'line 3: east_m is "nan"'),
        (b"time_s,east_m,north_m\n0,0,0\n1,x,1\n", 'line 3: east_m is "x"'),
        (b"time_s,east_m,north_m\n0,0\n", "line 2: the row has 2 values for 3 columns"),
        (b"time_s,east_m,north_m\n0,0,3e6\n", "line 2: [0.0, 3000000.0, 0.0] m is too far"),
        (b"time_s,latitude_deg,longitude_deg\n0,91,0\n", "line 2: latitude 91"),
        (b"time_s,east_m,north_m\n\xff", "the file is not CSV in UTF-8"),
        (b'time_s,"east_m\n', "has the columns"),
    ],
)
def test_bad_tracks_name_the_line(content: bytes, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        motion_from_track(content, "body[0].track: t.csv", None, (0.0, 0.0))
    assert str(caught.value).startswith("body[0].track: t.csv") and message in str(caught.value)


def test_track_on_the_earth_needs_an_origin() -> None:
    with pytest.raises(SceneError, match="need an .origin."):
        motion_from_track(b"time_s,latitude_deg,longitude_deg\n0,1,1\n", "track", None, None)


# glb: GLB files whose JSON declares what cannot be true are refused.
@pytest.mark.parametrize(
    "change, message",
    [
        (lambda t: t["accessors"][0].update(count=2**30), "ends at byte"),
        (lambda t: t["accessors"][0].update(count=-3), "-3 is not a count"),
        (lambda t: t["accessors"][0].update(count=1.5), "1.5 is not a count"),
        (lambda t: t["accessors"][0].pop("bufferView"), "has no buffer view"),
        (lambda t: t["accessors"][0].update(sparse={"count": 1}), "is sparse"),
        (lambda t: t["accessors"][0].update(componentType=7), "is not glTF"),
        (lambda t: t["bufferViews"][0].update(byteLength=10**12), "a buffer view ends at byte"),
        (lambda t: t["bufferViews"][0].update(byteOffset=-4), "-4 is not a count"),
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
        (lambda t: t.update(nodes=[{"children": [2]}, {"children": [2]}, {"mesh": 0}]), "has two parents"),
        (lambda t: t.update(nodes=7), "is not glTF"),
    ],
)
def test_bad_glb_files(change: Callable[[dict[str, Any]], object], message: str) -> None:
    assert message in refused(glb_with(change), "a.glb")


def test_instances_count_as_often_as_they_are_placed() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=4)  # 5120 triangles
    scene = trimesh.Scene()
    scene.add_geometry(sphere, geom_name="s")
    for k in range(999):
        scene.add_geometry(sphere, geom_name="s", node_name=f"n{k}", transform=np.eye(4))
    content = scene.export(file_type="glb")
    count = json.loads(content[20 : 20 + struct.unpack_from("<I", content, 12)[0]])["nodes"]
    copies = sum("mesh" in node for node in count)
    message = refused(content, "a.glb")
    assert f"{copies * 5120} triangles; at most 5000000" in message


def test_accessors_that_share_bytes_are_summed() -> None:
    """1100 accessors over one megabyte unpack to more than a gigabyte, whatever the file's size."""
    accessor = {"bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 2**18}
    tree = {"buffers": [{}], "bufferViews": [{"byteLength": 2**20}], "accessors": [accessor] * 1100}
    with pytest.raises(SceneError, match="its accessors unpack to 1153433600 bytes"):
        check_gltf(tree, 2**20, "m")


# mesh: units and axes of mesh files, and what is told of defects.
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


# formats: which format a file has, and what is refused because of its name or content.
@pytest.mark.parametrize("kind", own_formats(), ids=lambda kind: kind.name)
def test_each_format_recognises_its_examples_and_reads_them(kind: Format[Triangles]) -> None:
    for content in kind.examples():
        assert detected_format(content) is kind
        assert format_of(content, f"A.{kind.name[:3].upper()}", "m") is kind
        vertices, faces = kind.parse(content, "m")
        assert vertices.shape[1:] == faces.shape[1:] == (3,) and 0 <= faces.min() < faces.max() < len(vertices)


def test_a_check_comes_before_the_parser_and_errors_of_a_parser_are_refusals(monkeypatch: pytest.MonkeyPatch) -> None:
    def parse(content: bytes, location: str) -> Triangles:
        return [][len(content)]

    def check(content: bytes, location: str) -> None:
        checked.append(location)

    checked: list[str] = []
    kind = Format[Triangles]("one", lambda content: content.startswith(b"one"), parse, lambda: (), check)
    join(monkeypatch, "readers", "one", kind)
    assert "is not readable as ONE (IndexError: list index out of range); export it again" in refused(b"one", "a.one")
    assert checked == ["body[0].mesh: a"]
    join(monkeypatch, "readers", "one", (replace(kind, check=parse),))
    assert "is not readable as ONE (IndexError" in refused(b"one", "a.one") and len(checked) == 1


@pytest.mark.parametrize(
    "content, words",
    [
        (b"\x89PNG\r\n\x1a\n", "PNG"), (b"PK\x03\x04", "ZIP"), (b"%PDF\nv 1 2 3\n", "PDF"), (b"\0\1", "binary data"),
        (b" {}", "JSON or XML"), (b"<a>\nv 1 2 3\n", "JSON or XML"), (b"vertex 1", "text of another kind"),
        (exported("ply"), "ply"), (exported("stl_ascii"), "stl_ascii"),
        (b"ply\nv 1 2 3\n", "ply"), (b"solid with a facet".ljust(80) + exported("stl")[80:], "stl"),
    ],
)  # fmt: skip
def test_content_that_is_not_what_the_ending_says_is_named(content: bytes, words: str) -> None:
    assert refused(content, "a.obj") == (
        f"body[0].mesh: a: the file is not OBJ as its ending says; it looks like {words}: rename it or export it again"
    )


@pytest.mark.parametrize(
    "name, content, message",
    [
        ("a.gltf", b"{}", ".gltf is not read; it keeps its data in other files: export it as .glb, which holds all"),
        ("a.zip", b"PK\x03\x04", ".zip is not read; it packs other files: unpack it"),
        ("my boat.x", b"xof 0303",
         ".x is not read; no reader of it is built in: assimp export 'my boat.x' 'my boat.obj' -tri"),
        ("b.3DS", b"MM", ".3ds is not read; no reader of it is built in: assimp export b.3DS b.obj -tri makes an .obj of it"),
        ("b.dae", b"<COLLADA/>", "assimp export b.dae b.obj -tri"),
        ("a.exe", b"MZ", 'the ending ".exe" is not one of .glb, .obj, .ply, .stl; '),
        ("noending", b"v 0 0 0", 'the ending ""'),
    ],
)  # fmt: skip
def test_names_without_a_format(name: str, content: bytes, message: str) -> None:
    assert message in refused(content, name)


# Faces that lie on one another, cut along other diagonals: which are found, which not, and that the rest reflects once.
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]  # of a box, seen from outside


def corners(length: float, width: float, height: float) -> Floats:
    """Of a box, (8, 3)."""
    return np.array([(x, y, z) for z in (0.0, height) for y in (0.0, width) for x in (0.0, length)])


def halves(quads: list[tuple[int, ...]], other: bool) -> Indices:
    """Two triangles of each quadrilateral, along one diagonal or the other."""
    cut = ((0, 1, 3), (1, 2, 3)) if other else ((0, 1, 2), (0, 2, 3))
    return np.array([[quad[i] for i in three] for quad in quads for three in cut])


def fans(points: Floats) -> tuple[Floats, Indices]:
    """Four triangles of each face of a box, about a vertex in its middle that is added to the points (8, 3)."""
    faces = [(a, b, 8 + k) for k, quad in enumerate(QUADS) for a, b in zip(quad, quad[1:] + quad[:1], strict=True)]
    return np.concatenate([points, points[np.array(QUADS)].mean(axis=1)]), np.array(faces)


def copies(points: Floats, faces: Indices) -> list[int]:
    return flat_copies(points, faces, numbered_edges(faces)).tolist()


BOX = corners(10.0, 4.0, 3.0)
ASPECTS = ([0.0, -1.0, 0.0], [0.2, -1.0, 0.1], [1.0, 0.5, 0.3])
PLAIN, OTHER = halves(QUADS, False), halves(QUADS, True)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("reversed_too", [False, True])
@pytest.mark.parametrize("kind", ["diagonals", "fans"])
def test_a_box_with_a_copy_cut_otherwise(kind: str, reversed_too: bool, turned: bool) -> None:
    """All of the copy and nothing else, wound either way, along the axes or turned, which rounds its planes."""
    points, copy = (BOX, OTHER) if kind == "diagonals" else fans(BOX)
    faces = np.concatenate([PLAIN, copy[:, ::-1] if reversed_too else copy])
    assert copies(points @ ODD.T if turned else points, faces) == list(range(12, len(faces)))


def test_a_sheet_drawn_on_both_sides() -> None:
    """Front and back of one quadrilateral, whose edges have two triangles each, folded back."""
    assert copies(BOX[:4] @ ODD.T, np.concatenate([halves(QUADS[:1], False), halves(QUADS[:1], True)[:, ::-1]])) == [2, 3]


def test_one_face_of_many() -> None:
    """A deck of 5 x 5 squares, of which one is there twice."""
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    index = np.arange(36).reshape(6, 6)
    quads = [tuple(q) for q in np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)]
    faces = np.concatenate([halves(quads, False), halves(quads[12:13], True)])
    assert copies(np.stack([x, y, 0.0 * x], axis=-1).reshape(-1, 3), faces) == [50, 51]


def test_a_bent_face_cut_otherwise_encloses_something() -> None:
    """Four corners of which one stands off the plane of the others: what lies between both cuts is as thick as that."""
    for off, expected in ((5e-4, [2, 3]), (4e-3, [])):
        points = BOX[[0, 2, 3, 1]] + [[0.0, 0.0, off], *np.zeros((3, 3))]
        quad = [(0, 1, 2, 3)]
        assert copies(points, np.concatenate([halves(quad, False), halves(quad, True)[:, ::-1]])) == expected


def test_a_pillow_is_no_copy_of_its_own_half() -> None:
    """Two caps of 0.3 x 0.3 m on one rim, bent so little that each is one piece, but 3.4 mm apart in the middle."""
    side = np.linspace(-1.0, 1.0, 25)
    x, y = np.meshgrid(side, side)
    inner = (np.abs(x) < 1.0) & (np.abs(y) < 1.0)
    upper = np.arange(625).reshape(25, 25)
    lower = np.where(inner, 625 + upper, upper)
    quads = [
        [(g[i, j], g[i, j + 1], g[i + 1, j + 1], g[i + 1, j]) for i in range(24) for j in range(24)] for g in (upper, lower)
    ]
    up = 1.7e-3 * (1.0 - x**2) * (1.0 - y**2)
    points = np.concatenate([np.stack([0.15 * x, 0.15 * y, z], axis=-1).reshape(-1, 3) for z in (up, -up)])
    assert copies(points, np.concatenate([halves(quads[0], False), halves(quads[1], True)[:, ::-1]])) == []


@pytest.mark.parametrize(
    ("points", "faces"),
    [
        (BOX, PLAIN),
        (sphere(1.0).vertices, sphere(1.0).faces),  # halves of it have one boundary
        (cylinder(0.3, 2.0).vertices, cylinder(0.3, 2.0).faces),
        (corners(10.0, 4.0, 0.01), PLAIN),  # a door 10 mm thick
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])),
        (np.concatenate([BOX, BOX + [10.0, 0.0, 0.0]]), np.concatenate([PLAIN, PLAIN + 8])),
        (BOX[[0, 1, 2, 3]], np.array([[0, 1, 2], [0, 1, 3]])),  # two that overlap, but with other boundaries
    ],
)  # fmt: skip
def test_what_is_no_copy(points: Floats, faces: Indices) -> None:
    assert copies(points, faces) == []


def test_a_box_with_a_copy_reflects_as_the_single_box(tmp_path: Path) -> None:
    """Before, 6.02 dB more; now the same to the rounding of phases of 8e5 rad, from three sides."""
    both = np.concatenate([PLAIN, OTHER[:, ::-1]])
    single, doubled = (
        [cross_section(optical(loaded(tmp_path, BOX[faces])), toward(aspect, 2000.0)) for aspect in ASPECTS]
        for faces in (PLAIN, both)
    )
    assert doubled == pytest.approx(single, rel=1e-8)


def test_the_finding_says_how_many() -> None:
    lines = [f"v {x} {y} {z}" for x, y, z in BOX.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.concatenate([PLAIN, OTHER[:, ::-1]]) + 1).tolist()]
    mesh, findings, *_ = mesh_from_bytes("\n".join(lines).encode(), "a.obj", "m")
    assert len(mesh.faces) == 12 and findings == ("12 triangles of faces dropped that repeat others, cut differently",)
