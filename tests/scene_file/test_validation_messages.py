"""Messages for bad values: key path, value, allowed range, remedy."""

import math
from typing import Any

import pytest

from tests.scene_file.scene_sources import point, problems

CORNERS = {"name": "h", "heightmap": "h.npy", "south_west_deg": [1, 1], "north_east_deg": [2, 2]}

# The form of every message: place, value, what is allowed, remedy.
ONE_PROBLEM: list[tuple[dict[str, Any], str]] = [
    ({"body": [point("a"), point("b"), point("c"), point("d", position_m=[0, math.nan, 0])]},
     "body[3].position_m[1]: nan is not allowed; a finite number from -2000000 to 2000000; give a finite number"),
    ({"body": [point(position_m=[0, 0, math.inf])]},
     "body[0].position_m[2]: inf is not allowed; a finite number from -11000"),
    ({"body": [point(position_m=[0, 0, -math.inf])]}, "body[0].position_m[2]: -inf is not allowed"),
    ({"body": [point(position_m=[0, 0])]}, "body[0].position_m[2]: missing; a finite number from -11000 to 20000; add it"),
    ({"body": [point(position_m=[0, 0, 0, 0])]}, "body[0].position_m: [0, 0, 0, 0] is not allowed; a list of 3 values"),
    ({"body": [point(position_m="here")]}, 'body[0].position_m: "here" is not allowed; a list of 3 values'),
    ({"body": [point(positon_m=[0, 0, 0])]},
     'body[0].positon_m: this is not a known key; did you mean "position_m"? (nearest of 67 keys: position_m, '),
    (
        {"zzz": 1},
        "zzz: this is not a known key; remove it, or install the package of the effect that has it (nearest of 10 keys: "
        "radar, own_ship, origin)",
    ),
    ({"radar": {"azimuths": 10**9}}, "radar.azimuths: 1000000000 is not allowed; a whole number from 4 to 16384; lower it"),
    ({"radar": {"azimuths": 10**400}}, "radar.azimuths: an integer of 1329 bits is not allowed; a whole number from 4"),
    ({"radar": {"azimuths": 720.5}}, "radar.azimuths: 720.5 is not allowed; a whole number"),
    ({"radar": {"azimuths": True}}, "radar.azimuths: true is not allowed; a whole number"),
    ({"radar": {"rpm": "24"}},
     'radar.rpm: "24" is not allowed; a finite number from 0.01 to 600; write the number without quotes'),
    ({"radar": {"rpm": -1}}, "radar.rpm: -1 is not allowed; a finite number from 0.01 to 600; raise it"),
    ({"radar": {"window": "hat"}}, 'radar.window: "hat" is not allowed; one of "none", "hamming"'),
    ({"radar": {"pattern": "x"}}, 'radar.pattern: "x" is not allowed; one of "sinc2"'),
    ({"radar": {"pattern": [[0, 0], [1, math.nan]]}}, "radar.pattern[1][1]: nan is not allowed; a finite number"),
    ({"radar": {"pattern": [[0, 0]]}}, "radar.pattern: a table has 2 to 10000 rows"),
    ({"radar": {"pattern": [[0, 0], [1, 1]]}}, "radar.pattern: gains are in dB below boresight"),
    ({"radar": {"labels_within_db": 0}},
     'radar.labels_within_db: 0 is not allowed; one of "none" or a finite number above 0 up to 200; raise it'),
    ({"radar": {"eclipsing": 1}}, "radar.eclipsing: 1 is not allowed; true or false"),
    ({"radar": {"range_max_m": 200_000}}, "radar.range_max_m: 200000 m at 7.5e+07 samples/s gives 100070 range bins"),
    ({"radar": {"azimuths": 16384, "range_max_m": 100_000}}, "radar.azimuths: 16384 x 50035 range bins are 819773440 cells"),
    ({"radar": {"pulse_s": 1e-3, "sample_rate_hz": 4e9}}, "radar.range_max_m"),
    ({"radar": {"pulse_s": 1e-3, "bandwidth_hz": 2e9, "range_max_m": 1000}}, "radar.pulse_s: 0.001 s at 3e+09 samples/s"),
    ({"radar": 5}, "radar: 5 is not allowed; a table with the keys modulation"),
    ({"environment": {"earth": -1}}, 'environment.earth: -1 is not allowed; one of "4/3", "flat" or a finite number above 0'),
    ({"environment": {"earth": "round"}}, 'environment.earth: "round" is not allowed; one of "4/3", "flat" or a finite'),
    ({"environment": {"gas_db_per_km": math.nan}}, 'environment.gas_db_per_km: nan is not allowed; one of "itu" or a finite'),
    ({"environment": {"gas_db_per_km": "itu"}, "radar": {"frequency_hz": 60e9}}, 'environment.gas_db_per_km: "itu" covers'),
    ({"environment": {"sea_state": 10}}, "environment.sea_state: 10 is not allowed; a finite number from 0 to 9; lower it"),
    ({"body": {}}, "body: a table of 0 keys is not allowed; a list of at most 10000 values"),
    ({"body": [5]}, "body[0]: 5 is not allowed; a table with the keys"),
    ({"body": [point(), point()]}, 'body[1].name: "p" is taken by an earlier body; names are unique'),
    ({"body": [{"shape": "point", "rcs_dbsm": 1}]}, "body[0].name: missing; text of 1 to 200 characters; add it"),
    ({"body": [point("")]}, 'body[0].name: "" is not allowed; text of 1 to 200 characters; lengthen it'),
    ({"body": [{"name": "a", "shape": "point"}]},
     "body[0].rcs_dbsm: a point has no surface; declare its radar cross-section"),
    ({"body": [{"name": "a", "shape": "sphere"}]}, 'body[0].radius_m: missing; shape = "sphere" needs radius_m: add it'),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": -1}]},
     "body[0].radius_m: -1 is not allowed; a finite number above 0 up"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 0}]},
     "body[0].radius_m: 0 is not allowed; a finite number above 0"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1e9}]}, "body[0].radius_m: 1000000000 is not allowed"),
    ({"body": [point(radius_m=1)]}, 'body[0].radius_m: shape = "point" takes no sizes; remove radius_m'),
    ({"body": [point(material="cheese")]}, 'body[0].material: "cheese" is not a known material; one of steel, aluminium'),
    ({"body": [point(scattering="optics")]}, 'body[0].rcs_dbsm: a declared cross-section excludes scattering = "optics"'),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1, "swerling": 1}]}, "body[0].swerling: fluctuation is defined"),
    ({"body": [{"name": "a", "shape": "sphere", "radius_m": 1, "scattering": "rcs"}]}, "body[0].rcs_dbsm: scattering"),
    ({"body": [point(latitude_deg=1.0)]}, "body[0].latitude_deg: this key needs latitude_deg and longitude_deg together"),
    ({"body": [point(latitude_deg=1.0, longitude_deg=1.0)]}, "body[0].latitude_deg: latitude and longitude need an [origin]"),
    ({"body": [point(latitude_deg=1.0, longitude_deg=1.0, position_m=[0, 0, 0])]}, "body[0].position_m: latitude_deg and"),
    ({"body": [point(latitude_deg=91.0, longitude_deg=1.0)]},
     "body[0].latitude_deg: 91 is not allowed; a finite number from -90"),
    ({"body": [point(up_m=1.0)]}, "body[0].up_m: this key needs latitude_deg"),
    ({"body": [point(course_deg=1, waypoints=[{"position_m": [1, 1], "speed_kn": 1}])]},
     "body[0].course_deg: waypoints already"),
    ({"body": [point(position_m=[0, 0, 0], track="t.csv")]}, "body[0].position_m: the track already defines the position"),
    ({"body": [point(waypoints=[{"position_m": [1, 1], "speed_kn": 0}])]}, "body[0].waypoints[0].speed_kn: 0 is not allowed"),
    ({"body": [point(waypoints=[{"position_m": [1, 1]}])]},
     "body[0].waypoints[0].speed_kn: missing; a finite number above 0"),
    ({"body": [{"name": "h", "heightmap": "h.png", "low_m": 5, "high_m": 5}]}, "body[0].high_m: 5 is not above low_m 5"),
    ({"body": [CORNERS | {"extent_m": [9, 9]}]},
     "body[0].extent_m: the corners south_west_deg and north_east_deg define it too"),
    ({"body": [CORNERS | {"north_east_deg": None}]}, "body[0].south_west_deg: this key needs north_east_deg"),
    ({"body": [CORNERS | {"position_m": [5, 0, 0]}]}, "body[0].south_west_deg: the corners already define the position"),
    ({"body": [CORNERS]}, "body[0].latitude_deg: latitude and longitude need an [origin]"),
    ({"own_ship": {"speed": 3}}, 'own_ship.speed: this is not a known key; did you mean "speed_kn"?'),
    ({"own_ship": {"track": "t.csv"}},
     'own_ship.track: "t.csv" is a file, but this scene came without a folder; pass folder='),
    ({"body": [{"name": "a", "mesh": "a.obj"}]}, 'body[0].mesh: "a.obj" is a file, but this scene came without a folder'),
    ({1: 2}, "1: this is not a known key"),
]  # fmt: skip


@pytest.mark.parametrize("source, message", ONE_PROBLEM)
def test_bad_scenes(source: dict[str, Any], message: str) -> None:
    result = problems(source)
    assert len(result) == 1, result
    assert result[0].startswith(message), result[0]
    assert len(result[0]) < 900 and "\n" not in result[0]


def test_a_mapping_that_holds_itself() -> None:
    data: dict[str, Any] = {}
    data["radar"] = data
    assert "nested more than 24 deep" in problems(data)[0]
