"""The short modules of scene_file/checks, each under its name."""

import contextlib
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scattering.physical_optics import model
from radar_service.scene_file.checks.mesh_findings import (
    LONGEST,
    MAX_OPTICS_AREA,
    axis_findings,
    check_optics_area,
    mesh_notes,
    mesh_warnings,
    metres,
    size_findings,
)
from radar_service.scene_file.checks.validity import nearest_point, surfaces_above
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.body import MeshBodyModel, ShapeBodyModel
from radar_service.world.error import SceneError
from radar_service.world.poses import pose_at
from radar_service.world.shapes import box
from tests.scenes import point, scene

# mesh_findings: each finding once, open edges of many meshes in one line, holes in height maps as warnings.
OPEN, WINDING = "not watertight (3 open edges)", "winding inconsistent across 2 edges"
HOLES, KEPT = "7 samples without data become sea", "6 of 200 triangles kept, those above the sea and within radar coverage"


def test_a_single_open_mesh_is_noted_with_its_edges() -> None:
    meshes = [("body[0].mesh", "a.obj", ()), ("body[1].mesh", "b.obj", (OPEN, WINDING))]
    assert list(mesh_notes(meshes)) == [f"body[1].mesh: b.obj: {OPEN}, {WINDING}"] and not list(mesh_warnings(meshes))


def test_many_open_meshes_are_counted_in_one_line_and_other_findings_stay() -> None:
    meshes = [(f"body[{k}].mesh", "a.obj", (OPEN, WINDING) if k == 3 else (OPEN,)) for k in range(19)]
    assert list(mesh_notes(meshes)) == [
        f"body[3].mesh: a.obj: {WINDING}", "19 meshes are not watertight: body[0].mesh, body[1].mesh and 17 more",
    ]  # fmt: skip
    assert list(mesh_notes(meshes[:2])) == ["2 meshes are not watertight: body[0].mesh, body[1].mesh"]


def test_findings_of_a_file_are_told_once_for_all_its_bodies() -> None:
    """Two files of the same findings stay apart, and so do two findings of one file (another scale may be to blame)."""
    meshes = [(f"body[{k}].mesh", "ab"[k % 2] + ".obj", (WINDING,)) for k in range(7)] + [("body[7].mesh", "a.obj", (KEPT,))]
    assert list(mesh_notes(meshes)) == [
        f"body[0].mesh, body[2].mesh and 2 more: a.obj: {WINDING}", f"body[1].mesh, body[3].mesh and 1 more: b.obj: {WINDING}",
        f"body[7].mesh: a.obj: {KEPT}",
    ]  # fmt: skip


def test_missing_ground_is_a_warning_and_ground_out_of_reach_a_note() -> None:
    maps = [("body[0].heightmap", "h.tif", (HOLES, KEPT))]
    assert list(mesh_warnings(maps)) == [f"body[0].heightmap: h.tif: {HOLES}"]
    assert list(mesh_notes(maps)) == [f"body[0].heightmap: h.tif: {KEPT}"]


def test_the_scene_that_serve_runs_by_default_has_no_warning() -> None:
    harbour = load_scene("harbour")
    assert harbour.warnings == () and sum("not watertight" in note for note in harbour.notes) == 1


# validity: scenes outside the valid region of a method give warnings or errors; others do not.
BUOY = {"shape": "sphere", "radius_m": 1, "rcs_dbsm": 0}


def warned(text: str, bodies: list[dict[str, Any]] | None = None, **radar: Any) -> bool:
    """Whether loading warns with that text."""
    return any(text in warning for warning in scene(bodies or [], radar=radar).warnings)


def test_a_chirp_whose_samples_fold_gives_a_warning() -> None:
    """About where the stability study finds -40 dB: bandwidth x pulse 13.5 and 1.09 x bandwidth without a window."""
    assert warned("exceeds the sampled band", window="none", pulse_s=10 / 50e6)
    assert not warned("exceeds the sampled band", window="none", pulse_s=14.1 / 50e6)
    assert warned("exceeds the sampled band", window="none", pulse_s=2e-6, sample_rate_hz=54e6)
    assert not warned("exceeds the sampled band", window="none", pulse_s=2e-6, sample_rate_hz=56e6)
    assert not warned("exceeds the sampled band", sample_rate_hz=50e6)
    assert not warned("exceeds the sampled band", window="hamming", pulse_s=5 / 50e6)
    assert not warned("exceeds the sampled band", modulation="none", pulse_s=1e-7)


