"""The truth's records: ranges of values that clients rely on."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene.describe import describe

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
    scene = made(waypoints=[{"position_m": [WEST - 1e-18, 2000], "speed_kn": 12}])
    pose = scene.bodies[0].motion.pose(np.array([0.0, 1.0, 5.0]))
    for angle in (pose.course, pose.heading):
        assert angle.min() >= 0.0 and angle.max() < 2.0 * np.pi


@pytest.mark.parametrize("heading_deg", [359.96, -1e-15, 0.0])
def test_a_bearing_is_written_as_000_not_360(heading_deg: float) -> None:
    said = describe(made(heading_deg=heading_deg))
    assert "360.0" not in said and "bearing 000.0" in said and "heading 000.0" in said
