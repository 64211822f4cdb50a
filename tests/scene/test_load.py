"""Scenes as a whole: the example of the design, every kind of bad input with its place and remedy, and arbitrary rubbish."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from radar_service.constants import KNOT
from radar_service.scene.error import SceneError
from radar_service.scene.load import load_scene, model_from, scene_from_model
from radar_service.scene.model import SceneModel

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

EXAMPLE = """
name = "two targets"
[origin]
latitude_deg = 50.9
longitude_deg = 1.4
[radar]
frequency_hz = 9.41e9
bandwidth_hz = 50e6
pulse_s = 10e-6
sample_rate_hz = 75e6
window = "hamming"
azimuths = 720
rpm = 24
range_max_m = 5000
beamwidth_deg = 3.9
beamwidth_el_deg = 25
tilt_deg = 0
pattern = "sinc2"
height_m = 15
power_w = 25e3
gain_dbi = 30
loss_db = 0
noise_figure_db = 4
polarization = "h"
eclipsing = false
rays = 2000
[own_ship]
position_m = [0, 0]
heading_deg = 0
course_deg = 0
speed_kn = 0
[environment]
earth = "4/3"
noise = false
multipath = false
gas_db_per_km = 0.0
rain_mm_h = 0
sea_state = 0
[[body]]
name = "reflector"
shape = "point"
position_m = [500, 866, 4]
rcs_dbsm = 10
swerling = 0
[[body]]
name = "ferry"
mesh = "ferry.obj"
scale = 1.0
up = "z"
position_m = [-1200, 300, 0]
heading_deg = 90
course_deg = 90
speed_kn = 12
material = "steel"
scattering = "optics"
mmsi = 235000001
[[body]]
name = "island"
heightmap = "catalina.png"
extent_m = [4000, 4000]
low_m = -2063
high_m = 633
material = "land"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    home = tmp_path / "home"
    home.mkdir()
    (home / "ferry.obj").write_text(TETRAHEDRON)
    Image.fromarray(np.full((5, 5), 230, dtype=np.uint8)).save(home / "catalina.png")
    (home / "scene.toml").write_text(EXAMPLE)
    return home


def point(name: str = "p", **keys: Any) -> dict[str, Any]:
    return {"name": name, "shape": "point", "rcs_dbsm": 0, **keys}


def problems(source: Any, **options: Any) -> tuple[str, ...]:
    with pytest.raises(SceneError) as caught:
        load_scene(source, **options)
    assert str(caught.value) == "\n".join(caught.value.problems)
    return caught.value.problems


def test_the_example_of_the_design(folder: Path) -> None:
    scene = load_scene(folder / "scene.toml")
    assert (scene.name, scene.origin) == ("two targets", (50.9, 1.4))
    radar = scene.radar
    assert radar.range_step == pytest.approx(1.9986, abs=5e-5)  # as printed in the design
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
        "body[0]: reflector lies under the ground of island",
        "body[1]: ferry lies under the ground of island",
        "body[2]: the antenna stands in or under island",
    ]


def test_json_mapping_and_model_agree(folder: Path) -> None:
    import tomllib

    data = tomllib.loads(EXAMPLE)
    (folder / "scene.json").write_text(json.dumps(data))
    want = repr(load_scene(folder / "scene.toml"))
    assert repr(load_scene(str(folder / "scene.json"))) == want
    assert repr(load_scene(data, folder=folder)) == want
    assert repr(scene_from_model(model_from(folder / "scene.toml"), folder)) == want
    as_numpy = {**data, "body": [{**data["body"][0], "position_m": np.array([500.0, 866.0, 4.0])}]}
    assert load_scene(as_numpy).bodies[0].motion.position[0, 1] == np.float64(866)


def test_bodies_share_one_file(folder: Path) -> None:
    bodies = [{"name": f"b{k}", "mesh": "ferry.obj", "scale": 2.0 if k == 2 else 1.0} for k in range(3)]
    a, b, c = load_scene({"body": bodies}, folder=folder).bodies
    assert a.mesh is b.mesh and a.mesh is not c.mesh