def test_a_short_chirp_sampled_at_its_bandwidth_gives_a_warning_with_its_error_and_remedies() -> None:
    """-26.6 dB with a Hamming window, as tests/radar/test_folding.py measures."""
    warning = "the field error is -27 dB, above -40 dB: raise sample_rate_hz to 6.25e+07, or lengthen pulse_s to 4e-07"
    assert warned(warning, pulse_s=4 / 50e6, sample_rate_hz=50e6)


def test_doppler_within_a_long_pulse_gives_a_warning() -> None:
    """lambda / (4 T) = 15.48 kn for 1 ms."""
    ferry = {"course_deg": 0}
    assert not warned("Doppler", [point("p", 0, 500, speed_kn=15.4, **ferry)], pulse_s=1e-3)
    assert warned("Doppler", [point("p", 0, 500, speed_kn=15.6, **ferry)], pulse_s=1e-3)
    assert not warned("Doppler", [point("p", 0, 500, speed_kn=40, **ferry)])


def test_bodies_at_rest_far_apart_give_a_warning() -> None:
    near, far = {**BUOY, "name": "near"}, {**BUOY, "name": "far"}
    assert not warned("km apart", [near, {**far, "position_m": [149e3, 0, 0]}])
    assert warned("km apart", [near, {**far, "position_m": [151e3, 0, 0]}])
    assert not warned("km apart", [near, point("far", 151e3, 0)])


def test_echoes_beyond_single_precision_are_refused() -> None:
    loud = {"power_w": 1e9, "gain_dbi": 80, "range_min_m": 1e-2}
    with pytest.raises(rs.SceneError, match=r"range_min_m.*at most 1e\+34 W.*raise range_min_m"):
        scene([point("p", 0, 500, rcs_dbsm=100)], radar=loud)
    scene([point("p", 0, 500, rcs_dbsm=100)], radar={**loud, "range_min_m": 1})
    scene([point("p", 0, 500, rcs_dbsm=10)], radar={"range_min_m": 1e-3})


def test_a_heave_that_dips_the_antenna_is_refused() -> None:
    scene(own_ship={"heave_m": 14.9}, radar={"height_m": 15})
    with pytest.raises(rs.SceneError, match="own_ship.heave_m: 15 m dips the antenna .* less than 15.0 m"):
        scene(own_ship={"heave_m": 15}, radar={"height_m": 15})
    with pytest.raises(rs.SceneError, match="leave it 10.6 m up"):
        scene(own_ship={"heave_m": 11, "roll_deg": 45}, radar={"height_m": 15})


# mesh_findings: what `check` says of a mesh as a ship: axes, size and draught; and what the remedies that it names do.
LONG_IN_X, LONG_IN_Y = box(2.0, 6.0, 1.0), box(6.0, 2.0, 1.0)  # length along y, then beam


def body(**keys: Any) -> MeshBodyModel:
    return MeshBodyModel.model_validate({"name": "b", "mesh": "b.obj", **keys})


@pytest.mark.parametrize(
    ("keys", "noted"),
    [({}, True), ({"up": "z"}, False), ({"up": "y"}, False), ({"mesh": "b.obj"}, False), ({"mesh": "B.GLB"}, True)],
)
def test_a_glb_without_up_is_noted(keys: dict[str, Any], noted: bool) -> None:
    findings = axis_findings(body(**{"mesh": "b.glb", **keys}), LONG_IN_Y)
    assert [f.split(":")[1] for f in findings] == [' set up = "y", or up = "z" if this file has z up'] * noted


