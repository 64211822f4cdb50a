"""trimesh as a parser: what it cannot read is a refusal, and files without surfaces have no triangles."""

import numpy as np
import pytest
import trimesh

from radar_service.scene_file.readers.trimesh_parser import exported_box, trimesh_triangles
from radar_service.world.error import SceneError


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
