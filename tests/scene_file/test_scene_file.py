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
from radar_service.world.reporting import Ais, AisSettings, AisShip
from radar_service.world.scene import Platform
from tests.scene_file.readers.height_maps import npy
from tests.scene_file.scene_sources import TETRAHEDRON, point, problems
from tests.scenes import point as placed_point
from tests.scenes import radar


# real: real meshes: open, doubled, of a thousand groups. They load, with a note that says what was result.
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
    return {"name": "a", "radar": [{"id": "bow", "rpm": 24}, {"id": "pier", "rpm": 24}],
            "body": [{"name": "ferry", "position_m": [0, 900, 0]}, {"name": "buoy 1", "track": [[0, 1], [2, 3]]}]}  # fmt: skip


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


# transponders: AIS of bodies and of own ship.
SHIP = {"name": "a b", "shape": "hull", "length_m": 80.0, "beam_m": 12.0, "height_m": 9.0, "position_m": [900, 0, -3],
        "mmsi": 7}  # fmt: skip


def ship(**keys: Any) -> AisShip:
    (made,) = load_scene({"body": [{**SHIP, **keys}]}).ais.ships
    return made


def test_a_number_makes_a_transponder_with_the_body_as_it_is() -> None:
    made = ship()
    assert (made.body, made.mmsi, made.station_class, made.name, made.draught) == ("a b", 7, "A", "A B", 3.0)
    assert (made.to_bow, made.to_stern, made.to_port, made.to_starboard) == (40.0, 40.0, 6.0, 6.0)
    assert load_scene({"body": [point("p")]}).ais == Ais()


def test_keys_say_more() -> None:
    made = ship(
        ais={"class": "B-SO", "name": "x", "antenna_m": [2, -10], "off_s": [[1, 2.5]], "heading_error_deg": 180},
        draught_m=4.5,
    )
    assert (made.station_class, made.name, made.draught, made.heading_error) == ("B-SO", "X", 4.5, math.pi)
    assert (made.to_bow, made.to_stern, made.to_port, made.to_starboard) == (50.0, 30.0, 8.0, 4.0)
    assert made.antenna == (2.0, -10.0)
    assert made.silent == ((1.0, 2.5),)


def test_a_kind_is_a_ship_unless_it_is_told() -> None:
    assert (ship().kind, ship().aid_type) == ("ship", 0)
    made = ship(ais={"kind": "aid", "aid_type": 24})
    assert (made.kind, made.aid_type, ship(ais={"kind": "sart"}).kind) == ("aid", 24, "sart")


@pytest.mark.parametrize(
    ("mmsi", "kind", "words"),
    [
        (235000001, "ship", ()), (775999999, "ship", ()), (992350001, "aid", ()), (970010001, "sart", ()),
        (2350000, "ship", ("body[1].mmsi: 002350000 is not the number of a ship", "; give one like 235000001")),
        (970010001, "ship", ("970010001 is not the number of a ship", 'set ais.kind = "sart", or give one like 235000001')),
        (992350001, "ship", ('set ais.kind = "aid", or give',)), (111235001, "ship", ("111235001",)),
        (235000001, "aid", ("an aid to navigation", '"ship"')), (982350001, "ship", ("a ship",)),
        (999000001, "ship", ("999000001",)), (974010001, "sart", ("a SART", "; give one like 970010001")),
    ],
)  # fmt: skip
def test_a_number_of_another_kind_is_warned_of(mmsi: int, kind: str, words: tuple[str, ...]) -> None:
    scene = load_scene({"body": [point("p", position_m=[50, 0, 0]), {**SHIP, "mmsi": mmsi, "ais": {"kind": kind}}]})
    told = [warning for warning in scene.warnings if "is not the number of" in warning]
    assert len(told) == bool(words) and all(word in told[0] for word in words)


def test_own_ship_is_warned_of_and_shipped_scenes_are_not() -> None:
    """Their numbers have the country code 299, which belongs to nobody, so that no ship is taken for one that exists."""
    (warning,) = load_scene({"own_ship": {"mmsi": 9}}).warnings
    assert warning.startswith("own_ship.mmsi: 000000009 is not the number of a ship")
    numbers = [made.mmsi for name in ("harbour", "open-sea") for made in load_scene(name).ais.ships]
    assert len(numbers) == 12 and {number // 10**6 for number in numbers} == {299}
    assert not [warning for name in ("harbour", "open-sea") for warning in load_scene(name).warnings if "mmsi" in warning]


def test_own_ship_and_the_settings() -> None:
    scene = load_scene({"own_ship": {"mmsi": 9, "ais": {"length_m": 30, "beam_m": 8}, "draught_m": 2}, "body": [SHIP],
                        "ais": {"latency_s": 2, "loss_percent": 25, "position_error_m": 12}})  # fmt: skip
    assert [made.mmsi for made in scene.ais.ships] == [9, 7] and scene.ais.ships[0].body is None
    assert (scene.ais.ships[0].to_bow, scene.ais.ships[0].draught) == (15.0, 2.0)
    assert scene.ais.settings == AisSettings(2.0, 0.25, 12.0)


# bodies: each kind, shared meshes, and how a file lies on its body.
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
