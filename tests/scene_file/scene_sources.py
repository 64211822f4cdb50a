"""Scene descriptions and checks of errors that tests of loading share."""

from typing import Any

import pytest

from radar_service.scene_file.load import load_scene
from radar_service.world.error import SceneError

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


def point(name: str = "p", **keys: Any) -> dict[str, Any]:
    return {"name": name, "shape": "point", "rcs_dbsm": 0, **keys}


def problems(source: Any, **options: Any) -> tuple[str, ...]:
    with pytest.raises(SceneError) as caught:
        load_scene(source, **options)
    assert str(caught.value) == "\n".join(caught.value.problems)
    return caught.value.problems
