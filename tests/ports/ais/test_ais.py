"""The stream of AIS: each report is the truth of the second that it names, to half of its last bit."""

import asyncio
import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pyais
import pytest

from radar_service.ports.ais.ais_port import AisPort
from radar_service.ports.ais.transponders import AisReport, Transponders
from radar_service.ports.port import Service
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.station import Station
from radar_service.simulator import Simulator
from tests.ports.ais.test_messages import KNOT, PARTS, near, parts
from tests.ports.kept import Kept
from tests.ports.nmea.test_nmea_port import SITES, Replaced, on_the_air, simulator_of, stations_of
from tests.reference.true_north import true_deg
from tests.service.fake import RADAR, FakeEngine, factory

# ais_port: whose reports, when, and equal to the truth.
HULL = {"shape": "hull", "length_m": 120.0, "beam_m": 20.0, "height_m": 12.0}
CIRCLE = {"name": "circle", **HULL, "position_m": [800, 0, -4], "speed_kn": 12, "course_deg": 40, "turn_rate_deg_s": 1.2,
          "mmsi": 201, "ais": {"antenna_m": [-3.0, 25.0], "ship_type": 70, "call_sign": "abc1"}}  # fmt: skip
FAST = {
    "name": "fast",
    "shape": "point",
    "rcs_dbsm": 5,
    "position_m": [0, 900, 2],
    "speed_kn": 35,
    "course_deg": 275,
    "mmsi": 202,
}
YACHT = {"name": "yacht", "shape": "point", "rcs_dbsm": 0, "position_m": [500, 900, 2], "speed_kn": 6, "course_deg": 10,
         "mmsi": 203, "ais": {"class": "B-CS", "length_m": 11, "beam_m": 4}}  # fmt: skip
ANCHORED = {"name": "anchored", **HULL, "position_m": [-800, 0, -4], "heading_deg": 70, "mmsi": 204}
UNKNOWN = {"name": "rock", "shape": "point", "rcs_dbsm": 0, "position_m": [50, 90, 2]}
OWN = {"speed_kn": 15, "course_deg": 200, "mmsi": 200, "turn_rate_deg_s": -1.0, "ais": {"antenna_m": [2.0, -30.0]}}


def started(simulator: Any, **more: Any) -> tuple[AisPort, Kept]:
    kept = Kept()
    port = AisPort([kept], **more)
    port.check(on_the_air(**{"0": simulator}))
    asyncio.run(port.start(cast(Service, SimpleNamespace(stations=on_the_air(**{"0": simulator}), fork_server=None))))
    return port, kept


def run(simulator: Any, until: float = 120.0, step: float = 0.1) -> list[tuple[float, str, Any]]:
    """When each message came [s], its kind of sentence, and what pyais reads."""
    port, kept = started(simulator)
    came: list[tuple[float, str, Any]] = []
    for time in np.arange(0.0, until + step / 2, step).tolist():
        port.tick("0", time)
        came += [(time, *message) for message in messages(kept)]
        kept.pieces.clear()
    return came


def messages(kept: Kept) -> list[tuple[str, Any]]:
    result, parts = [], list[bytes]()
    for line in kept.pieces:
        parts.append(line)
        count, number = line.split(b",")[1:3]
        if count == number:
            result.append((line[3:6].decode(), pyais.decode(*parts)))
            parts = []
    return result


def world(**more: Any) -> Simulator:
    return simulator_of(OWN, **{"body": [CIRCLE, FAST, YACHT, ANCHORED, UNKNOWN], **more})


def antenna_of(simulator: Simulator, second: float, name: str | None, offset: tuple[float, float]) -> Any:
    """Where the antenna of a ship is, from the truth: latitude and longitude."""
    from radar_service.world.geo import geographic_from_map

    truth = simulator.truth(second)
    body = truth.own_ship if name is None else next(each for each in truth.bodies if each.name == name)
    ahead, aside = (
        np.array([math.sin(body.heading), math.cos(body.heading)]),
        np.array([math.cos(body.heading), -math.sin(body.heading)]),
    )
    assert simulator.scene.origin is not None
    return body, geographic_from_map(
        np.array(body.position[:2]) + offset[1] * ahead + offset[0] * aside, simulator.scene.origin
    )