def test_bodies_by_latitude_and_longitude() -> None:
    body = point(latitude_deg=50.9, longitude_deg=1.5, up_m=7)
    place = load_scene({"origin": {"latitude_deg": 50.9, "longitude_deg": 1.4}, "body": [body]}).bodies[0].motion.position[0]
    assert place[0] == pytest.approx(7034.85, abs=0.02)  # m: pi/1800 x N cos(latitude) on WGS 84, and its last digit
    assert place[2] == 7.0


def test_defaults_and_converted_units() -> None:
    radar = {"pattern": [[0, 0], [1, -3], [2, -40]], "blind_sectors_deg": [[90, 180]], "tilt_deg": -2, "loss_db": 3}
    scene = load_scene({"radar": radar, "environment": {"earth": "flat", "gas_db_per_km": "itu", "wind_from_deg": 90}})
    assert scene.radar.pattern.rows[1] == (pytest.approx(math.radians(1)), pytest.approx(10**-0.3))
    assert scene.radar.blind_sectors == ((pytest.approx(math.pi / 2), pytest.approx(math.pi)),)
    assert scene.radar.loss == pytest.approx(10**0.3)
    assert scene.environment.earth_factor == math.inf
    assert scene.environment.gas_db_per_km == pytest.approx(0.01327, rel=0.1)  # P.676-12 Annex 1; 10 % as Annex 2 claims
    assert scene.environment.wind_from == pytest.approx(math.pi / 2)
    assert scene.radar.sample_rate == 75e6


CORNERS = {"name": "h", "heightmap": "h.npy", "south_west_deg": [1, 1], "north_east_deg": [2, 2]}

