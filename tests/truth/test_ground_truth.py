"""The truth: positions and reasons of invisibility by hand, and ranges of values that clients rely on."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.describe import describe
from tests.scenes import point, scene

WEST = -1e-15  # m; a body this far west of north has an azimuth of -1e-18 rad, whose remainder rounds to 2 pi


def made(**motion: Any) -> rs.Scene:
    body = {"name": "p", "shape": "point", "position_m": [WEST, 1000, 10], "rcs_dbsm": 10, **motion}
    return rs.load_scene({"radar": {"azimuths": 90, "beamwidth_deg": 8, "range_max_m": 1500}, "body": [body]})


def test_azimuth_and_course_of_north_are_zero_not_a_whole_turn() -> None:
    (body,) = rs.Simulator(made(course_deg=-1e-15, heading_deg=0, speed_kn=10)).truth(0.0).bodies
    assert body.azimuth == 0.0
    assert 0.0 <= body.course < 2.0 * math.pi and 0.0 <= body.heading < 2.0 * math.pi


def test_poses_have_courses_and_headings_below_a_whole_turn() -> None:
    """The leg points 1e-21 rad to the left of north."""
    turned = made(waypoints=[{"position_m": [WEST - 1e-18, 2000], "speed_kn": 12}])
    pose = turned.bodies[0].motion.pose(np.array([0.0, 1.0, 5.0]))
    for angle in (pose.course, pose.heading):
        assert angle.min() >= 0.0 and angle.max() < 2.0 * np.pi


def test_a_bearing_is_written_as_000_not_360() -> None:
    description = describe(made(heading_deg=359.96))
    assert "360.0" not in description and "bearing 000.0" in description and "heading 000.0" in description


def test_positions_and_reasons_of_invisibility() -> None:
    """Positions at an instant by hand; each reason for not being visible."""
    wall = {"name": "wall", "shape": "plate", "width_m": 40, "height_m": 60, "position_m": [0, 500, 20], "rcs_dbsm": 0}
    made = scene(
        [
            wall, point("behind", 0, 900), point("far", 5000, 0), point("blind", -500, 0, mmsi=235000001),
            point("mover", 300, 0, course_deg=0, speed_kn=10), point("below", -30, 700, -5),
        ],
        radar={"range_max_m": 1500, "blind_sectors_deg": [[260, 280]]},
        origin={"latitude_deg": 50.0, "longitude_deg": 0.0},
    )  # fmt: skip
    truth = rs.Simulator(made).truth(10.0)
    truths = {body.name: body for body in truth.bodies}
    assert {name: body.reason for name, body in truths.items()} == {
        "wall": "", "behind": "shadowed", "far": "beyond range", "blind": "blind sector", "mover": "",
        "below": "below horizon",
    }  # fmt: skip
    mover = truths["mover"]
    assert mover.position == pytest.approx((300.0, 51.4444, 15.0), abs=1e-3)  # 10 kn for 10 s
    assert mover.azimuth == pytest.approx(np.arctan2(300, 51.4444), abs=1e-5)
    assert (mover.speed, mover.course) == pytest.approx((5.14444, 0.0), abs=1e-4)
    assert truths["blind"].mmsi == 235000001
    assert (truths["wall"].extent, truths["far"].extent) == (20.0, 0.0)  # half the plate's width; a point
    assert truths["behind"].latitude_deg == pytest.approx(50.0 + 900 / 111_229, abs=1e-6)  # 111.229 km a degree at 50 N
    assert truth.as_dict()["bodies"][0]["name"] == "wall"