@pytest.mark.parametrize(
    ("keys", "noted"),
    [
        ({"speed_kn": 5}, True), ({}, False), ({"speed_kn": 5, "drift_deg": 90}, False), ({"speed_kn": 5, "drift_deg": 5}, True),
        ({"speed_kn": 5, "course_deg": 0, "heading_deg": 270}, False), ({"track": "a.csv"}, True),
        ({"waypoints": [{"position_m": [9, 9], "speed_kn": 3}]}, True),
    ],
)  # fmt: skip
def test_a_mesh_that_sails_by_its_side_is_noted(keys: dict[str, Any], noted: bool) -> None:
    findings = axis_findings(body(**keys), LONG_IN_X)
    assert [f.split(":")[0] for f in findings] == ["under way by its side"] * noted
    assert axis_findings(body(**keys), LONG_IN_Y) == ()


def test_the_remedy_points_x_along_the_course(tmp_path: Path) -> None:
    """At 37 degrees, also while it turns; the warning reaches the scene without it and is gone with it."""
    points = [f"v {x} {y} {z}\n" for x in (0, 6) for y in (0, 2) for z in (0, 1)]
    (tmp_path / "b.obj").write_text("".join(points) + "f 1 2 3\nf 5 6 7\n")
    boat = {"name": "b", "mesh": "b.obj", "position_m": [0, 500, 0], "course_deg": 37, "speed_kn": 4, "turn_rate_deg_s": 1}
    plain, turned = (rs.load_scene({"body": [{**boat, **more}]}, folder=tmp_path) for more in ({}, {"mesh_heading_deg": 90}))
    assert any("mesh_heading_deg = 90" in text for text in plain.warnings)
    assert not any("by its side" in text for text in turned.warnings)
    assert float(turned.bodies[0].motion.pose(0.0).heading[0]) == pytest.approx(
        math.radians(37), abs=1e-12
    )  # truth: the course
    assert (turned.bodies[0].length, turned.bodies[0].beam) == (6.0, 2.0)
    bow = pose_at(turned.bodies[0], 0.0).map_from_frame(np.array([[0.0, 1.0, 0.0]]))[0] - [0, 500, 0]
    assert bow[:2] == pytest.approx([math.sin(math.radians(37)), math.cos(math.radians(37))], abs=1e-9)  # rounding


@pytest.mark.parametrize(
    ("sizes", "keys", "finding"),
    [
        ((2, 3, 3.1), {"speed_kn": 1}, "under way on end: 3.1 m high and 3 m long"), ((2, 3, 3.1), {}, ""),
        ((2.5, 3.1, 3), {"speed_kn": 1}, ""),
    ],
)  # fmt: skip
def test_a_ship_on_its_end_is_noted(sizes: tuple[float, ...], keys: dict[str, Any], finding: str) -> None:
    findings = axis_findings(body(**keys), box(*sizes))
    assert [f[: len(finding)] for f in findings] == [finding] * bool(finding)


@pytest.mark.parametrize(("height", "noted"), [(0.0, False), (-2.0, False), (-2.01, True), (-9.0, True)])
def test_a_ship_mostly_under_water_is_noted(height: float, noted: bool) -> None:
    """The box is 4 m high."""
    findings = axis_findings(body(), box(9.0, 3.0, 4.0), height)
    assert [f.split(":")[0] for f in findings] == [f"{-height:.3g} of 4 m under water"] * noted
    assert axis_findings(body(material="concrete"), box(9.0, 3.0, 4.0), height) == ()


def test_the_hint_adds_to_a_turn_that_is_there() -> None:
    (finding,) = axis_findings(body(speed_kn=5, mesh_heading_deg=-60), LONG_IN_X)
    assert "mesh_heading_deg = 30" in finding


# mesh_findings: sizes that no ship, building or mountain has are warnings; metal that is too large is refused.
COASTER = Path(rs.__file__).parents[1] / "scenes"


def found(size: tuple[float, float, float], *, afloat: bool = True, **keys: Any) -> list[str]:
    body = MeshBodyModel.model_validate({"name": "b", "mesh": "b.obj", **keys})
    return list(size_findings(body, np.array(size, dtype=np.float64), afloat))