@pytest.mark.parametrize("origin", [(50.0, -1.0), (-20.0, 180.0), (89.0, 12.0)])
def test_each_report_is_the_truth_of_its_second(origin: tuple[float, float]) -> None:
    simulator = simulator_of(OWN, origin, body=[CIRCLE, FAST, YACHT, ANCHORED, UNKNOWN],
                             environment={"current_kn": 2, "current_to_deg": 90})  # fmt: skip
    came = run(simulator, 20.0)
    names = {200: None, 201: "circle", 202: "fast", 203: "yacht", 204: "anchored"}
    offsets = {200: (2.0, -30.0), 201: (-3.0, 25.0)}
    kinds = {"VDM": {201, 202, 203, 204}, "VDO": {200}}
    checked = set()
    for time, kind, message in came:
        mmsi = int(message.mmsi)
        assert mmsi in kinds[kind]
        if message.msg_type not in (1, 18):
            continue
        second = next(s for s in range(math.floor(time + 1e-6), -1, -1) if (30 + s) % 60 == message.second)
        assert 0.0 <= time - second < 1.0 or kind == "VDO"
        body, (latitude, longitude) = antenna_of(simulator, float(second), names[mmsi], offsets.get(mmsi, (0.0, 0.0)))
        near(parts(message.lat), latitude * PARTS, 1.0)
        near(parts(message.lon), longitude * PARTS, 1.0, 360.0 * PARTS)
        near(message.speed, body.speed / KNOT, 0.1)
        near(message.course, true_deg(body.course, body.position, origin), 0.1, 360.0)
        near(message.heading, true_deg(body.heading, body.position, origin), 1.0, 360.0)
        checked.add(mmsi)
    assert checked >= {200, 201, 202}


def test_intervals_and_static_reports() -> None:
    """Class A that turns at 12 knots reports 36 times in two minutes, one at 35 knots 60 times, a yacht four times."""
    came = run(world(), 120.0)
    counts = {
        mmsi: sum(int(m.mmsi) == mmsi and m.msg_type in (1, 18) for _, kind, m in came if kind == "VDM")
        for mmsi in range(200, 206)
    }
    assert counts[201] in (36, 37) and counts[202] in (60, 61) and counts[203] in (4, 5) and counts[204] in (0, 1)
    assert counts[200] == counts[205] == 0
    vdo = [m for _, kind, m in came if kind == "VDO" and m.msg_type == 1]
    assert len(vdo) == 121 and {m.second for m in vdo} == set(range(60))
    static = {int(m.mmsi): m for _, _, m in came if m.msg_type == 5}
    assert set(static) == {200, 201, 202, 204} and [m.msg_type for _, _, m in came].count(24) == 2
    circle, anchored = static[201], static[204]
    assert (circle.shipname, circle.callsign, circle.ship_type, circle.draught) == ("CIRCLE", "ABC1", 70, 4.0)
    assert (circle.to_bow, circle.to_stern, circle.to_port, circle.to_starboard) == (35, 85, 7, 13)
    assert (anchored.to_bow, anchored.to_stern, anchored.to_port, anchored.to_starboard) == (60, 60, 10, 10)
    (rest,) = [m for _, _, m in came if m.msg_type == 24 and m.partno == 1]
    assert (rest.to_bow + rest.to_stern, rest.to_port + rest.to_starboard) == (12, 4)  # two halves of 11 m, rounded


