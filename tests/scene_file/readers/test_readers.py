"""The short modules of scene_file/readers, each under its name."""

import struct

import numpy as np
import pytest
import trimesh

from radar_service.scene_file.readers.file_format import MAX_FACES, check_face_count, check_range, refusals
from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles
from radar_service.world.error import SceneError
from tests.scene_file.readers.mesh_files import exported, refused, stl_claiming


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
        (
            "a.ply",
            exported("ply").replace(b"element face 12", b"element face 9999999"),
            "9999999 triangles; at most 5000000",
        ),
        ("a.ply", exported("ply").replace(b"element vertex 8", b"element vertex 99999999"), "declares at least"),
        ("a.ply", exported("ply").replace(b"property float x", b"property quad x"), "unknown"),
        ("a.ply", exported("ply").replace(b"end_header", b"fin_header"), "does not end"),
        ("a.ply", exported("ply")[:-30], "body[0]"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", "no triangles"),
    ],
)
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
