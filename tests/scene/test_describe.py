"""What `check` prints and what `schema` gives."""

import json
import math

import jsonschema
import pytest

from radar_service.scene.describe import describe, json_schema, two_way_beamwidth
from radar_service.scene.load import load_scene

SCENE = {
    "name": "two ships",
    "radar": {"range_max_m": 3000},
    "environment": {"noise": True, "rain_mm_h": 4},
    "body": [
        {"name": "buoy", "shape": "point", "rcs_dbsm": 10, "swerling": 1, "position_m": [500, 866.0254, 4]},
        {"name": "ferry", "shape": "hull", "length_m": 80, "beam_m": 14, "height_m": 12, "position_m": [-1000, 0, 0],
         "speed_kn": 12, "course_deg": 135, "mmsi": 235000001},
        {"name": "far", "shape": "box", "length_m": 4, "width_m": 4, "height_m": 4, "position_m": [0, -3100, 0]},
    ],
}  # fmt: skip


def test_description_has_the_derived_numbers() -> None:
    text = describe(load_scene(SCENE))
    for part in (
        "two ships",
        "wavelength 31.86 mm",  # c / 9.41 GHz
        "1502 bins of 1.9986 m",  # ceil(3000 / 1.99862)
        "resolves  2.998 m",  # c / (2 x 50 MHz)
        "720 spokes, 0.5 degrees, 24 rpm, 288.0 spokes/s",
        "two-way 2.808",  # design, section 3, row 2
        "horizon at 15964 m",  # sqrt(2 x 8 494 667 x 15)
        "noise, rain 4 mm/h",
        "1000.0 m off, bearing 030.0",
        "scattering rcs 10 dBsm, Swerling 1",
        "14 x 80 x 12 m (across, along, up)",
        "1000.0 m off, bearing 270.0",
        "course 135.0, 12.0 kn",
        "MMSI 235000001",
        "bearing 180.0 (beyond range)",
    ):
        assert part in text, part


def test_horizon_and_two_way_beam() -> None:
    scene = load_scene(SCENE)
    earth = 4 / 3 * 6_371_000
    assert scene.horizon(10.0) == pytest.approx(math.sqrt(2 * earth * 15) + math.sqrt(2 * earth * 10))
    flat = load_scene({"environment": {"earth": "flat"}, "radar": {"pattern": "gaussian", "beamwidth_deg": 2}})
    assert flat.horizon() == math.inf and "flat earth" in describe(flat)
    assert two_way_beamwidth(flat.radar) == pytest.approx(math.radians(2) / math.sqrt(2))  # a squared Gaussian
    assert two_way_beamwidth(load_scene({"radar": {"pattern": "taylor"}}).radar) is None


def test_below_the_horizon_is_said() -> None:
    box = {"name": "low", "shape": "box", "length_m": 4, "width_m": 4, "height_m": 1, "position_m": [0, 25_000, 0]}
    radar = {"range_max_m": 40_000, "bandwidth_hz": 5e6}
    assert "(below the horizon)" in describe(load_scene({"radar": radar, "body": [box]}))
    assert "(below the horizon)" not in describe(
        load_scene({"radar": radar, "body": [box], "environment": {"earth": "flat"}})
    )


def test_motion_and_origin_are_told() -> None:
    own_ship = {"waypoints": [{"position_m": [0, 1000], "speed_kn": 10}], "loop": True}
    text = describe(load_scene({"own_ship": own_ship, "origin": {"latitude_deg": 1, "longitude_deg": 2}}))
    assert "2 legs, round every 389 s" in text  # 2000 m at 5.144 m/s
    assert "latitude 1.000000, longitude 2.000000" in text


def test_schema_is_valid_and_agrees_with_the_loader() -> None:
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    json.dumps(schema, allow_nan=False)
    validator = jsonschema.Draft202012Validator(schema)
    assert validator.is_valid(SCENE)
    for bad in ({"radar": {"rpm": 0}}, {"radr": {}}, {"body": [{"shape": "point"}]}, {"radar": {"azimuths": 10**9}}):
        assert not validator.is_valid(bad)
    assert schema["$defs"]["RadarModel"]["properties"]["azimuths"]["description"] == "spokes per scan"
