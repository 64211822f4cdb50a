"""Bodies of a scene: what those of each kind become."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.scene_file.load import load_scene
from tests.scene_file.readers.height_maps import npy
from tests.scene_file.scene_sources import TETRAHEDRON, point, problems


def test_each_kind_has_its_surface_and_its_place(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(TETRAHEDRON)
    (tmp_path / "h.npy").write_bytes(npy(np.full((2, 2), 7.0)))
    place = {"position_m": [100, 200, 3]}
    tables = [
        point("p", **place), {"name": "s", "shape": "hull", "length_m": 9, "beam_m": 3, "height_m": 2, **place},
        {"name": "m", "mesh": "m.obj", **place}, {"name": "w", "mesh": "m.obj", "material": "concrete", **place},
        {"name": "h", "heightmap": "h.npy", "extent_m": [20, 10], **place},
    ]  # fmt: skip
    bodies = load_scene({"body": tables}, folder=tmp_path).bodies
    assert [0 if body.mesh is None else len(body.mesh.faces) for body in bodies[2:]] == [4, 4, 2 + 2 * 4]
    assert bodies[0].mesh is None and bodies[1].mesh is not None
    assert [body.is_vessel for body in bodies] == [False, True, True, False, False]
    assert [body.one_sided for body in bodies] == [False, False, False, False, True]
    for body in bodies:
        np.testing.assert_allclose(body.motion.position, [[100, 200, 3]], rtol=1e-15)  # of the mean of four corners


def test_equal_shapes_share_a_mesh_and_files_with_other_scales_do_not(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(TETRAHEDRON)
    balls = [{"name": f"s{r}{k}", "shape": "sphere", "radius_m": r, "rcs_dbsm": 0} for r in (1, 2) for k in (0, 1)]
    one, same, two, _ = load_scene({"body": balls}).bodies
    assert one.mesh is same.mesh and one.mesh is not two.mesh
    files = [{"name": f"m{k}", "mesh": "m.obj", **keys} for k, keys in enumerate(({}, {"scale": 2.0}, {"up": "y"}, {}))]
    plain, large, turned, again = load_scene({"body": files}, folder=tmp_path).bodies
    assert plain.mesh is again.mesh and len({id(body.mesh) for body in (plain, large, turned)}) == 3
    assert large.mesh is not None and large.mesh.vertices.max() == 2.0
    assert turned.mesh is not None and turned.mesh.vertices.min() == -1.0


@pytest.mark.parametrize("key", ["mesh", "heightmap"])
def test_a_file_that_is_not_there_is_told_for_each_body(key: str, tmp_path: Path) -> None:
    tables = [{"name": f"b{k}", key: f"gone.{key}"} for k in range(2)]
    lines = problems({"body": tables}, folder=tmp_path)
    assert [line.split(":")[0] for line in lines][0] == f"body[0].{key}"