def test_both_parts_of_a_static_report_go_on_one_channel() -> None:
    """Receivers, as gpsd, pair the parts of type 24 channel by channel."""
    port, kept = started(world(body=[{**YACHT, "name": f"yacht {k}", "mmsi": 300 + k} for k in range(5)]))
    for time in np.arange(0.0, 61.0, 0.1).tolist():
        port.tick("0", time)
    channels: dict[int, list[str]] = {}
    for line in kept.pieces:
        message = pyais.decode(line) if line.split(b",")[1] == b"1" else None
        if message is not None and message.msg_type == 24:
            channels.setdefault(int(message.mmsi), []).append(line.split(b",")[4].decode())
    assert set(channels) == {300, 301, 302, 303, 304} and all(a == b for a, b in channels.values())
    assert {line.split(b",")[4] for line in kept.pieces} == {b"A", b"B"}


def test_the_kind_of_a_body_decides_what_it_sends() -> None:
    buoy = {**YACHT, "name": "buoy", "speed_kn": 0, "mmsi": 992350001, "ais": {"kind": "aid", "aid_type": 30}}
    raft = {**YACHT, "name": "raft", "mmsi": 970010001, "ais": {"kind": "sart"}}
    boat = {**YACHT, "name": "boat", "mmsi": 2110000}
    came = run(simulator_of({}, body=[buoy, raft, boat]), 190.0)
    types = {mmsi: {m.msg_type for _, _, m in came if int(m.mmsi) == mmsi} for mmsi in (992350001, 970010001, 2110000)}
    assert types == {992350001: {21}, 970010001: {1, 14}, 2110000: {18, 24}}
    assert {m.status for _, _, m in came if m.msg_type == 1} == {14}
    assert {m.text for _, _, m in came if m.msg_type == 14} == {"SART ACTIVE"}


def test_latency_and_silence() -> None:
    silent = {**FAST, "ais": {"off_s": [[10.0, 20.0]], "heading_error_deg": 90.0}}
    came = run(simulator_of({}, body=[silent], ais={"latency_s": 3.0}), 30.0)
    reports = [(time, m) for time, _, m in came if m.msg_type == 1]
    for time, message in reports:
        assert 3.0 < time - (message.second - 30) % 60 < 4.0 and message.heading == (275 + 90) % 360
    seconds = [(m.second - 30) % 60 for _, m in reports]
    assert seconds and not [second for second in seconds if 10 <= second < 20] and max(seconds) > 20 > 10 > min(seconds)


def test_losses_and_position_errors_follow_the_seed() -> None:
    """60 % of some 300 messages, within 4 sigma; the errors have their standard deviation within 4 of its own."""
    scene = {"body": [FAST], "ais": {"loss_percent": 40.0, "position_error_m": 50.0}}
    first, again = (run(simulator_of({}, **scene), 600.0, 1.0) for _ in range(2))
    assert [str(m) for *_, m in first] == [str(m) for *_, m in again]
    reports = [m for *_, m in first if m.msg_type == 1]
    assert abs(len(reports) - 180) < 4 * math.sqrt(300 * 0.4 * 0.6)
    simulator, errors, second = simulator_of({}, **scene), [], -1
    for message in reports:
        second = next(s for s in range(second + 1, second + 61) if (s + 30) % 60 == message.second)
        latitude = simulator.truth(float(second)).bodies[0].latitude_deg
        assert latitude is not None
        errors.append((message.lat - latitude) * 111_200)
    assert np.std(errors) == pytest.approx(50.0, rel=4 / math.sqrt(2 * len(errors)))


def test_an_absent_ship_and_a_scene_without_origin() -> None:
    came = run(simulator_of({}, None, body=[{**FAST, "start_s": 15}]), 30.0)
    reports = [(time, m) for time, _, m in came if m.msg_type == 1]
    assert reports and min(time for time, _ in reports) > 15.0
    assert {(m.lat, m.lon) for _, m in reports} == {(91.0, 181.0)}


def test_own_ship_that_is_a_body_is_no_other_ship() -> None:
    came = run(simulator_of({"body": "fast"}, body=[FAST, CIRCLE]), 20.0)
    assert {(kind, int(m.mmsi)) for _, kind, m in came} == {("VDO", 202), ("VDM", 201)}


