"""The short modules of scene_file/checks, each under its name."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.checks.mesh_findings import axis_findings, mesh_notes, mesh_warnings
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.body import MeshBodyModel
from radar_service.world.poses import pose_at
from radar_service.world.shapes import box
from tests.scenes import point, scene

# mesh_findings: each finding once, open edges of many meshes in one line, holes in height maps as warnings.
OPEN, WINDING = "not watertight (3 open edges)", "winding inconsistent across 2 edges"
HOLES, KEPT = "7 samples without data become sea", "6 of 200 triangles kept, those above the sea and within radar coverage"


def test_a_mesh_without_findings_gives_no_sentence() -> None:
    meshes = [("body[0].mesh", "a.obj", ())]
    assert [*mesh_notes(meshes), *mesh_warnings(meshes)] == []


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
