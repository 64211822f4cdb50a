"""Track files: map and geographic positions, headings, bad lines."""

import numpy as np
import pytest

from radar_service.scene_file.readers.track import motion_from_track
from radar_service.world.error import SceneError

TINY = 1e-9  # m: rounding of positions of a few km in float64


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
    "content, message",
    [
        (b"", "(none); a track needs time_s"),
        (b"time_s,east_m\n0,0\n", "has the columns time_s, east_m"),
        (b"time_s,east_m,north_m,latitude_deg\n0,0,0,0\n", "a track needs time_s"),
        (b"time_s,east_m,north_m,speed\n0,0,0,0\n", "a track needs time_s"),
        (b"time_s,east_m,north_m\n", "0 rows of data"),
        (b"time_s,east_m,north_m\n0,0,0\n\n0,1,1\n", "line 4: time_s 0 is not above 0 of the row before"),
        (b"time_s,east_m,north_m\n0,0,0\n1,nan,1\n", 'line 3: east_m is "nan"'),
        (b"time_s,east_m,north_m\n0,0,0\n1,x,1\n", 'line 3: east_m is "x"'),
        (b"time_s,east_m,north_m\n0,0\n", "line 2: the row has 2 values for 3 columns"),
        (b"time_s,east_m,north_m\n0,0,3e6\n", "line 2: [0.0, 3000000.0, 0.0] m is too far"),
        (b"time_s,latitude_deg,longitude_deg\n0,91,0\n", "line 2: latitude 91"),
        (b"time_s,east_m,north_m\n\xff", "the file is not CSV in UTF-8"),
        (b'time_s,"east_m\n', "has the columns"),
    ],
)
def test_bad_tracks_name_the_line(content: bytes, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        motion_from_track(content, "body[0].track: t.csv", None, (0.0, 0.0))
    assert str(caught.value).startswith("body[0].track: t.csv") and message in str(caught.value)


def test_track_on_the_earth_needs_an_origin() -> None:
    with pytest.raises(SceneError, match="need an .origin."):
        motion_from_track(b"time_s,latitude_deg,longitude_deg\n0,1,1\n", "track", None, None)
