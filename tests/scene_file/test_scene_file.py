"""The short modules of scene_file, each under its name."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from radar_service.numerics.constants import KNOT
from radar_service.scene_file.installations import at_location, located, reach
from radar_service.scene_file.key_paths import put
from radar_service.scene_file.load import load_scene, model_from, scene_from_model
from radar_service.scene_file.model.scene import scene_model
from radar_service.world.error import SceneError
from radar_service.world.motion import Motion
from radar_service.world.reporting import Ais, AisSettings, AisShip
from radar_service.world.scene import Platform
from tests.scene_file.readers.height_maps import npy
from tests.scene_file.scene_sources import EXAMPLE, TETRAHEDRON, point, problems
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


# load: the example of docs/scenes.md, shared files, units, several problems at once, arbitrary input.
def test_the_example_of_the_design(folder: Path) -> None:
    scene = load_scene(folder / "scene.toml")
    assert (scene.name, scene.origin) == ("two targets", (50.9, 1.4))
    radar = scene.radar
    assert radar.range_step == pytest.approx(1.9986, abs=5e-5)  # docs/conventions.md#range
    assert radar.bins == math.ceil(5000 / (299_792_458 / 150e6)) == 2502
    assert (radar.gain, radar.loss, radar.rotation_period) == (1000.0, 1.0, 2.5)
    assert radar.beamwidth == pytest.approx(math.radians(3.9))
    assert radar.noise_factor == pytest.approx(2.5119, abs=5e-5)  # 4 dB
    assert scene.environment.earth_factor == pytest.approx(4 / 3)
    reflector, ferry, island = scene.bodies
    assert (reflector.mesh, reflector.scattering, reflector.rcs) == (None, "rcs", pytest.approx(10.0))
    np.testing.assert_array_equal(reflector.motion.position, [[500, 866, 4]])
    assert (ferry.scattering, ferry.mmsi, ferry.material.name, ferry.length, ferry.beam) == (
        "optics",
        235000001,
        "steel",
        1,
        1,
    )
    np.testing.assert_allclose(ferry.motion.pose(1.0).velocity, [[12 * KNOT, 0, 0]], atol=1e-12)
    assert island.scattering == "diffuse" and island.motion.at_rest
    assert [w.split(",")[0] for w in scene.warnings] == [
        "body[0]: reflector is under the ground of island",
        "body[1]: ferry is under the ground of island",
        "body[2]: the antenna is inside or under island",
    ]


def test_json_mapping_and_model_agree(folder: Path) -> None:
    import tomllib

    data = tomllib.loads(EXAMPLE)
    (folder / "scene.json").write_text(json.dumps(data))
    expected = repr(load_scene(folder / "scene.toml"))
    assert repr(load_scene(str(folder / "scene.json"))) == expected
    assert repr(load_scene(data, folder=folder)) == expected
    assert repr(scene_from_model(model_from(folder / "scene.toml"), folder)) == expected
    as_numpy = {**data, "body": [{**data["body"][0], "position_m": np.array([500.0, 866.0, 4.0])}]}
    assert load_scene(as_numpy).bodies[0].motion.position[0, 1] == np.float64(866)


def test_bodies_by_latitude_and_longitude() -> None:
    body = point(latitude_deg=50.9, longitude_deg=1.5, up_m=7)
    location = (
        load_scene({"origin": {"latitude_deg": 50.9, "longitude_deg": 1.4}, "body": [body]}).bodies[0].motion.position[0]
    )
    assert location[0] == pytest.approx(7034.85, abs=0.02)  # m: pi/1800 x N cos(latitude) on WGS 84, and its last digit
    assert location[2] == 7.0


def test_several_problems_come_together(folder: Path) -> None:
    bodies = [{"name": f"b{k}", "mesh": f"missing{k}.obj"} for k in range(25)]
    result = problems({"body": bodies}, folder=folder)
    assert len(result) == 21 and result[0].startswith("body[0].mesh") and result[20] == "... and 5 more problems"
    both = problems({"radar": {"rpm": 0}, "body": [point(swerling=9)]})
    assert [line.split(":")[0] for line in both] == ["radar.rpm", "body[0].swerling"]


def test_too_many_triangles_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.scene_file.readers.file_format.InProcessReader.max_triangles", 700)
    bodies = [{"name": f"s{k}", "shape": "sphere", "radius_m": 0.1, "rcs_dbsm": 0} for k in range(3)]
    assert problems({"body": bodies})[0].startswith("body[2]: the body brings the scene to 960 triangles; at most 700")


SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["point", "sphere", "a.obj"])
)

KEYS = st.sampled_from(
    [*scene_model().model_fields, "rpm", "shape", "position_m", "waypoints", "pattern", "name", "track", "x"]
)

ARBITRARY = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS | st.integers(), inner, max_size=5),
    max_leaves=12,
)


@settings(max_examples=80, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(KEYS, ARBITRARY, max_size=5))
def test_arbitrary_data_raises_only_scene_errors(source: dict[str, Any]) -> None:
    try:
        load_scene(source)
    except SceneError as fault:
        assert fault.problems and all(fault.problems)


def test_far_from_the_origin_a_warning_gives_the_distortion() -> None:
    """c / sin c - 1 at 1000 km: 0.1570 rad, 0.41 %; at 100 km nothing is message."""
    scene = {"origin": {"latitude_deg": 50, "longitude_deg": 0}, "own_ship": {"position_m": [1e6, 0]}}
    (warning,) = load_scene(scene).warnings
    assert warning.startswith("own_ship: at 1000 km from the origin") and "0.41%" in warning
    assert not load_scene(scene | {"own_ship": {"position_m": [1e5, 0]}}).warnings


# validation_messages: key path, value, allowed range, remedy.
CORNERS = {"name": "h", "heightmap": "h.npy", "south_west_deg": [1, 1], "north_east_deg": [2, 2]}

# The form of every message: place, value, what is allowed, remedy.
ONE_PROBLEM: list[tuple[dict[str, Any], str]] = [
    ({"body": [point("a"), point("b"), point("c"), point("d", position_m=[0, math.nan, 0])]},
     "body[3].position_m[1]: nan is not allowed; a finite number from -2000000 to 2000000; give a finite number"),
    ({"body": [point(position_m=[0, 0, math.inf])]},
     "body[0].position_m[2]: inf is not allowed; a finite number from -11000"),
    ({"body": [point(position_m=[0, 0, -math.inf])]}, "body[0].position_m[2]: -inf is not allowed"),
    ({"body": [point(position_m=[0, 0])]}, "body[0].position_m[2]: missing; a finite number from -11000 to 20000; add it"),
    ({"body": [point(position_m=[0, 0, 0, 0])]}, "body[0].position_m: [0, 0, 0, 0] is not allowed; a list of 3 values"),
    ({"body": [point(position_m="here")]}, 'body[0].position_m: "here" is not allowed; a list of 3 values'),
    ({"body": [point(positon_m=[0, 0, 0])]},
     'body[0].positon_m: this is not a known key; did you mean "position_m"? (nearest of 67 keys: position_m, '),
    (
        {"zzz": 1},
        "zzz: this is not a known key; remove it, or install the package of the effect that has it (nearest of 10 keys: "
        "radar, own_ship, origin)",
    ),
    ({"radar": {"azimuths": 10**9}}, "radar.azimuths: 1000000000 is not allowed; a whole number from 4 to 16384; lower it"),
    ({"radar": {"azimuths": 10**400}}, "radar.azimuths: an integer of 1329 bits is not allowed; a whole number from 4"),
    ({"radar": {"azimuths": 720.5}}, "radar.azimuths: 720.5 is not allowed; a whole number"),
    ({"radar": {"azimuths": True}}, "radar.azimuths: true is not allowed; a whole number"),
    ({"radar": {"rpm": "24"}},
     'radar.rpm: "24" is not allowed; a finite number from 0.01 to 600; write the number without quotes'),
    ({"radar": {"rpm": -1}}, "radar.rpm: -1 is not allowed; a finite number from 0.01 to 600; raise it"),
    ({"radar": {"window": "hat"}}, 'radar.window: "hat" is not allowed; one of "none", "hamming"'),
    ({"radar": {"pattern": "x"}}, 'radar.pattern: "x" is not allowed; one of "sinc2"'),
    ({"radar": {"pattern": [[0, 0], [1, math.nan]]}}, "radar.pattern[1][1]: nan is not allowed; a finite number"),
    ({"radar": {"pattern": [[0, 0]]}}, "radar.pattern: a table has 2 to 10000 rows"),
    ({"radar": {"pattern": [[0, 0], [1, 1]]}}, "radar.pattern: gains are in dB below boresight"),
    ({"radar": {"labels_within_db": 0}},
     'radar.labels_within_db: 0 is not allowed; one of "none" or a finite number above 0 up to 200; raise it'),
    ({"radar": {"eclipsing": 1}}, "radar.eclipsing: 1 is not allowed; true or false"),
    ({"radar": {"range_max_m": 200_000}}, "radar.range_max_m: 200000 m at 7.5e+07 samples/s gives 100070 range bins"),
    ({"radar": {"azimuths": 16384, "range_max_m": 100_000}}, "radar.azimuths: 16384 x 50035 range bins are 819773440 cells"),
    ({"radar": {"pulse_s": 1e-3, "sample_rate_hz": 4e9}}, "radar.range_max_m"),
    ({"radar": {"pulse_s": 1e-3, "bandwidth_hz": 2e9, "range_max_m": 1000}}, "radar.pulse_s: 0.001 s at 3e+09 samples/s"),
    ({"radar": 5}, "radar: 5 is not allowed; a table with the keys modulation"),
    ({"environment": {"earth": -1}}, 'environment.earth: -1 is not allowed; one of "4/3", "flat" or a finite number above 0'),
    ({"environment": {"earth": "round"}}, 'environment.earth: "round" is not allowed; one of "4/3", "flat" or a finite'),
    ({"environment": {"gas_db_per_km": math.nan}}, 'environment.gas_db_per_km: nan is not allowed; one of "itu" or a finite'),
    ({"environment": {"gas_db_per_km": "itu"}, "radar": {"frequency_hz": 60e9}}, 'environment.gas_db_per_km: "itu" covers'),
    ({"environment": {"sea_state": 10}}, "environment.sea_state: 10 is not allowed; a finite number from 0 to 9; lower it"),
    ({"body": {}}, "body: a table of 0 keys is not allowed; a list of at most 10000 values"),
    ({"body": [5]}, "body[0]: 5 is not allowed; a table with the keys"),
    ({"body": [point(), point()]}, 'body[1].name: "p" is taken by an earlier body; names are unique'),
    ({"body": [{"shape": "point", "rcs_dbsm": 1}]}, "body[0].name: missing; text of 1 to 200 characters; add it"),
    ({"body": [point("")]}, 'body[0].name: "" is not allowed; text of 1 to 200 characters; lengthen it'),
    ({"body": [{"name": "a", "shape": "point"}]},
     "body[0].rcs_dbsm: a point has no surface; declare its radar cross-section"),
    ({"body": [{"name": "a", "shape": "sphere"}]}, 'body[0].radius_m: missing; shape = "sphere" needs radius_m: add it'),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": -1}]},
     "body[0].radius_m: -1 is not allowed; a finite number above 0 up"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 0}]},
     "body[0].radius_m: 0 is not allowed; a finite number above 0"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1e9}]}, "body[0].radius_m: 1000000000 is not allowed"),
    ({"body": [point(radius_m=1)]}, 'body[0].radius_m: shape = "point" takes no sizes; remove radius_m'),
    ({"body": [point(material="cheese")]}, 'body[0].material: "cheese" is not a known material; one of steel, aluminium'),
    ({"body": [point(scattering="optics")]}, 'body[0].rcs_dbsm: a declared cross-section excludes scattering = "optics"'),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1, "swerling": 1}]}, "body[0].swerling: fluctuation is defined"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1, "scattering": "rcs"}]}, "body[0].rcs_dbsm: scattering"),
    ({"body": [point(latitude_deg=1.0)]}, "body[0].latitude_deg: this key needs latitude_deg and longitude_deg together"),
    ({"body": [point(latitude_deg=1.0, longitude_deg=1.0)]}, "body[0].latitude_deg: latitude and longitude need an [origin]"),
    ({"body": [point(latitude_deg=1.0, longitude_deg=1.0, position_m=[0, 0, 0])]}, "body[0].position_m: latitude_deg and"),
    ({"body": [point(latitude_deg=91.0, longitude_deg=1.0)]},
     "body[0].latitude_deg: 91 is not allowed; a finite number from -90"),
    ({"body": [point(up_m=1.0)]}, "body[0].up_m: this key needs latitude_deg"),
    ({"body": [point(course_deg=1, waypoints=[{"position_m": [1, 1], "speed_kn": 1}])]},
     "body[0].course_deg: waypoints already"),
    ({"body": [point(position_m=[0, 0, 0], track="t.csv")]}, "body[0].position_m: the track already defines the position"),
    ({"body": [point(waypoints=[{"position_m": [1, 1], "speed_kn": 0}])]}, "body[0].waypoints[0].speed_kn: 0 is not allowed"),
    ({"body": [point(waypoints=[{"position_m": [1, 1]}])]},
     "body[0].waypoints[0].speed_kn: missing; a finite number above 0"),
    ({"body": [{"name": "h", "heightmap": "h.png", "low_m": 5, "high_m": 5}]}, "body[0].high_m: 5 is not above low_m 5"),
    ({"body": [CORNERS | {"extent_m": [9, 9]}]},
     "body[0].extent_m: the corners south_west_deg and north_east_deg define it too"),
    ({"body": [CORNERS | {"north_east_deg": None}]}, "body[0].south_west_deg: this key needs north_east_deg"),
    ({"body": [CORNERS | {"position_m": [5, 0, 0]}]}, "body[0].south_west_deg: the corners already define the position"),
    ({"body": [CORNERS]}, "body[0].latitude_deg: latitude and longitude need an [origin]"),
    ({"own_ship": {"speed": 3}}, 'own_ship.speed: this is not a known key; did you mean "speed_kn"?'),
    ({"own_ship": {"track": "t.csv"}},
     'own_ship.track: "t.csv" is a file, but this scene came without a folder; pass folder='),
    ({"body": [{"name": "a", "mesh": "a.obj"}]}, 'body[0].mesh: "a.obj" is a file, but this scene came without a folder'),
    ({1: 2}, "1: this is not a known key"),
]  # fmt: skip


@pytest.mark.parametrize("source, message", ONE_PROBLEM)
def test_bad_scenes(source: dict[str, Any], message: str) -> None:
    result = problems(source)
    assert len(result) == 1, result
    assert result[0].startswith(message), result[0]
    assert len(result[0]) < 900 and "\n" not in result[0]


def test_a_mapping_that_holds_itself() -> None:
    data: dict[str, Any] = {}
    data["radar"] = data
    assert "nested more than 24 deep" in problems(data)[0]
