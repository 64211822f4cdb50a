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
        assert body.motion.at_rest and not body.motion.heading.any()


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


@pytest.mark.parametrize("heading", [0, 90, 180, 270, 37, -120, 360])
def test_the_bow_of_a_file_may_point_anywhere(heading: float, tmp_path: Path) -> None:
    """A marker at the bow, one to starboard and one at the file's origin come where the body has them, however it lies there."""
    t = np.deg2rad(heading)
    bow, starboard = 9.0 * np.array([np.sin(t), np.cos(t), 0.0]), 2.0 * np.array([np.cos(t), -np.sin(t), 0.0])
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in (bow, starboard, -starboard, [0.0, 0.0, 3.0])]
    (tmp_path / "m.obj").write_text("\n".join([*lines, "f 1 2 3", "f 1 2 4", "f 1 3 4", "f 2 3 4"]))
    place = {"name": "m", "mesh": "m.obj", "mesh_heading_deg": heading, "mesh_offset_m": [0.5, -4.0, -1.0]}
    (made,) = load_scene({"body": [place]}, folder=tmp_path).bodies
    assert made.mesh is not None
    expected = np.array([[0, 9, 0], [2, 0, 0], [-2, 0, 0], [0, 0, 3.0]]) + [0.5, -4.0, -1.0]
    np.testing.assert_allclose(made.mesh.vertices, expected, atol=1e-14)  # rounding of 9 m


def test_a_mesh_with_its_bow_at_z_sails_bow_first_and_has_its_middle_on_its_waterline(tmp_path: Path) -> None:
    """By its standard glTF has y up and the front at +z: the stern of a body. The file is 10 m long, its origin at the bow."""
    corners = [(x, y, z) for x in (-2.0, 2.0) for y in (0.0, 5.0) for z in (-10.0, 0.0)]
    faces = "f 1 2 4\nf 1 4 3\nf 5 8 6\nf 5 7 8\nf 1 5 6\nf 1 6 2\nf 3 4 8\nf 3 8 7\nf 1 3 7\nf 1 7 5\nf 2 6 8\nf 2 8 4\n"
    (tmp_path / "m.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + faces)
    ship = {"name": "m", "mesh": "m.obj", "up": "y", "mesh_heading_deg": 180, "position_m": [800, 0, 0],
            "course_deg": 30, "speed_kn": 6, "mesh_offset_m": [0, 5, -2]}  # fmt: skip
    (made,) = load_scene({"body": [ship]}, folder=tmp_path).bodies
    assert made.mesh is not None
    assert made.mesh.vertices.min(axis=0).tolist() == [-2, -5, -2] and made.mesh.vertices.max(axis=0).tolist() == [2, 5, 3]
    assert made.reference.tolist() == [0, 0, 0] and made.length == 10.0
    assert float(made.motion.pose(9.0).heading[0]) == pytest.approx(np.deg2rad(30), abs=1e-12)
