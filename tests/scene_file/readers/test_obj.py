"""OBJ files: polygons, negative numbers, continued lines, bad lines."""

import numpy as np
import pytest

from tests.scene_file.readers.mesh_files import exported, mesh_from_bytes, refused


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
