"""PLY files whose header declares what cannot be true are refused."""

import pytest

from tests.scene_file.readers.mesh_files import exported, refused


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