@pytest.mark.parametrize(
    ("radar", "expected"), [("bow", {("VDO", 201), ("VDM", 202)}), ("pier", {("VDM", 202)}), ("ferry", {("VDO", 202)})]
)
def test_own_ship_that_is_no_body_is_in_the_world_of_its_own_radars_alone(
    radar: str, expected: set[tuple[str, int]]
) -> None:
    """A fixed site has no transponder, and a ferry is not own ship: neither tells own ship's number with its own position."""
    kept = Kept()
    port = AisPort([kept], radar)
    asyncio.run(port.start(cast(Service, SimpleNamespace(stations=stations_of(SITES), fork_server=None))))
    for time in np.arange(0.0, 30.0, 0.5).tolist():
        port.tick(radar, time)
    assert {(kind, int(m.mmsi)) for kind, m in messages(kept)} == expected


def test_a_pause_repeats_own_ship_alone() -> None:
    port, kept = started(world())
    for time in (0.0, 1.0):
        port.tick("0", time)
    kept.pieces.clear()
    for _ in range(40):
        port.tick("0", 1.0)
    assert [(kind, m.msg_type) for kind, m in messages(kept) if m.msg_type == 1] == [("VDO", 1)] * 4


def test_another_scene_begins_anew() -> None:
    port, kept = started(world())
    port.tick("0", 30.0)
    kept.pieces.clear()
    for time in np.arange(0.0, 20.0, 0.1).tolist():
        port.tick("0", time)
    assert {int(m.mmsi) for _, m in messages(kept)} >= {200, 201, 202}


def test_reports_that_a_replaced_process_missed_come_later() -> None:
    assert [m.second for _, kind, m in run(Replaced(world()), 3.0) if kind == "VDO" and m.msg_type == 1] == [30, 31, 32, 33]


# transponders: reports before they are encoded.
ORIGIN = (54.0, 8.0)


def station(**ais: Any) -> Station:
    """A ship of 12 knots to the north and one at anchor, both with a transponder, and a buoy without."""
    ship = {"name": "ship", "shape": "point", "rcs_dbsm": 20, "mmsi": 211000001, "course_deg": 0, "speed_kn": 12}
    moored = {"name": "moored", "shape": "point", "rcs_dbsm": 20, "position_m": [0, 120, 0], "mmsi": 211000002}
    buoy = {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [50, 50, 0]}
    origin = {"latitude_deg": ORIGIN[0], "longitude_deg": ORIGIN[1]}
    of = load_scene({"radar": RADAR, "origin": origin, "body": [ship, moored, buoy], **({"ais": ais} if ais else {})})
    return Station("0", FakeEngine(of), factory())


def heard(of: Station, until: float, transponders: Transponders | None = None) -> list[tuple[float, AisReport]]:
    """The reports of the time from 0 on, tenth by tenth."""
    transponders = transponders or Transponders()
    times = np.arange(0.0, until, 0.1).tolist()
    return [(time, report) for time in times for report in transponders.due(of, time)]


def test_a_ship_at_anchor_reports_each_three_minutes_and_a_buoy_never() -> None:
    reports = heard(station(), 400.0)
    assert {each.ship.mmsi for _, each in reports} == {211000001, 211000002}
    times = [time for time, each in reports if each.ship.mmsi == 211000002 and each.position]
    assert len(times) in (2, 3) and np.diff(times) == pytest.approx(180.0, abs=1e-6)


def test_what_was_sent_is_not_sent_again_while_time_stands_a_rounding_before_a_tenth() -> None:
    """A spoke's time is a sum: 57.5 s may be a hair less."""
    of, transponders = station(), Transponders()
    assert heard(of, 57.0, transponders)
    transponders.due(of, time := np.nextafter(57.5, 0.0))
    assert [transponders.due(of, time) for _ in range(3)] == [[], [], []]
