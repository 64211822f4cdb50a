"""STL files whose size is not the one they declare, or without triangles, are refused."""

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
    ],
)
def test_bad_stl_files(name: str, content: bytes, message: str) -> None:
    assert message in refused(content, name)