# The form of every message: place, value, what is allowed, remedy.
ONE_PROBLEM: list[tuple[dict[str, Any], str]] = [
    (
        {"body": [point("a"), point("b"), point("c"), point("d", position_m=[0, math.nan, 0])]},
        "body[3].position_m[1]: nan is not allowed; a finite number from -2000000 to 2000000; give a finite number",
    ),
    (
        {"body": [point(position_m=[0, 0, math.inf])]},
        "body[0].position_m[2]: inf is not allowed; a finite number from -11000",
    ),
    ({"body": [point(position_m=[0, 0, -math.inf])]}, "body[0].position_m[2]: -inf is not allowed"),
    ({"body": [point(position_m=[0, 0])]}, "body[0].position_m[2]: missing; a finite number from -11000 to 20000; add it"),
    ({"body": [point(position_m=[0, 0, 0, 0])]}, "body[0].position_m: [0, 0, 0, 0] is not allowed; a list of 3 values"),
    ({"body": [point(position_m="here")]}, 'body[0].position_m: "here" is not allowed; a list of 3 values'),
    ({"body": [point(positon_m=[0, 0, 0])]}, 'body[0].positon_m: not a known key; did you mean "position_m"? (allowed: '),
    (
        {"zzz": 1},
        "zzz: not a known key; remove it (allowed: name, origin, radar, own_ship, environment, body, interference)",
    ),
    ({"radar": {"azimuths": 10**9}}, "radar.azimuths: 1000000000 is not allowed; a whole number from 4 to 16384; lower it"),
    ({"radar": {"azimuths": 10**400}}, "radar.azimuths: an integer of 1329 bits is not allowed; a whole number from 4"),
    ({"radar": {"azimuths": 720.5}}, "radar.azimuths: 720.5 is not allowed; a whole number"),
    ({"radar": {"azimuths": True}}, "radar.azimuths: true is not allowed; a whole number"),
    (
        {"radar": {"rpm": "24"}},
        'radar.rpm: "24" is not allowed; a finite number from 0.01 to 600; write the number without quotes',
    ),
    ({"radar": {"rpm": -1}}, "radar.rpm: -1 is not allowed; a finite number from 0.01 to 600; raise it"),
    ({"radar": {"window": "hat"}}, 'radar.window: "hat" is not allowed; one of "none", "hamming"'),
    ({"radar": {"pattern": "x"}}, 'radar.pattern: "x" is not allowed; one of "sinc2"'),
    ({"radar": {"pattern": [[0, 0], [1, math.nan]]}}, "radar.pattern[1][1]: nan is not allowed; a finite number"),
    ({"radar": {"pattern": [[0, 0]]}}, "radar.pattern: a table has 2 to 10000 rows"),
    ({"radar": {"pattern": [[0, 0], [0, -1]]}}, "radar.pattern: the offsets start at 0 and rise"),
    ({"radar": {"pattern": [[0, 0], [1, 1]]}}, "radar.pattern: gains are in dB below boresight"),
    ({"radar": {"eclipsing": 1}}, "radar.eclipsing: 1 is not allowed; true or false"),
    ({"radar": {"sample_rate_hz": 1e6}}, "radar.sample_rate_hz: 1e+06 is below the bandwidth"),
    ({"radar": {"range_max_m": 200_000}}, "radar.range_max_m: 200000 m at 7.5e+07 samples/s makes 100070 range bins"),
    ({"radar": {"azimuths": 16384, "range_max_m": 100_000}}, "radar.azimuths: 16384 x 50035 range bins are 819773440 cells"),
    ({"radar": {"pulse_s": 1e-3, "sample_rate_hz": 4e9}}, "radar.range_max_m"),
    ({"radar": {"pulse_s": 1e-3, "bandwidth_hz": 2e9, "range_max_m": 1000}}, "radar.pulse_s: 0.001 s at 3e+09 samples/s"),
    ({"radar": 5}, "radar: 5 is not allowed; a table with the keys frequency_hz"),
    (
        {"environment": {"earth": -1}},
        'environment.earth: -1 is not allowed; one of "4/3", "flat" or a finite number above 0',
    ),
    ({"environment": {"earth": "round"}}, 'environment.earth: "round" is not allowed; one of "4/3", "flat" or a finite'),
    (
        {"environment": {"gas_db_per_km": math.nan}},
        'environment.gas_db_per_km: nan is not allowed; one of "itu" or a finite',
    ),
    ({"environment": {"gas_db_per_km": "itu"}, "radar": {"frequency_hz": 60e9}}, 'environment.gas_db_per_km: "itu" covers'),
    ({"environment": {"sea_state": 10}}, "environment.sea_state: 10 is not allowed; a whole number from 0 to 9; lower it"),
    ({"body": {}}, "body: a table of 0 keys is not allowed; a list of at most 10000 values"),
    ({"body": [5]}, "body[0]: 5 is not allowed; a table with the keys"),
    ({"body": [point(), point()]}, 'body[1].name: "p" is taken by an earlier body; names are unique'),
    ({"body": [{"shape": "point", "rcs_dbsm": 1}]}, "body[0].name: missing; text of 1 to 200 characters; add it"),
    ({"body": [point("")]}, 'body[0].name: "" is not allowed; text of 1 to 200 characters; lengthen it'),
    ({"body": [{"name": "a"}]}, "body[0].shape: a body has exactly one of shape, mesh, heightmap; this one has none"),
    (
        {"body": [point(mesh="a.obj")]},
        "body[0].shape: a body has exactly one of shape, mesh, heightmap; this one has shape and mesh",
    ),
    ({"body": [{"name": "a", "shape": "point"}]}, "body[0].rcs_dbsm: a point has no surface of its own"),
    ({"body": [{"name": "a", "shape": "sphere"}]}, 'body[0].radius_m: missing; shape = "sphere" needs radius_m: add it'),
    (
        {"body": [{"name": "a", "shape": "sphere", "radius_m": -1}]},
        "body[0].radius_m: -1 is not allowed; a finite number above 0 up",
    ),
    (
        {"body": [{"name": "a", "shape": "sphere", "radius_m": 0}]},
        "body[0].radius_m: 0 is not allowed; a finite number above 0",
    ),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1e9}]}, "body[0].radius_m: 1000000000 is not allowed"),
    ({"body": [point(radius_m=1)]}, 'body[0].radius_m: shape = "point" takes no sizes; remove radius_m'),
    ({"body": [point(scale=2.0)]}, "body[0].scale: belongs to a body with mesh; remove it"),
    ({"body": [point(low_m=0)]}, "body[0].low_m: belongs to a body with heightmap; remove it"),
    ({"body": [point(material="cheese")]}, 'body[0].material: "cheese" is not a known material; one of steel, aluminium'),
    ({"body": [point(scattering="optics")]}, 'body[0].rcs_dbsm: declared, so scattering cannot be "optics"'),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1, "swerling": 1}]}, "body[0].swerling: fluctuation is defined"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1, "scattering": "rcs"}]}, "body[0].rcs_dbsm: scattering"),
    ({"body": [point(latitude_deg=1.0)]}, "body[0].latitude_deg: goes together with longitude_deg"),
    (
        {"body": [point(latitude_deg=1.0, longitude_deg=1.0)]},
        "body[0].latitude_deg: latitude and longitude need an [origin]",
    ),
    ({"body": [point(latitude_deg=1.0, longitude_deg=1.0, position_m=[0, 0, 0])]}, "body[0].position_m: latitude_deg and"),
    (
        {"body": [point(latitude_deg=91.0, longitude_deg=1.0)]},
        "body[0].latitude_deg: 91 is not allowed; a finite number from -90",
    ),
    ({"body": [point(up_m=1.0)]}, "body[0].up_m: goes with latitude_deg"),
    ({"body": [point(speed_kn=1, track="t.csv")]}, "body[0].speed_kn: one of speed_kn"),
    ({"body": [point(loop=True)]}, "body[0].loop: only a body with waypoints can go round"),
    (
        {"body": [point(course_deg=1, waypoints=[{"position_m": [1, 1], "speed_kn": 1}])]},
        "body[0].course_deg: waypoints already",
    ),
    ({"body": [point(position_m=[0, 0, 0], track="t.csv")]}, "body[0].position_m: the track already says where it is"),
    (
        {"body": [point(waypoints=[{"position_m": [1, 1], "speed_kn": 0}])]},
        "body[0].waypoints[0].speed_kn: 0 is not allowed",
    ),
    (
        {"body": [point(waypoints=[{"position_m": [1, 1]}])]},
        "body[0].waypoints[0].speed_kn: missing; a finite number above 0",
    ),
    (
        {"body": [{"name": "h", "heightmap": "h.png", "heading_deg": 5}]},
        "body[0].heading_deg: a height map has north at its top",
    ),
    ({"body": [{"name": "h", "heightmap": "h.png", "low_m": 5, "high_m": 5}]}, "body[0].high_m: 5 is not above low_m 5"),
    (
        {"body": [CORNERS | {"extent_m": [9, 9]}]},
        "body[0].extent_m: the corners south_west_deg and north_east_deg already say",
    ),
    ({"body": [CORNERS | {"north_east_deg": None}]}, "body[0].south_west_deg: goes together with north_east_deg"),
    ({"body": [CORNERS | {"position_m": [5, 0, 0]}]}, "body[0].south_west_deg: the corners already place the map"),
    ({"body": [CORNERS | {"speed_kn": 5}]}, "body[0].heightmap: a height map cannot move"),
    ({"body": [CORNERS]}, "body[0].latitude_deg: latitude and longitude need an [origin]"),
    ({"own_ship": {"speed": 3}}, 'own_ship.speed: not a known key; did you mean "speed_kn"?'),
    (
        {"own_ship": {"track": "t.csv"}},
        'own_ship.track: "t.csv" is a file, but this scene came without a folder; pass folder=',
    ),
    ({"body": [{"name": "a", "mesh": "a.obj"}]}, 'body[0].mesh: "a.obj" is a file, but this scene came without a folder'),
    ({1: 2}, "1: not a known key"),
]