@pytest.mark.parametrize(
    ("size", "keys", "finding"),
    [
        ((60, 500, 40), {}, ""), ((60, 501, 40), {}, "501 m long"), ((501, 60, 40), {}, "501 m long"), ((1, 1, 1), {}, ""),
        ((0.2, 0.9, 0.2), {}, "0.9 m long"), ((13000, 88000, 21500), {}, "88000 m long, and ships have 1 to 500 m: set scale"),
        ((501, 60, 40), {"afloat": False}, ""), ((9e4, 9e4, 999), {"afloat": False, "material": "building"}, ""),
        ((9e4, 9e4, 1001), {"afloat": False, "material": "building"}, "1001 m high, and no building has more than 1000 m: set"),
        ((9e4, 9e4, 8849), {"afloat": False, "material": "rock"}, ""),
        ((9e4, 9e4, 9001), {"afloat": False, "material": "rock"}, "9001 m high, and no rock has more than 9000 m"),
    ],
)  # fmt: skip
def test_sizes_of_meshes(size: tuple[float, float, float], keys: dict[str, Any], finding: str) -> None:
    assert [text[: len(finding)] for text in found(size, **keys)] == [finding] * bool(finding)


@pytest.mark.parametrize(
    ("ais", "keys"),
    [
        ({"length_m": 100}, []), ({"length_m": 80}, []), ({"length_m": 79}, ["length_m"]), ({"length_m": 126}, ["length_m"]),
        ({"length_m": 100, "beam_m": 30}, ["beam_m"]), ({"length_m": 0}, []), ({}, []),
    ],
)  # fmt: skip
def test_a_mesh_is_compared_with_what_ais_says(ais: dict[str, Any], keys: list[str]) -> None:
    """The mesh is 100 m long and 20 m wide; 0 is no length. A shape is compared too."""
    texts = found((20, 100, 9), mmsi=299000001, ais=ais)
    assert [text.split("where ais.")[1].split()[0] for text in texts] == keys
    assert all(text.endswith(f"or correct ais.{key}") and "set scale" in text for text, key in zip(texts, keys, strict=True))
    hull = {"name": "h", "shape": "hull", "length_m": 100, "beam_m": 20, "height_m": 9, "position_m": [0, 900, 0]}
    scene = rs.load_scene({"body": [{**hull, "mmsi": 299000001, "ais": ais}]})
    assert [warning.split(": ")[0] for warning in scene.warnings] == ["body[0]"] * bool(keys)


def test_a_height_map_is_land_and_a_large_one_of_metal_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.full((3, 3), 20.0))
    table = {"name": "shore", "heightmap": "h.npy", "extent_m": [2000, 1000], "position_m": [0, 900, 0]}
    assert rs.load_scene({"body": [table]}, folder=tmp_path).bodies[0].material.name == "land"
    with pytest.raises(
        SceneError, match=r"^body\[0\]: shore is 2000 m .* km2 of steel; .*: set material = \"land\", or give"
    ):
        rs.load_scene({"body": [table | {"material": "steel"}]}, folder=tmp_path)


def test_a_mesh_in_millimetres_is_refused_before_it_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """At rest, under way, in a seaway, and as a platform; of shapes the keys of their sizes are named."""
    monkeypatch.setattr(model, "outward_side", lambda *_: pytest.fail("it is computed"))
    ship = {"name": "coaster", "mesh": "coaster.obj", "scale": 1000, "position_m": [3000, 4000, 0]}
    for keys in ({}, {"speed_kn": 10}):
        with pytest.raises(
            SceneError, match=r"body\[0\]: coaster is 88000 m large, .* of steel; at most 1 km2 .*: set scale"
        ):
            rs.load_scene({"environment": {"sea_state": 3, "seaway": True}, "body": [{**ship, **keys}]}, folder=COASTER)
    slab = {"name": "b", "shape": "box", "length_m": 3000, "width_m": 400, "height_m": 50, "position_m": [0, 4000, 0]}
    with pytest.raises(
        SceneError, match=r"3000 m large, with 2.74 km2 .*: correct length_m, width_m, height_m, or give scatt"
    ):
        rs.load_scene({"body": [slab]})


