"""What `check` says of a mesh as a ship: axes, size and draught; and what the remedies that it names do."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.checks.mesh_findings import axis_findings
from radar_service.scene_file.model.body import MeshBodyModel
from radar_service.world.poses import pose_at
from radar_service.world.shapes import box

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
