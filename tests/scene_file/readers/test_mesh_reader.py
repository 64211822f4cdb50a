"""The reader in this process: what the parsers of meshes and height maps return, at the location of the body."""

import numpy as np
import pytest

from radar_service.scene_file.model.body import HeightMapBodyModel
from radar_service.scene_file.readers.heightmap import Coverage, HeightMapFile
from radar_service.scene_file.readers.mesh import MeshFile
from radar_service.scene_file.readers.mesh_reader import IN_PROCESS
from radar_service.world.error import SceneError
from tests.scene_file.readers.height_maps import npy
from tests.scene_file.readers.mesh_files import exported, mesh_from_bytes

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
