"""The short modules of scene_file/readers, each under its name."""

import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh

from radar_service.scene_file.model.body import HeightMapBodyModel
from radar_service.scene_file.readers.file_format import MAX_FACES, check_face_count, check_range, refusals
from radar_service.scene_file.readers.glb import check_gltf
from radar_service.scene_file.readers.heightmap import Coverage, HeightMapFile
from radar_service.scene_file.readers.mesh import MeshFile
from radar_service.scene_file.readers.mesh_reader import IN_PROCESS
from radar_service.scene_file.readers.track import motion_from_track
from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles
from radar_service.world.error import SceneError
from tests.scene_file.readers.height_maps import npy
from tests.scene_file.readers.mesh_files import chain, exported, glb_with, mesh_from_bytes, refused, stl_claiming


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
@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "ply", "glb"])
def test_a_box_has_its_size(kind: str) -> None:
    vertices, faces = trimesh_triangles(kind, exported_box(kind), "m")
    assert len(faces) == 12
    np.testing.assert_allclose(np.ptp(vertices, axis=0), 1.0, rtol=1e-7)  # float32 of STL


def test_points_are_no_triangles() -> None:
    cloud = trimesh.PointCloud(np.eye(3)).export(file_type="ply")
    assert [array.shape for array in trimesh_triangles("ply", cloud, "m")] == [(0, 3), (0, 3)]


def test_what_it_cannot_read_is_a_refusal() -> None:
    with pytest.raises(SceneError, match=r"^m: the file is not readable as GLB \(.+\); export it again$"):
        trimesh_triangles("glb", b"glTF", "m")


# mesh_reader: the reader in this process: what the parsers of meshes and height maps return, at the location of the body.
EVERYWHERE = Coverage(0.0, 0.0, np.inf)
BODY = HeightMapBodyModel(name="land", heightmap="h.npy", extent_m=(20.0, 10.0))


def test_a_mesh_is_that_of_the_parser() -> None:
    content = exported("obj")
    (read,) = IN_PROCESS.read(MeshFile(content, "a.obj", "m", 2.0, "y"))
    parsed = mesh_from_bytes(content, "a.obj", "m", 2.0, "y")
    np.testing.assert_array_equal(read.mesh.vertices, parsed.mesh.vertices)
    np.testing.assert_array_equal(read.mesh.faces, parsed.mesh.faces)


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
        (b"v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n", "1 vertices are not finite"),
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