def test_a_huge_body_that_is_no_metal_works_with_a_warning_before_all_others() -> None:
    ship = {"name": "coaster", "mesh": "coaster.obj", "scale": 1000, "material": "wood", "speed_kn": 10}
    scene = rs.load_scene({"body": [{**ship, "position_m": [3000, 4000, 0]}]}, folder=COASTER)
    assert scene.warnings[0].startswith(
        "body[0].mesh: coaster.obj: 88000 m long, and ships have 1 to 500 m: set scale to the"
    )
    assert len(scene.warnings) == 2 and "antenna is inside" in scene.warnings[1]


def test_metal_is_limited_by_its_surface_beyond_the_longest_ship() -> None:
    """A bridge of 2 km is allowed, and whatever is no longer than LONGEST."""
    body = ShapeBodyModel.model_validate({"name": "b", "shape": "box", "length_m": 1, "width_m": 1, "height_m": 1})
    for sides, refused in (
        ((2000.0, 30.0, 5.0), False), ((LONGEST, LONGEST, 400.0), False), ((LONGEST + 1, LONGEST, 400.0), True),
    ):  # fmt: skip
        mesh = box(*sides)
        assert (2.0 * (sides[0] * sides[1] + (sides[0] + sides[1]) * sides[2]) > MAX_OPTICS_AREA) is (sides[2] == 400.0)
        with pytest.raises(SceneError, match="physical optics") if refused else contextlib.nullcontext():
            check_optics_area(body, mesh, np.ptp(mesh.vertices, axis=0), "body[0]")


def test_lengths_have_no_exponents() -> None:
    assert [metres(value) for value in (0.73485, 26.46, 99.96, 1004.9, 88000.0, 251300.4)] == [
        "0.735", "26.5", "100", "1005", "88000", "251300",
    ]  # fmt: skip


# validity: bodies in unusual positions.
BOX = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 8, "rcs_dbsm": 40}


def plateau(folder: Path, *bodies: dict[str, Any], radar: Any = None, **sections: Any) -> rs.Scene:
    """Land 30 m high, 400 m square, 700 m to the north, rising from the sea within 50 m."""
    heights = np.full((9, 9), 30.0)
    heights[[0, -1]] = heights[:, [0, -1]] = -1.0
    np.save(folder / "land.npy", heights)
    land = {"name": "land", "heightmap": "land.npy", "extent_m": [400, 400], "position_m": [0, 700, 0], "material": "land"}
    small = {"range_max_m": 1200, "azimuths": 90, "beamwidth_deg": 8}
    radars = [small | each for each in radar] if isinstance(radar, list) else small | (radar or {})
    return rs.load_scene({"radar": radars, "body": [land, *bodies], **sections}, folder=folder)


def test_bodies_under_the_ground_give_a_warning(tmp_path: Path) -> None:
    made = plateau(
        tmp_path,
        {"name": "cellar", **BOX, "position_m": [10, 700, 5]},
        {"name": "house", **BOX, "position_m": [10, 700, 25]},
        {"name": "half out", **BOX, "length_m": 300, "position_m": [10, 800, 5]},
        {"name": "beside", **BOX, "position_m": [300, 700, 0]},
        point("treasure", 20, 690, 29.9),
        point("bird", 20, 690, 30.1),
    )
    assert [w for w in made.warnings if "ground" in w] == [
        "body[1]: cellar is under the ground of land, so it has no echo; raise it",
        "body[5]: treasure is under the ground of land, so it has no echo; raise it",
    ]


@pytest.mark.parametrize("speed_kn", [0.0, 10.0])
def test_bodies_under_the_ground_have_no_echo(tmp_path: Path, speed_kn: float) -> None:
    """60 dBsm 2 m under a field changes no byte; 2 m over it, it outshines all else."""
    fields = []
    for up in (None, 28.0, 32.0):
        buried = [] if up is None else [point("t", 0, 600, up, 60.0, speed_kn=speed_kn, course_deg=90)]
        fields.append(rs.Simulator(plateau(tmp_path, *buried)).scan().field)
    assert np.isfinite(fields[1]).all()
    np.testing.assert_array_equal(fields[1], fields[0])
    assert np.abs(fields[2]).max() > 10 * np.abs(fields[0]).max()


