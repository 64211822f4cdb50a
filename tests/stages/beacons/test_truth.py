"""What the truth says of beacons: against the one-way equation, the profile that the engine makes, and JSON lines."""

import json
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.radar_feed import crossing_from_line
from tests.scenes import point, scene

LIGHT = 299_792_458.0
RADAR = {"range_max_m": 6000, "azimuths": 360, "beamwidth_deg": 4, "rpm": 24, "modulation": "none", "bandwidth_hz": 20e6,
         "pulse_s": 0.1e-6, "sample_rate_hz": 60e6}  # fmt: skip
FLAT = {"earth": "flat"}
RACON = point("racon", 3000, 0, racon={"letter": "K", "dot_s": 1e-6})
SART = point("sart", 0, -2000, rcs_dbsm=-50.0, sart={"start_s": 2.0})
WALL = {"name": "wall", "shape": "box", "length_m": 300, "width_m": 2, "height_m": 40, "position_m": [1500, 0, 0]}


def crossings(*bodies: dict[str, Any], scan: int = 0, radar: Any = None) -> dict[str, Any]:
    sim = rs.Simulator(scene([*bodies], radar=RADAR | (radar or {}), environment=FLAT))
    return {crossing.body: crossing for crossing in sim.crossings(scan)}


def test_a_racon_as_the_beam_meets_it() -> None:
    """74 dBm and 30 dBi over 121.46 dB of free space: -17.5 dBm there; its 30 dBm give -61.5 dBm back. The mark begins c/2 x
    (0.5 - 0.05) us behind the echo and is 9 dots of 149.9 m long."""
    beacon = crossings(RACON)["racon"].effects["beacon"]
    assert (beacon.kind, beacon.letters, beacon.triggered, beacon.carrier_offset) == ("racon", "K", True, 0.0)
    assert beacon.pulse_dbm == pytest.approx(73.979 + 30 - 121.46, abs=0.006)
    assert beacon.answer_dbm == pytest.approx(30 + 30 - 121.46, abs=0.006)
    assert beacon.begin == pytest.approx(3000 + LIGHT / 2 * 0.45e-6, abs=1e-3)
    assert beacon.dot == pytest.approx(LIGHT / 2 * 1e-6) and beacon.end == pytest.approx(beacon.begin + 9 * beacon.dot)
    assert beacon.first_dot is None and beacon.dot_spacing is None


def test_a_sart_as_it_is_switched_on() -> None:
    """At 2 s, in the second half of its first scan of 2.5 s: the beam meets it at 1.25 s."""
    before, after = (crossings(SART, scan=scan)["sart"].effects["beacon"] for scan in (0, 1))
    assert (before.triggered, after.triggered) == (False, True) and after.kind == "sart" and after.letters is None
    assert after.first_dot == pytest.approx(2000 + LIGHT / 2 * (0.45e-6 + 0.4e-6 + 7.5e-6 * 0.7), abs=1e-3)
    assert after.dot_spacing / 1852 == pytest.approx(0.64, abs=0.001)


@pytest.mark.parametrize(
    "radar, others", [({}, [WALL]), ({"blind_sectors_deg": [[80, 100]]}, []), ({"frequency_hz": 5e9}, [])]
)
def test_it_is_not_triggered(radar: dict[str, Any], others: list[dict[str, Any]]) -> None:
    """Behind a wall, in a blind sector, on another carrier; the engine then adds no answer either. Sidelobes do not reach it."""
    racon = RACON | {"racon": {"letter": "K", "sensitivity_dbm": -25.0}}
    made = scene([racon, *others], radar=RADAR | radar, environment=FLAT)
    sim = rs.Simulator(made, labels=True)
    assert not next(crossing for crossing in sim.crossings(0) if crossing.body == "racon").effects["beacon"].triggered
    assert not (sim.scan().labels == 5).any()


def test_truth_and_picture_agree() -> None:
    """The strongest cells labelled as the racon's begin and end where the truth has the mark, to two cells of 2.5 m, while
    own ship and buoy move."""
    racon = RACON | {"course_deg": 200, "speed_kn": 12}
    made = scene([racon], radar=RADAR, own_ship={"course_deg": 50, "speed_kn": 15}, environment=FLAT | {"noise": True})
    sim = rs.Simulator(made, labels=True)
    for _ in range(3):
        scan = sim.scan()
    crossing = sim.crossings(2)[0]
    spoke = crossing.spoke % 360
    where = (np.arange(scan.power.shape[1]) + 0.5) * made.radar.range_step
    cells = where[(scan.labels[spoke] == 5) & (scan.power[spoke] > 0.25 * scan.power[spoke][scan.labels[spoke] == 5].max())]
    assert cells.min() == pytest.approx(crossing.effects["beacon"].begin, abs=5.1) and cells.max() == pytest.approx(
        crossing.effects["beacon"].end, abs=5.1
    )


def test_lines_have_a_beacon_where_there_is_one() -> None:
    of_beacon, of_none = (crossings(body)[body["name"]] for body in (RACON, point("p", 3000, 0)))
    assert "beacon" not in of_none.as_dict() and crossing_from_line(json.loads(json.dumps(of_none.as_dict()))) == of_none
    line = json.loads(json.dumps(of_beacon.as_dict()))
    assert line["beacon"]["letters"] == "K" and crossing_from_line(line) == of_beacon
    assert crossing_from_line(line | {"hail": {"size": 3}}).effects == of_beacon.effects | {
        "hail": {"size": 3}
    }  # not installed
