"""Motion from course and speed, waypoints and tracks."""

import math

import numpy as np
import pytest

from radar_service.constants import KNOT
from radar_service.scene.error import SceneError
from radar_service.scene.model import WaypointModel
from radar_service.scene.motion import constant_motion, motion_from_track, motion_from_waypoints

START = np.array([100.0, -50.0, 2.0])
TINY = 1e-9  # m: rounding of positions of a few km in float64


def waypoints(*stops: tuple[float, float, float]) -> list[WaypointModel]:
    return [WaypointModel(position_m=(east, north), speed_kn=speed) for east, north, speed in stops]


def test_constant_course_runs_clockwise_from_north() -> None:
    pose = constant_motion(START, None, 90.0, 12 * KNOT).pose(10.0)
    np.testing.assert_allclose(pose.position, [[100.0 + 120 * KNOT, -50.0, 2.0]], atol=TINY)
    assert pose.heading[0] == pytest.approx(math.pi / 2) and pose.course[0] == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("heading, course, want", [(30.0, None, (30, 30)), (None, 40.0, (40, 40)), (30.0, 40.0, (30, 40))])
def test_heading_and_course_default_to_each_other(
    heading: float | None, course: float | None, want: tuple[float, float]
) -> None:
    pose = constant_motion(START, heading, course, 1.0).pose(0.0)
    np.testing.assert_allclose(np.rad2deg([pose.heading[0], pose.course[0]]), want, rtol=1e-12)


def test_waypoints_use_the_speed_of_the_leg_that_leads_there() -> None:
    motion = motion_from_waypoints(waypoints((100, 950, 10), (600, 950, 20)), START, None, loop=False)
    first, second = 1000 / (10 * KNOT), 500 / (20 * KNOT)
    pose = motion.pose(np.array([0.0, first / 2, first + second / 2, first + second, first + second + 99]))
    np.testing.assert_allclose(pose.position[:, :2], [[100, -50], [100, 450], [350, 950], [600, 950], [600, 950]], atol=TINY)
    np.testing.assert_allclose(pose.speed / KNOT, [10, 10, 20, 0, 0], atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(pose.heading), [0, 0, 90, 90, 90], atol=1e-9)
    np.testing.assert_array_equal(pose.position[:, 2], 2.0)


def test_loop_returns_at_the_last_speed_for_ever() -> None:
    motion = motion_from_waypoints(waypoints((100, 950, 10), (100, 450, 20)), START, None, loop=True)
    period = 1000 / (10 * KNOT) + 500 / (20 * KNOT) + 500 / (20 * KNOT)
    assert motion.period == pytest.approx(period)
    np.testing.assert_allclose(motion.pose(period - 10.0).position, [[100, -50 + 200 * KNOT, 2]], atol=TINY)
    np.testing.assert_allclose(motion.pose(7 * period + 30.0).position, motion.pose(30.0).position, atol=1e-6)


def test_a_waypoint_underfoot_makes_no_leg_and_a_given_heading_stays() -> None:
    motion = motion_from_waypoints(waypoints((100, -50, 10), (100, -150, 10), (100, -150, 5)), START, 45.0, loop=False)
    assert motion.time.size == 2
    np.testing.assert_allclose(np.rad2deg(motion.pose([0.0, 1.0, 1e4]).heading), 45.0)
    still = motion_from_waypoints(waypoints((100, -50, 10)), START, None, loop=True)
    assert still.at_rest and still.period is None


def test_track_on_the_map_turns_the_short_way() -> None:
    content = b"\xef\xbb\xbftime_s, east_m, north_m, up_m, heading_deg\r\n10,0,0,1,350\r\n\r\n20,100,0,3,20\r\n"
    motion = motion_from_track(content, "track", None, None)
    pose = motion.pose(np.array([0.0, 15.0, 99.0]))
    np.testing.assert_allclose(pose.position, [[0, 0, 1], [50, 0, 2], [100, 0, 3]], atol=TINY)
    np.testing.assert_allclose(np.rad2deg(pose.heading), [350.0, 5.0, 20.0], atol=1e-9)


def test_track_on_the_earth_heads_along_its_legs() -> None:
    content = b"time_s,latitude_deg,longitude_deg\n0,50.9,1.4\n10,50.9,1.5\n20,50.9,1.5\n30,51.0,1.5\n"
    pose = motion_from_track(content, "track", None, (50.9, 1.4)).pose(np.array([5.0, 15.0, 25.0]))
    # headings bend by the meridian convergence of 0.1 degree of longitude: 0.1 sin(50.9)
    np.testing.assert_allclose((np.rad2deg(pose.heading) + 10) % 360, [100, 100, 10], atol=0.1)
    # 0.1 degree at 50.9 N is 7034.85 m east: pi/180 x N cos(latitude) / 10 on WGS 84
    assert pose.position[2, 0] == pytest.approx(7034.85, abs=8.0)  # the leg north runs 8 m west at half of its length


@pytest.mark.parametrize(
    "content, said",
    [
        (b"", "(none); needed are time_s"),
        (b"time_s,east_m\n0,0\n", "names the columns time_s, east_m"),
        (b"time_s,east_m,north_m,latitude_deg\n0,0,0,0\n", "needed are time_s"),
        (b"time_s,east_m,north_m,speed\n0,0,0,0\n", "needed are time_s"),
        (b"time_s,east_m,north_m\n", "0 rows of data"),
        (b"time_s,east_m,north_m\n0,0,0\n\n0,1,1\n", "line 4: time_s 0 does not rise"),
        (b"time_s,east_m,north_m\n0,0,0\n1,nan,1\n", 'line 3: east_m is "nan"'),
        (b"time_s,east_m,north_m\n0,0,0\n1,x,1\n", 'line 3: east_m is "x"'),
        (b"time_s,east_m,north_m\n0,0\n", "line 2: 2 values for 3 columns"),
        (b"time_s,east_m,north_m\n0,0,3e6\n", "line 2: [0.0, 3000000.0, 0.0] m is farther"),
        (b"time_s,latitude_deg,longitude_deg\n0,91,0\n", "line 2: latitude 91"),
        (b"time_s,east_m,north_m\n\xff", "not a CSV file in UTF-8"),
        (b'time_s,"east_m\n', "names the columns"),
    ],
)
def test_bad_tracks_name_the_line(content: bytes, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        motion_from_track(content, "body[0].track: t.csv", None, (0.0, 0.0))
    assert str(caught.value).startswith("body[0].track: t.csv") and said in str(caught.value)


def test_track_on_the_earth_needs_an_origin() -> None:
    with pytest.raises(SceneError, match="need an .origin."):
        motion_from_track(b"time_s,latitude_deg,longitude_deg\n0,1,1\n", "track", None, None)
