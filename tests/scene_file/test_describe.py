"""The output of `check` and `schema`."""

import json
from dataclasses import replace

import jsonschema

import radar_service as rs
from radar_service.scene_file.describe import SCREEN, describe, json_schema, overview
from radar_service.scene_file.load import load_scene
from tests.scenes import TWO_RADARS, point, scene

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


MANY = [point(f"buoy {k}", 0, 3000 - 40 * k) for k in range(40)]


def test_an_overview_is_one_screen_with_what_matters_first() -> None:
    """Warnings, the radar, bodies out of sight, then the nearest; the last line says what is left out."""
    made = load_scene({"name": "many", "radar": {"range_max_m": 2900}, "own_ship": {"speed_kn": 3}, "body": MANY})
    lines = overview(made, {"buoy 39": ["one", "two"]}).splitlines()
    assert len(lines) == SCREEN and lines[0] == "scene       many: 40 bodies, 0 triangles"
    bodies = [line.split(":")[0].strip() for line in lines if line.startswith("  buoy")]
    assert bodies[:5] == ["buoy 2", "buoy 1", "buoy 0", "buoy 39", "buoy 38"]
    assert "beyond range" in lines[-1 - len(bodies)] and "2 remarks" in lines[-len(bodies) + 2]
    assert lines[-1] == (
        f"--all       shows {40 - len(bodies)} bodies, 2 remarks on bodies more, and all numbers of the radar and of each body"
    )


def test_an_overview_begins_with_the_warnings() -> None:
    made = load_scene(SCENE)
    warned = replace(made, warnings=tuple(f"warning {k}" for k in range(10)))
    lines = overview(warned).splitlines()
    assert (
        lines[1] == "warning     warning 0" and "2 warnings" in lines[-1] and sum("warning " in line for line in lines) == 8
    )
    assert any(line.startswith("  ferry: 80 x 14 x 12 m  1000 m off, bearing 270.0, 12.0 kn; ") for line in lines)
    assert any(line.startswith("  buoy:           point  1000 m off, bearing 030.0") for line in lines)
    assert any(line.startswith("  buoy: ") and "rcs 10 dBsm" in line for line in lines)


def test_land_is_as_far_off_as_its_nearest_point() -> None:
    """A coast 2 km long, 1 km off, turned by 30 degrees: 990 m along its normal, in plan. A ship is where its origin is."""
    coast = {"shape": "box", "length_m": 20, "width_m": 2000, "height_m": 8, "position_m": [500, 866.0254, 0],
             "heading_deg": 30}  # fmt: skip
    made = load_scene(
        {"body": [{**coast, "name": "coast", "material": "rock"}, {**coast, "name": "ship", "material": "steel"}]}
    )
    near, own = (next(line for line in overview(made).splitlines() if f"  {name}:" in line) for name in ("coast", "ship"))
    assert "20 x 2000 x 8 m  990 m off, bearing 030.0, at rest" in near and "1000 m off" in own
    assert "\n    990.0 m off, bearing 030.0" in describe(made)


def test_land_below_the_antenna_is_no_distance_off() -> None:
    land = {"name": "land", "shape": "box", "length_m": 200, "width_m": 200, "height_m": 8, "material": "land"}
    assert "  land: 200 x 200 x 8 m  0 m off" in overview(load_scene({"body": [land]}))


def test_bodies_below_the_horizon_are_marked() -> None:
    box = {"name": "low", "shape": "box", "length_m": 4, "width_m": 4, "height_m": 1, "position_m": [0, 25_000, 0]}
    radar = {"range_max_m": 40_000, "bandwidth_hz": 5e6}
    assert "(below the horizon)" in describe(load_scene({"radar": radar, "body": [box]}))
    flat = describe(load_scene({"radar": radar, "body": [box], "environment": {"earth": "flat"}}))
    assert "(below the horizon)" not in flat and "flat earth" in flat


def test_motion_and_origin_are_in_the_description() -> None:
    own_ship = {"waypoints": [{"position_m": [0, 1000], "speed_kn": 10}], "loop": True}
    text = describe(load_scene({"own_ship": own_ship, "origin": {"latitude_deg": 1, "longitude_deg": 2}}))
    assert "2 legs, repeats every 389 s" in text  # 2000 m at 5.144 m/s
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


def test_waveform_and_repetition_are_in_the_description() -> None:
    settings = {"modulation": "none", "pulse_s": 0.3e-6, "prf_hz": 1500, "second_time_around": True, "eclipsing": True}
    text = describe(scene([point("mine", 100, 0, -3)], radar=settings))
    for part in (
        "0.3 us, 4 MHz, not modulated, 1500 a second: unambiguous to 99931 m, second-time-around echoes fold",
        "eclipsed to 45 m",
        "resolves  44.969 m, half the length of the pulse",
        "bearing 090.0 (below the sea)",
    ):
        assert part in text, part


def test_arcs_and_sway_are_in_the_description() -> None:
    corners = [{"position_m": list(p), "speed_kn": 10} for p in [(0, 400), (300, 400), (500, 200)]]
    own = {"roll_deg": 8, "roll_period_s": 9, "speed_kn": 3}
    text = describe(scene([point("t", 0, 0, waypoints=corners, turn_radius_m=80, loop=True)], own_ship=own))
    assert "4 legs and 5 arcs, repeats every" in text  # the arc at the start is sailed half at a time
    assert "heading 000.0, rolling 8 degrees in 9 s, course" in text
    assert "roll, pitch, yaw" in str(rs.Simulator(scene(own_ship=own)).plan)


def test_several_radars_are_listed_with_their_platforms() -> None:
    made = load_scene(TWO_RADARS)
    text = describe(made.for_radar("pier"))
    assert (
        "radars      bow on tug\nradars      pier at east 100.0, north 0.0 m\n  all that follows is as pier has it\n" in text
    )
    assert "platform    at east 100.0, north 0.0, up 0.0 m, heading 090.0, at rest" in text and "120 rpm" in text
    assert "radars" not in describe(scene()) and "own ship    at east" in describe(scene())


def test_the_schema_takes_one_radar_or_a_list_of_them() -> None:
    schema = json_schema()
    for radar, valid in (
        (TWO_RADARS["radar"], True), ({"rpm": 24}, True), ([], True), ([{"rpm": 24}], False), ({"id": "bow"}, False),
        ([{"id": "a/b"}], False),
    ):  # fmt: skip
        assert jsonschema.Draft202012Validator(schema).is_valid(TWO_RADARS | {"radar": radar}) is valid


def test_errors_on_purpose_are_named() -> None:
    errors = {"profile": "imo-a823", "feed": {"drop_rate": 0.1}}
    assert "errors      on purpose, of gyro, log, antenna, feed\n" in describe(load_scene({"errors": errors}))
    assert "errors" not in describe(scene())


def test_it_says_when_a_body_is_there_how_it_sways_and_how_it_turns_at_last() -> None:
    fading = {"present": 5, "of": 10, "unit_s": 2.5}
    keys = {"start_s": 10, "end_s": 90, "fading": fading, "heave_m": 0.5, "roll_deg": 4, "turn_rate_deg_s": 3, "speed_kn": 5}
    text = describe(load_scene({"body": [{"name": "p", "shape": "point", "rcs_dbsm": 1, **keys}]}))
    assert "appears after 10 s, goes after 90 s, there in 5 of 10 times 2.5 s" in text
    assert "rolling 4 degrees in 10 s, heaving 0.5 m in 8 s" in text and "at last turning at 3 degrees/s" in text