@pytest.mark.parametrize("source, said", ONE_PROBLEM)
def test_bad_scenes(source: dict[str, Any], said: str) -> None:
    found = problems(source)
    assert len(found) == 1, found
    assert found[0].startswith(said), found[0]
    assert len(found[0]) < 900 and "\n" not in found[0]


@pytest.mark.parametrize(
    "name, said",
    [
        ("missing.obj", '"missing.obj" is not a file in'),
        ("../outside.obj", "leaves the scene's folder"),
        ("/etc/passwd", "leaves the scene's folder"),
        ("sub/../../outside.obj", "leaves the scene's folder"),
        ("link.obj", "leads out of"),
        ("linked/outside.obj", "leads out of"),
        ("sub", "is a folder"),
        ("C:\\ferry.obj", "leaves the scene's folder"),
        ("file:ferry.obj", "leaves the scene's folder"),
        ("a\0b.obj", "cannot be looked up"),
        ("x" * 400, "cannot be looked up"),
        ("loop.obj", "cannot be looked up"),
    ],
)
def test_files_stay_in_the_folder(folder: Path, name: str, said: str) -> None:
    (folder.parent / "outside.obj").write_text(TETRAHEDRON)
    (folder / "sub").mkdir()
    (folder / "link.obj").symlink_to(folder.parent / "outside.obj")
    (folder / "linked").symlink_to(folder.parent)
    (folder / "loop.obj").symlink_to(folder / "loop.obj")
    (found,) = problems({"body": [{"name": "a", "mesh": name}]}, folder=folder)
    assert found.startswith("body[0].mesh: ") and said in found
    (found,) = problems({"body": [{"name": "a", "heightmap": name}]}, folder=folder)
    assert found.startswith("body[0].heightmap: ") and said in found
    (found,) = problems({"body": [point(track=name)]}, folder=folder)
    assert found.startswith("body[0].track: ") and said in found


