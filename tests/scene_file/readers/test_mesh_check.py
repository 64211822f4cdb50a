"""Mesh files whose header or format is wrong are refused before they are parsed."""

import struct

import pytest

from tests.scene_file.readers.mesh_files import exported, refused, stl_claiming


@pytest.mark.parametrize(
    "name, content, message",
    [
        ("a.stl", stl_claiming(4_000_000_000), "is not STL"),
        ("a.stl", stl_claiming(11), "cut short or padded (684 bytes, not 634)"),
        ("a.stl", exported("stl")[:-20], "cut short or padded (664 bytes, not 684)"),
        ("a.stl", b"\0" * 84, "no triangles"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nendsolid a\n", "body[0]"),
        ("a.stl", struct.pack("<80xI", 1) + struct.pack("<12f2x", *[float("nan")] * 12), "not finite"),
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
        ("a.gltf", b"{}", ".gltf is not supported"),
        ("a.zip", b"PK\x03\x04", ".zip is not supported"),
        ("a.exe", b"MZ", 'the ending ".exe"'),
        ("noending", b"v 0 0 0", 'the ending ""'),
    ],
)
def test_bad_stl_and_ply_files(name: str, content: bytes, message: str) -> None:
    assert message in refused(content, name)


def test_glb_lengths() -> None:
    content = exported("glb")
    assert "a chunk declares 4294967295 bytes" in refused(content[:12] + b"\xff\xff\xff\xff" + content[16:], "a.glb")
    assert "not that of GLB version 2" in refused(content[:-4], "a.glb")
    assert "not that of GLB version 2" in refused(b"glTF" + struct.pack("<II", 2, 12), "a.glb")
    deep = b"[" * 100_000
    head = b"glTF" + struct.pack("<II", 2, 20 + len(deep)) + struct.pack("<I4s", len(deep), b"JSON")
    assert "the JSON is invalid" in refused(head + deep, "a.glb")