def test_unusual_positions_give_a_warning_and_others_do_not() -> None:
    box = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 40}
    made = scene(
        [
            {"name": "around", **box},
            {"name": "beside", **box, "position_m": [30, 0, 0]},
            {"name": "overhead", "shape": "plate", "width_m": 9, "height_m": 9, "position_m": [0, 50, 30]},
            {"name": "sunk", **box, "position_m": [300, 0, -41]},
            {"name": "awash", **box, "position_m": [300, 0, -39]},
            point("drowned", 100, 100, -0.1),
            point("touching", 0.3, 0, 15.4),
            point("near", 1.0, 0, 15.0),
        ]
    )
    assert [w.split(":")[0] + w.split(";")[0][8:] for w in made.warnings] == [
        "body[0] the antenna is inside or under around, which occludes all other bodies",
        "body[3] sunk is entirely below the sea, so it has no echo",
        "body[5] drowned is entirely below the sea, so it has no echo",
        "body[6] touching is 0.5 m from the antenna",
    ]


def test_plumb_lines_count_surfaces_once() -> None:
    """Two square floors of two triangles each: the line falls on their diagonals, and counts one triangle of each."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    vertices = np.concatenate([corners, corners + [0, 0, 5]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    assert [surfaces_above(vertices, faces, np.array([0.0, 0.0, up])) for up in (-1.0, 2.0, 6.0)] == [2, 1, 0]
    assert surfaces_above(vertices, faces, np.array([3.0, 0.0, -1.0])) == 0


@pytest.mark.parametrize(
    ("east_north", "height", "words"),
    [
        ((0, 700), 40.0, "own ship is on land, which land has below its antenna; move it to the water, or give the radar a"),
        ((0, 700), 15.0, "the antenna is inside or under land"), ((190, 700), 15.0, "own ship is on land"), ((0, 400), 15.0, ""),
    ],
)  # fmt: skip
@pytest.mark.parametrize("speed_kn", [0.0, 5.0])
def test_own_ship_on_land_gives_a_warning(
    tmp_path: Path, east_north: tuple[float, float], height: float, words: str, speed_kn: float
) -> None:
    """The land is 30 m high, and at its border some 5 m."""
    own_ship = {"position_m": east_north, "speed_kn": speed_kn}
    made = plateau(tmp_path, radar={"height_m": height}, own_ship=own_ship)
    assert [words in warning for warning in made.warnings] == [True] * bool(words)


def test_a_shore_station_may_stand_on_land_and_a_ship_below_a_bridge_on_water(tmp_path: Path) -> None:
    station = [{"id": "vts", "height_m": 40.0, "platform": {"position_m": [0, 700]}}]
    assert plateau(tmp_path, radar=station).warnings == ()
    deck = {"name": "bridge", "shape": "box", "length_m": 9, "width_m": 900, "height_m": 2, "material": "concrete"}
    assert not any("on land" in warning for warning in plateau(tmp_path, {**deck, "position_m": [0, 0, 50]}).warnings)
    assert any("own ship is on land" in warning for warning in plateau(tmp_path, deck, radar={"height_m": 9.0}).warnings)


def test_the_nearest_point_lies_on_an_edge_at_a_corner_or_below() -> None:
    vertices = np.array([[0.0, 0.0, 5.0], [10.0, 0.0, 5.0], [0.0, 10.0, 5.0]])
    faces = np.array([[0, 1, 2]])
    for place, nearest in (
        ((5.0, -3.0), (5.0, 0.0)), ((-3.0, -4.0), (0.0, 0.0)), ((10.0, 10.0), (5.0, 5.0)), ((2.0, 3.0), (2.0, 3.0)),
    ):  # fmt: skip
        np.testing.assert_allclose(nearest_point(vertices, faces, np.array([*place, 7.0])), [*nearest, 7.0], atol=1e-12)