def test_links_and_folders_inside_the_folder_are_fine(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "other.obj").symlink_to(folder / "ferry.obj")
    scene = load_scene({"body": [{"name": "a", "mesh": "sub/other.obj"}]}, folder=folder)
    assert scene.bodies[0].mesh is not None


def test_several_problems_come_together(folder: Path) -> None:
    bodies = [{"name": f"b{k}", "mesh": f"missing{k}.obj"} for k in range(25)]
    found = problems({"body": bodies}, folder=folder)
    assert len(found) == 21 and found[0].startswith("body[0].mesh") and found[20] == "... and 5 more problems"
    both = problems({"radar": {"rpm": 0}, "body": [point(swerling=9)]})
    assert [line.split(":")[0] for line in both] == ["radar.rpm", "body[0].swerling"]


@pytest.mark.parametrize(
    "name, content, said",
    [
        ("a.toml", b"name = ", "not valid TOML"),
        ("a.toml", b"name = 1\nname = 2\n", "not valid TOML"),
        ("a.toml", b"name = \xff", "byte 7 is not UTF-8"),
        ("a.json", b"{", "not valid JSON"),
        ("a.json", b"[]", "holds a list; a scene is a table"),
        ("a.json", b"", "not valid JSON"),
        ("a.json", b'{"name": "a", "name": "b"}', 'the key "name" stands twice'),
        ("a.json", b'{"radar": {"rpm": NaN}}', "radar.rpm: nan is not allowed"),
        ("a.json", b'{"radar": {"azimuths": ' + b"9" * 5000 + b"}}", "not valid JSON"),
        ("a.json", b"[" * 200_000, "nested more than 1000 deep"),
        ("a.json", b'{"a":' * 900 + b"1" + b"}" * 900, "nested"),
        ("a.toml", b"a = " + b"[" * 200_000, "nested more than 1000 deep"),
        ("a.toml", b"a." * 5000 + b"a = 1", "a key of more than 200 parts"),
        ("a.toml", b"a." * 100 + b"a = 1", "nested more than 24 deep"),
        ("a.yaml", b"name: a", 'the ending ".yaml" is not known'),
        ("a.toml", b"#" * (10 * 2**20 + 1), "larger than 10485760 bytes"),
        ("a.toml", b"name = 1979-05-27", "name: 1979-05-27 is not allowed; text"),
    ],
)
def test_bad_scene_files(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    assert said in problems(tmp_path / name)[0]


@pytest.mark.parametrize(
    "source", ["no-such-scene", "scenes/no-such.toml", "../harbour", "", ".", "a\0b", "x" * 5000, Path("nix.toml")]
)
def test_missing_scenes(source: str | Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(problems(source)) == 1


@pytest.mark.parametrize("source", [None, 5, [1], b"scene", {"a"}])
def test_what_is_no_source(source: Any) -> None:
    assert "is not a scene; give the path" in problems(source)[0]


def test_folders_and_unreadable_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "is a folder" in problems(tmp_path)[0]
    (tmp_path / "a.toml").write_text("")

    def refuse(path: Path, mode: str) -> None:
        raise PermissionError(13, "Permission denied")  # as for a user who may not; the superuser may read everything

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be read ([Errno 13] Permission denied)" in problems(tmp_path / "a.toml")[0]


def test_a_mapping_that_holds_itself() -> None:
    data: dict[str, Any] = {}
    data["radar"] = data
    assert "nested more than 24 deep" in problems(data)[0]


def test_packaged_scenes_are_found_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "pond.toml").write_text('name = "pond"')
    monkeypatch.chdir(tmp_path / "..")
    monkeypatch.setattr("radar_service.scene.source.packaged_folder", lambda name: tmp_path / name)
    assert load_scene("pond").name == load_scene("scenes/pond.toml").name == load_scene("pond.toml").name == "pond"
    assert "(pond)" in problems("ponds")[0]


def test_too_many_triangles_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.scene.builder.InProcess.max_triangles", 700)
    bodies = [{"name": f"s{k}", "shape": "sphere", "radius_m": 0.1, "rcs_dbsm": 0} for k in range(3)]
    assert problems({"body": bodies})[0].startswith("body[2]: brings the scene to 960 triangles; at most 700")


SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["point", "sphere", "a.obj"])
)
KEYS = st.sampled_from(
    [*SceneModel.model_fields, "rpm", "shape", "position_m", "waypoints", "pattern", "name", "track", "x"]
)
RUBBISH = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS | st.integers(), inner, max_size=5),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(KEYS, RUBBISH, max_size=5))
def test_rubbish_raises_nothing_else(source: dict[str, Any]) -> None:
    try:
        load_scene(source)
    except SceneError as fault:
        assert fault.problems and all(fault.problems)


