"""The short modules of scene_file, each under its name."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.scene_file.installations import at_location, located, reach
from radar_service.scene_file.key_paths import put
from radar_service.scene_file.load import load_scene
from radar_service.world.error import SceneError
from radar_service.world.motion import Motion
from radar_service.world.scene import Platform
from tests.scene_file.scene_sources import TETRAHEDRON, point, problems
from tests.scenes import point as placed_point
from tests.scenes import radar


# real: real meshes: open, doubled, of a thousand groups. They load, with a note that says what was result.
def counted(path: Path) -> tuple[int, list[float], list[float]]:
    """Faces, and the corners of the box round all vertices, of an OBJ file of triangles; read without the loader."""
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([[float(word) for word in line[1:4]] for line in lines if line[:1] == ["v"]])
    used = {int(word.split("/")[0]) - 1 for line in lines if line[:1] == ["f"] for word in line[1:]}
    vertices = vertices[sorted(used)]
    return sum(line[:1] == ["f"] for line in lines), vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()


def test_every_building_tile(real_folder: Path) -> None:
    folder = real_folder / "swinomish"
    tiles = sorted(folder.glob("*.obj"))
    assert len(tiles) == 19
    bodies = [{"name": tile.stem, "mesh": tile.name, "up": "y", "material": "building"} for tile in tiles]
    scene = load_scene({"body": bodies}, folder=folder)
    for tile, body in zip(tiles, scene.bodies, strict=True):
        faces, low, high = counted(tile)
        assert body.mesh is not None and len(body.mesh.faces) <= faces
        assert len(body.mesh.faces) > 0.99 * faces  # what is dropped has no area or stands there twice
        np.testing.assert_allclose(body.mesh.vertices.min(axis=0), [low[0], -high[2], low[1]], atol=1e-9)
        np.testing.assert_allclose(body.mesh.vertices.max(axis=0), [high[0], -low[2], high[1]], atol=1e-9)
    assert not scene.warnings and scene.notes[-1] == "19 meshes are not watertight: body[0].mesh, body[1].mesh and 17 more"
    assert not any("not watertight (" in note for note in scene.notes)


def test_the_light_buoy(real_folder: Path) -> None:
    scene = load_scene({"body": [{"name": "buoy", "mesh": "light_buoy.stl"}]}, folder=real_folder)
    mesh = scene.bodies[0].mesh
    assert mesh is not None and len(mesh.faces) == 8722  # as its provenance says
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([1.6, 1.6, 2.1], abs=0.05)  # m: printed digits
    assert scene.notes == (
        "body[0].mesh: light_buoy.stl: not watertight (416 open edges), 32 edges shared by more than two triangles",
    )


# folder: files of a scene stay inside its folder.
@pytest.mark.parametrize(
    "name, message",
    [
        ("missing.obj", '"missing.obj" is not a file in'),
        ("../outside.obj", "leaves the scene's folder"),
        ("/etc/passwd", "leaves the scene's folder"),
        ("sub/../../outside.obj", "leaves the scene's folder"),
        ("link.obj", "is a link out of"),
        ("linked/outside.obj", "is a link out of"),
        ("sub", "is a folder"),
        ("C:\\ferry.obj",
         '"C:\\\\ferry.obj" has a backslash, or what an escape makes of one; write paths with forward slashes'),
        ("meshes\ferry.obj", '"meshes\\x0cerry.obj" has a backslash, or what an escape makes of one; write'),
        ("file:ferry.obj", "leaves the scene's folder"),
        ("a\0b.obj", "cannot be looked up"),
        ("x" * 400, "cannot be looked up"),
        ("loop.obj", "cannot be looked up"),
    ],
)  # fmt: skip
def test_files_stay_in_the_folder(folder: Path, name: str, message: str) -> None:
    (folder.parent / "outside.obj").write_text(TETRAHEDRON)
    (folder / "sub").mkdir()
    (folder / "link.obj").symlink_to(folder.parent / "outside.obj")
    (folder / "linked").symlink_to(folder.parent)
    (folder / "loop.obj").symlink_to(folder / "loop.obj")
    (result,) = problems({"body": [{"name": "a", "mesh": name}]}, folder=folder)
    assert result.startswith("body[0].mesh: ") and message in result
    (result,) = problems({"body": [{"name": "a", "heightmap": name}]}, folder=folder)
    assert result.startswith("body[0].heightmap: ") and message in result
    (result,) = problems({"body": [point(track=name)]}, folder=folder)
    assert result.startswith("body[0].track: ") and message in result


def test_links_and_folders_inside_the_folder_are_fine(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "other.obj").symlink_to(folder / "ferry.obj")
    scene = load_scene({"body": [{"name": "a", "mesh": "sub/other.obj"}]}, folder=folder)
    assert scene.bodies[0].mesh is not None


# key_paths: keys with dots: where they put a value, and what they refuse.
def content() -> dict[str, Any]:
    return {
        "name": "a",
        "radar": [{"id": "bow", "rpm": 24}, {"id": "pier", "rpm": 24}],
        "body": [{"name": "ferry", "position_m": [0, 900, 0]}, {"name": "buoy 1", "track": [[0, 1], [2, 3]]}],
    }


@pytest.mark.parametrize(
    ("key", "found"),
    [
        ("name", lambda c: c["name"]),
        ("environment.sea_state", lambda c: c["environment"]["sea_state"]),
        ("errors.gyro.bias_deg", lambda c: c["errors"]["gyro"]["bias_deg"]),
        ("body.ferry.speed_kn", lambda c: c["body"][0]["speed_kn"]),
        ("body.buoy 1.rcs_dbsm", lambda c: c["body"][1]["rcs_dbsm"]),
        ("radar.pier.rpm", lambda c: c["radar"][1]["rpm"]),
        ("body.ferry.position_m.1", lambda c: c["body"][0]["position_m"][1]),
        ("body.buoy 1.track.1.0", lambda c: c["body"][1]["track"][1][0]),
    ],
)
def test_a_value_goes_where_the_key_says_and_nowhere_else(key: str, found: Any) -> None:
    changed, other = content(), content()
    put(changed, key, 7, "here")
    put(other, key, 8, "here")
    assert (found(changed), found(other)) == (7, 8)
    put(changed, key, 8, "here")
    assert changed == other


def test_a_star_is_each_table_of_a_list() -> None:
    changed = content()
    put(changed, "radar.*.rpm", 48, "here")
    put(changed, "body.*.position_m", [1, 2, 3], "here")
    assert [radar["rpm"] for radar in changed["radar"]] == [48, 48]
    assert [body["position_m"] for body in changed["body"]] == [[1, 2, 3]] * 2


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("body.tug.speed_kn", r"^here: there is no 'tug'; there are ferry, buoy 1, or write \* for each$"),
        ("body.speed_kn", r"^here: 'speed_kn' is a key of each table of a list; write the name of one, or \*, before it$"),
        ("name.first", "^here: 'name' is no table; correct the key$"),
        ("body.ferry.position_m.3", "^here: '3' is no number of a list of 3 values; give 0 to 2$"),
        ("body.ferry.position_m.east", "^here: 'east' is no number of a list of 3 values; give 0 to 2$"),
        ("body.ferry.position_m.1.x", "^here: '1' is no table; correct the key$"),
    ],
)
def test_a_key_that_leads_nowhere_is_named(key: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        put(content(), key, 7, "here")


# installations: where several radars reach, and sentences about one of them.
AT_PISA: dict[str, Any] = {"latitude_deg": 43.7, "longitude_deg": 10.4}


def platform(*positions: tuple[float, float], speed: float = 0.0) -> Platform:
    knots = np.array([[*position, 0.0] for position in positions])
    time = np.arange(len(knots), dtype=np.float64)
    return Platform(Motion(time, knots, np.zeros(len(knots)), np.array([speed, 0.0, 0.0])))


def test_the_circle_encloses_what_each_radar_reaches() -> None:
    """The second stands 5 km from the first and travels 1 km: 5 + 2 + 1."""
    near, far = radar(range_max_m=1000), radar(range_max_m=2000)
    both = reach([near, far], [platform((0, 0)), platform((3000, 4000), (3000, 5000))])
    assert tuple(both) == (0.0, 0.0, 8000.0)
    assert tuple(reach([near], [platform((7, 8))])) == (7.0, 8.0, 1000.0)
    assert tuple(reach([near], [None])) == (0.0, 0.0, 1000.0)  # one that could not be read
    assert reach([near, far], [platform((0, 0)), platform((0, 0), speed=1.0)]).radius == math.inf


def test_a_sentence_names_the_radar_that_it_is_about() -> None:
    assert located("radar.pulse_s: too long", "radar[2]") == "radar[2].pulse_s: too long"
    assert located("radar.pulse_s: too long", "radar") == "radar.pulse_s: too long"
    assert located("body[0]: below the sea", "radar[2]") == "body[0]: below the sea"
    with pytest.raises(SceneError) as refused, at_location("radar[1]"):
        raise SceneError("radar.rpm: no", "body: no")
    assert refused.value.problems == ("radar[1].rpm: no", "body: no")


def test_warnings_name_the_platform_and_come_once() -> None:
    site = {"platform": {"position_m": [300_000, 0]}}
    made = load_scene(
        {
            "origin": AT_PISA,
            "radar": [{"id": "a", **site}, {"id": "b", "pulse_s": 1e-6, "bandwidth_hz": 5e6, "sample_rate_hz": 5e6}],
            "body": [placed_point("deep", 0, 50, -9.0)],
        }
    )
    far, deep, folding = made.warnings
    assert far.startswith("radar[0].platform: at 300 km from the origin the map is stretched by")
    assert folding.startswith("radar[1].sample_rate_hz: with bandwidth x pulse 5")
    assert deep.startswith("body[0]: deep is entirely below the sea")
    assert made.for_radar("b").warnings == made.warnings