@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(st.sampled_from(["a.toml", "a.json"]), st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_rubbish_files_raise_nothing_else(tmp_path_factory: pytest.TempPathFactory, name: str, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(content)
    try:
        load_scene(path)
    except SceneError as fault:
        assert fault.problems


def test_one_line_of_many_numbers_is_no_long_key(tmp_path: Path) -> None:
    """300 decimals in one line of JSON or TOML are numbers; 300 dotted parts are a key too long."""
    rows = [[0.5 * k, -0.25 * k] for k in range(300)]
    scene = {"name": "table", "radar": {"pattern": rows, "range_max_m": 300.0}}
    (tmp_path / "a.json").write_text(json.dumps(scene))
    (tmp_path / "a.toml").write_text(f"[radar]\nrange_max_m = 300\npattern = [[0, 0],\n{str(rows[1:])[1:]}\n")
    for name in ("a.json", "a.toml"):
        assert len(load_scene(tmp_path / name).radar.pattern.rows) == 300
    (tmp_path / "b.toml").write_text(f"x = {{ {'.'.join('a' * 300)} = 1 }}\n")
    with pytest.raises(SceneError, match="a key of more than 200 parts"):
        load_scene(tmp_path / "b.toml")


def test_far_from_the_origin_the_map_is_said_to_be_stretched() -> None:
    """c / sin c - 1 at 1000 km: 0.1570 rad, 0.41 %; at 100 km nothing is said."""
    scene = {"origin": {"latitude_deg": 50, "longitude_deg": 0}, "own_ship": {"position_m": [1e6, 0]}}
    (warning,) = load_scene(scene).warnings
    assert warning.startswith("own_ship: 1000 km from the origin") and "0.41%" in warning
    assert not load_scene(scene | {"own_ship": {"position_m": [1e5, 0]}}).warnings
