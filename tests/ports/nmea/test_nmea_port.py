"""The stream of own ship: each number that is read is the truth of its instant, to half of its last digit."""

import asyncio
import json
import math
import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pynmea2
import pytest
from pyproj import Geod

from radar_service.commands.command_line import parser
from radar_service.errors.reporter import ErrorReporter
from radar_service.ports.nmea.nmea_port import MAX_LATE, TENTHS, NmeaPort, SentenceSchedule
from radar_service.ports.port import Service
from radar_service.records.reports import Readings
from radar_service.scene_file.describe import json_schema
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.error_stage import ErrorStage
from radar_service.service.radio.station import Station, Stations
from radar_service.simulator import Simulator
from radar_service.spoke_source import SpokeSourceFault
from radar_service.terminal.arguments import UsageError
from radar_service.world.geo import geographic_from_map
from tests.ports.kept import Kept
from tests.ports.nmea.reading import fields_of
from tests.ports.playing import PAUSED, play
from tests.reference.true_north import true_deg

KNOT = 1852.0 / 3600.0
START = datetime(2026, 12, 31, 23, 59, 30, tzinfo=UTC)
ROUNDING = 1e-7  # beside half a digit: of decimal numbers
RADAR = {"azimuths": 8, "range_max_m": 500, "coarse_azimuths": True}
STREAM = {"current_kn": 2.5, "current_to_deg": 70}
TURNING = {"course_deg": 100, "speed_kn": 14, "manoeuvre": [
    {"time_s": 5, "turn_rate_deg_s": 3.0}, {"time_s": 25, "course_deg": 10, "turn_rate_deg_s": 1.5},
    {"time_s": 40, "speed_kn": 3},
]}  # fmt: skip


class OneStation:
    def __init__(self, simulator: Any, start: datetime = START, identity: str = "0") -> None:
        self.identity, self.start_utc, self.sensor_laws = identity, start, ErrorStage(simulator, []).laws_at
        self.epoch = SimpleNamespace(info=simulator.info, spoke_source=simulator)
        self.transmitter = SimpleNamespace(state=SimpleNamespace(simulated=0.0))
        self.lacks: dict[str, str] = {}


SITES = {
    "origin": {"latitude_deg": 50.0, "longitude_deg": -1.0}, "environment": STREAM,
    "radar": [{**RADAR, "id": "bow"}, {**RADAR, "id": "pier", "platform": {"position_m": [60e3, -2000], "heading_deg": 77}},
              {**RADAR, "id": "ferry", "platform": {"body": "ferry"}}],
    "own_ship": {**TURNING, "mmsi": 201, "gnss_offset_m": [0.0, 50.0]},
    "body": [{"name": "ferry", "shape": "point", "rcs_dbsm": 60, "position_m": [60200, -1900, 5], "speed_kn": 5, "course_deg": 10,
              "mmsi": 202}],
}  # fmt: skip


def on_the_air(**simulators: Any) -> Stations:
    return Stations(cast(Station, OneStation(simulator, identity=name)) for name, simulator in simulators.items())


def stations_of(scene: dict[str, Any]) -> Stations:
    loaded = load_scene(scene)
    return on_the_air(**{radar: Simulator(loaded, fidelity="fast", radar=radar) for radar in loaded.radar_ids})


def test_a_fixed_site_has_a_stream_of_its_own() -> None:
    """`--nmea-of` a site: its place, not that of own ship; the stream passes it. And of a body, without own ship's antenna."""
    stations, kept = stations_of(SITES), {name: Kept() for name in ("pier", "ferry")}
    for name, sender in kept.items():
        port = NmeaPort([sender], name, tells_truth=True)
        asyncio.run(port.start(cast(Service, SimpleNamespace(stations=stations, fork_server=None))))
        port.tick("bow", 5.0)
        assert not sender.pieces
        port.tick(name, 5.0)
    pier, ferry = (parsed(kept[name].pieces, "RMC")[5] for name in kept)
    latitude, longitude = geographic_from_map(np.array([60e3, -2000.0]), (50.0, -1.0))
    for message in (pier, parsed(kept["pier"].pieces, "GGA")[5]):
        close(message.latitude, latitude, 1e-5 / 60)
        close(message.longitude, longitude, 1e-5 / 60)
    north = true_deg(0.0, [60e3, -2000.0], (50.0, -1.0))
    assert {str(message.heading) for message in parsed(kept["pier"].pieces, "HDT")} == {f"{77.0 + north:.2f}"}
    assert {message.spd_over_grnd for message in parsed(kept["pier"].pieces, "RMC")} == {0.0}
    vbw = parsed(kept["pier"].pieces, "VBW")[0]
    close(vbw.lon_water_spd, -2.5 * math.cos(math.radians(70 - 77)), 0.01)
    assert {float(message.rate_of_turn) for message in parsed(kept["pier"].pieces, "ROT")} == {0.0}
    assert [message.name for message in parsed(kept["pier"].pieces, "TTM")] == ["TRUTH ferry"]
    truth = stations["ferry"].epoch.spoke_source.truth(5.0).own_ship  # of the ferry, without own ship's antenna
    close(ferry.latitude, truth.latitude_deg, 1e-5 / 60)
    close(ferry.longitude, truth.longitude_deg, 1e-5 / 60)
    close(ferry.spd_over_grnd, 5.0, 0.01)


def started(simulator: Any, radar: str | None = None, tells_truth: bool = False) -> tuple[NmeaPort, Kept]:
    kept = Kept()
    port = NmeaPort([kept], radar, tells_truth)
    service = SimpleNamespace(stations=on_the_air(**{"0": simulator}), fork_server=None)
    port.check(service.stations)
    asyncio.run(port.start(cast(Service, service)))
    return port, kept


def simulator_of(own: dict[str, Any], origin: tuple[float, float] | None = (50.0, -1.0), **more: Any) -> Simulator:
    place = {} if origin is None else {"origin": {"latitude_deg": origin[0], "longitude_deg": origin[1]}}
    return Simulator(load_scene({"radar": RADAR, "own_ship": own, **place, **more}), fidelity="fast")


def parsed(lines: Sequence[bytes], kind: str) -> list[Any]:
    return [pynmea2.parse(line.decode().strip(), check=True) for line in lines if line[3:6] == kind.encode()]


def seconds_of(message: Any) -> float:
    """Simulated time of a sentence with a clock; the year ends at 30 s."""
    of_day = message.timestamp.hour * 3600 + message.timestamp.minute * 60 + message.timestamp.second
    return float((of_day - (23 * 3600 + 59 * 60 + 30)) % 86400)


def close(given: Any, expected: float, digit: float, turn: float = 0.0) -> None:
    difference = float(given) - expected
    difference = math.remainder(difference, turn) if turn else difference
    assert abs(difference) <= 0.5 * digit + ROUNDING, (given, expected)


SCENES: dict[str, tuple[dict[str, Any], tuple[float, float], dict[str, Any]]] = {
    "turns": (TURNING, (50.0, -1.0), {}),
    "stream": ({**TURNING, "drift_deg": 4.0}, (50.0, -1.0), {"environment": STREAM}),
    "antimeridian": ({"course_deg": 90, "speed_kn": 40, "position_m": [-600, 0]}, (-20.0, 180.0), {}),
    "89 north": ({"course_deg": 300, "speed_kn": 25, "yaw_deg": 3}, (89.0, 12.0), {"environment": STREAM}),
    "equator": ({"course_deg": 215, "speed_kn": 12, "position_m": [100, 100]}, (0.0, 0.0), {}),
    "far from the origin": ({**TURNING, "position_m": [9000, 4000]}, (89.0, 12.0), {}),
    "at rest": ({"heading_deg": 359.999}, (50.0, -1.0), {"environment": STREAM}),
}


@pytest.mark.parametrize("name", SCENES)
def test_each_number_is_the_truth_of_its_instant(name: str) -> None:
    own, origin, more = SCENES[name]
    simulator = simulator_of(own, origin, **more)
    port, kept = started(simulator)
    for time in np.arange(0.0, 60.0, 0.26):
        port.tick("0", float(time))
    hdt, ths = parsed(kept.pieces, "HDT"), [fields_of(line)[1] for line in kept.pieces if line[3:6] == b"THS"]
    assert len(hdt) == len(ths) == 599  # up to 59.8 s
    for k in range(0, 598, 7):
        truth = simulator.truth(k / 10).own_ship
        heading = true_deg(truth.heading, truth.position, origin)
        close(hdt[k].heading, heading, 0.01, 360.0)
        close(ths[k][0], heading, 0.01, 360.0)
    groups = [parsed(kept.pieces, kind) for kind in ("ZDA", "RMC", "GGA", "VTG", "ROT", "VBW", "VHW")]
    assert {len(group) for group in groups} == {60}
    for k, (zda, rmc, gga, vtg, rot, vbw, vhw) in enumerate(zip(*groups, strict=True)):
        truth = simulator.truth(float(k)).own_ship
        utc = START + timedelta(seconds=k)
        assert rmc.datetime == utc and (zda.day, zda.month, zda.year) == (utc.day, utc.month, utc.year)
        assert (zda.timestamp, gga.timestamp) == (utc.timetz(), utc.timetz())
        assert truth.latitude_deg is not None and truth.longitude_deg is not None
        for message in (rmc, gga):
            close(message.latitude, truth.latitude_deg, 1e-5 / 60)
            close(message.longitude, truth.longitude_deg, 1e-5 / 60, 360.0)
        close(vtg.spd_over_grnd_kts, truth.speed / KNOT, 0.01)
        close(rmc.spd_over_grnd, truth.speed / KNOT, 0.01)
        close(vtg.true_track, true_deg(truth.course, truth.position, origin), 0.01, 360.0)
        close(rmc.true_course, true_deg(truth.course, truth.position, origin), 0.01, 360.0)
        close(rot.rate_of_turn, 60 * math.degrees(simulator.ship_states([float(k)])[0].turn_rate[0]), 0.01)
        velocity = np.array(truth.velocity[:2])
        stream = simulator.scene.environment.stream
        ahead = np.array([math.sin(truth.heading), math.cos(truth.heading)])
        aside = np.array([math.cos(truth.heading), -math.sin(truth.heading)])
        expected = [v @ axis / KNOT for v in (velocity - stream, velocity) for axis in (ahead, aside)]
        for given, value in zip(vbw.data[:2] + vbw.data[3:5], expected, strict=True):
            close(given, value, 0.01)
        close(vhw.water_speed_knots, expected[0], 0.01)
        close(vhw.heading_true, true_deg(truth.heading, truth.position, origin), 0.01, 360.0)


@pytest.mark.parametrize("origin", [(89.0, 12.0), (50.0, -1.0), (-70.0, 180.0)])
@pytest.mark.parametrize("place", [(8000.0, -3000.0), (60e3, 80e3)])
def test_the_course_is_that_from_one_position_to_the_next(origin: tuple[float, float], place: tuple[float, float]) -> None:
    """By geodesics between positions 10 s apart at 30 knots, 154 m. A position is off by 9 mm to each side, which is 0.007
    degrees of their direction, beside half of a digit. Headings and bearings of targets count from the same north."""
    body = {"name": "far", "shape": "point", "rcs_dbsm": 60, "position_m": [place[0] + 300.0, place[1] + 50.0, 5]}
    own = {"position_m": place, "course_deg": 250, "speed_kn": 30, "heading_deg": 240}
    port, kept = started(simulator_of(own, origin, body=[body]), tells_truth=True)
    for time in (0.0, 5.0, 10.0):
        port.tick("0", time)
    rmc = {seconds_of(message): message for message in parsed(kept.pieces, "RMC")}
    first, middle, last = (rmc[time] for time in (0.0, 5.0, 10.0))
    earth = Geod(ellps="WGS84")
    to, back, distance = earth.inv(first.longitude, first.latitude, last.longitude, last.latitude)
    course = to + math.remainder(back + 180.0 - to, 360.0) / 2.0  # in the middle
    close(middle.true_course, course, 0.01 + 2 * 0.007, 360.0)
    close(parsed(kept.pieces, "HDT")[50].heading, course - 10.0, 0.01 + 2 * 0.007, 360.0)
    assert distance == pytest.approx(30 * KNOT * 10.0, abs=0.05)  # four times 9 mm, and a part in 10,000 of the map
    _, tll = fields_of([line for line in kept.pieces if line[3:6] == b"TLL"][1])
    latitude, longitude = (
        math.copysign(float(text[:-8]) + float(text[-8:]) / 60.0, {"N": 1, "E": 1}.get(side, -1))
        for text, side in (tll[1:3], tll[3:5])
    )
    to, _, distance = earth.inv(middle.longitude, middle.latitude, longitude, latitude)
    ttm = parsed(kept.pieces, "TTM")[1]
    close(ttm.bearing, to, 0.01 + 2 * math.degrees(0.018 / distance), 360.0)


def test_the_position_is_that_of_an_antenna_that_turns_with_her() -> None:
    """30 m abaft and 4 m to port of the middle, on a ship that turns; on a body that is own ship, too."""
    offset = {"gnss_offset_m": [-4.0, -30.0]}
    ship = {"name": "ship", "shape": "point", "rcs_dbsm": 0, **TURNING}
    for simulator in (simulator_of(TURNING | offset), simulator_of({"body": "ship"} | offset, body=[ship])):
        port, kept = started(simulator)
        for time in (0.0, 8.0, 16.0):
            port.tick("0", time)
        messages = {seconds_of(message): message for message in parsed(kept.pieces, "RMC")}
        for time in (0.0, 7.0, 8.0, 16.0):
            truth = simulator.truth(time).own_ship
            sine, cosine = math.sin(truth.heading), math.cos(truth.heading)
            antenna = np.array(truth.position[:2]) - 30.0 * np.array([sine, cosine]) - 4.0 * np.array([cosine, -sine])
            latitude, longitude = geographic_from_map(antenna, (50.0, -1.0))
            close(messages[time].latitude, latitude, 1e-5 / 60)
            close(messages[time].longitude, longitude, 1e-5 / 60)


def test_a_jump_by_a_command_is_followed_at_its_instant() -> None:
    simulator = simulator_of({"speed_kn": 5, "course_deg": 0, "steerable": {}})
    port, kept = started(simulator)
    port.tick("0", 2.0)
    simulator.command(spoke=10, position_m=[9000.0, -4000.0], heading_deg=123.0)  # at 3.125 s
    for _ in range(3):
        simulator.scan()
    port.tick("0", 5.0)
    messages = {seconds_of(message): message for message in parsed(kept.pieces, "GGA")}
    for time in (2.0, 3.0, 4.0, 5.0):
        truth = simulator.truth(time).own_ship
        close(messages[time].latitude, truth.latitude_deg or 0.0, 1e-5 / 60)
    assert abs(messages[4.0].latitude - messages[3.0].latitude) > 0.03
    headings = [float(message.heading) for message in parsed(kept.pieces, "HDT")][30:33]
    assert headings == [0.0, 0.0, round(true_deg(math.radians(123.0), [9000.0, -4000.0], (50.0, -1.0)), 2)]


ERRORS = {
    "gyro": {"bias_deg": 2.0, "noise_deg": 0.4, "latency_s": 1.0}, "log": {"scale_percent": 5.0, "noise_kn": 0.3},
    "position": {"bias_m": [30.0, -20.0], "noise_m": 5.0, "latency_s": 2.0},
}  # fmt: skip


def test_sensors_that_err_are_told_as_they_report() -> None:
    """An independent way to the report of a spoke: its number, its time, and the motion at earlier ones."""
    simulator = simulator_of(TURNING, environment=STREAM, errors=ERRORS)
    scene = simulator.scene
    port, kept = started(simulator)
    port.tick("0", 9.0)
    port.tick("0", 12.0)
    reporter = ErrorReporter(scene.radar, simulator.seed, scene.errors, stream=scene.environment.stream)
    laws = reporter.laws_at(0)
    assert laws is not None
    rmc = {seconds_of(message): message for message in parsed(kept.pieces, "RMC")}
    vbw, vhw = parsed(kept.pieces, "VBW"), parsed(kept.pieces, "VHW")
    for time in (6.0, 9.0, 12.0):
        number = np.array([math.floor(time / scene.radar.spoke_period)])

        def readings(times: np.ndarray) -> Readings:
            pose = scene.own_ship.pose(times)
            return Readings(np.zeros(len(times)), pose.heading, pose.position[:, :2], pose.course, pose.speed)

        reported = laws.reported(
            number, np.array([time]), readings(np.array([time])), lambda n: readings(n * scene.radar.spoke_period)
        )
        latitude, longitude = geographic_from_map(reported.position[0], (50.0, -1.0))
        close(rmc[time].latitude, latitude, 1e-5 / 60)
        close(rmc[time].longitude, longitude, 1e-5 / 60)
        place = scene.own_ship.pose(time).position[0]
        close(rmc[time].true_course, true_deg(reported.course[0], place, (50.0, -1.0)), 0.01, 360.0)
        close(rmc[time].spd_over_grnd, reported.speed[0] / KNOT, 0.01)
        close(vhw[int(time)].heading_true, true_deg(reported.heading[0], place, (50.0, -1.0)), 0.01, 360.0)
        truth = simulator.truth(time).own_ship
        assert truth.water_speed is not None
        error = reported.speed[0] - truth.speed
        close(
            vbw[int(time)].lon_water_spd, (truth.water_speed + error) / KNOT, 0.01
        )  # no leeway: the ship heads through the water
        assert abs(error) > 0.05  # far above the last digit
    assert abs(rmc[9.0].latitude - (simulator.truth(9.0).own_ship.latitude_deg or 0.0)) > 5e-5


def test_a_lost_heading_is_told_so() -> None:
    simulator = simulator_of(TURNING, errors={"feed": {"heading_lost_s": [[2.0, 4.0]]}})
    port, kept = started(simulator)
    port.tick("0", 5.0)
    assert len(parsed(kept.pieces, "HDT")) == 51 - 20
    ths = [fields_of(line)[1] for line in kept.pieces if line[3:6] == b"THS"]
    assert [fields == ["", "V"] for fields in ths] == [20 <= k < 40 for k in range(51)]
    assert [message.true_course for message in parsed(kept.pieces, "RMC")][2:4] == [None, None]
    assert [message.status for message in parsed(kept.pieces, "ROT")] == ["A", "A", "V", "V", "A", "A"]


def test_a_scene_without_an_origin_has_no_positions() -> None:
    port, kept = started(simulator_of(TURNING, None))
    port.tick("0", 3.0)
    assert not parsed(kept.pieces, "RMC") and not parsed(kept.pieces, "GGA") and len(parsed(kept.pieces, "VTG")) == 4


def test_a_radar_that_is_not_there_ends_the_start() -> None:
    with pytest.raises(UsageError, match="--nmea-of: aft is no radar of this service; it has 0"):
        started(simulator_of({}), "aft")


def test_another_radar_and_a_source_without_ships_say_nothing() -> None:
    port, kept = started(simulator_of({}))
    port.tick("1", 3.0)
    assert kept.pieces == []
    port.close()
    assert kept.pieces == [] and kept.closed


class Replaced:
    def __init__(self, simulator: Simulator) -> None:
        self.info, self._simulator, self.faults = simulator.info, simulator, 1

    def ship_states(self, *arguments: Any) -> Any:
        self.faults -= 1
        if self.faults >= 0:
            raise SpokeSourceFault("gone")
        return self._simulator.ship_states(*arguments)


def test_what_a_process_that_was_replaced_could_not_tell_comes_later() -> None:
    port, kept = started(Replaced(simulator_of(TURNING)))
    for time in (0.0, 0.1, 0.2, 1.1):
        port.tick("0", time)
    assert len(parsed(kept.pieces, "HDT")) == 12 and len(parsed(kept.pieces, "RMC")) == 2


def test_the_schedule_makes_up_for_late_calls_and_stands_in_a_pause() -> None:
    schedule = SentenceSchedule()
    assert schedule.due(0.0) == [(0, True)] and schedule.due(0.05) == []
    assert schedule.due(0.1 + 0.2) == [(1, False), (2, False), (3, False)]  # 0.30000000000000004
    assert schedule.due(1.05)[-1] == (10, True)
    held = [schedule.due(1.05) for _ in range(20)]
    assert held == ([[(10, False)]] * 9 + [[(10, True)]]) * 2
    assert schedule.due(1.1) == [(11, False)]
    assert [instant for instant, _ in schedule.due(1e6)] == list(range(10**7 - MAX_LATE + 1, 10**7 + 1))
    assert schedule.due(0.25) == [(0, True), (1, False), (2, False)]  # another scene
    assert MAX_LATE == 10 * TENTHS


def test_it_runs_in_a_pause_before_the_first_spoke() -> None:
    """With the clock of the ports, beside REST and the feed."""
    port = NmeaPort([kept := Kept()])
    port.period = 0.02  # s, and a tenth of the seconds' sentences

    async def test(server: Any) -> None:
        while len([line for line in kept.pieces if line[3:6] == b"ZDA"]) < 2:
            await asyncio.sleep(0.01)

    play(port, test, PAUSED)
    assert len({line for line in kept.pieces if line[3:6] == b"HDT"}) == 1
    assert kept.closed and len({line for line in kept.pieces if line[3:6] == b"ZDA"}) == 1


def options(*words: str) -> Any:
    return parser().parse_args(["serve", *words])


def test_scenes_open_no_ports() -> None:
    """A scene is a file, perhaps an upload: none of its keys names a port or an address."""
    text = json.dumps(json_schema())
    assert not re.search(r'"[a-z_]*(nmea|tcp|udp|socket)[a-z_]*":', text)


def test_sentences_that_do_not_go_out_are_counted() -> None:
    """As what the port has dropped, which the metrics have."""
    kept, counts = Kept(), []

    async def test(server: Any) -> None:
        while not kept.pieces:
            await asyncio.sleep(0.01)
        kept.lost = 7
        while not (dropped := [thread.dropped for thread in host[0] if thread.name == "nmea"])[0]:
            await asyncio.sleep(0.01)
        counts.extend(dropped)
        assert 'radar_port_dropped_total{port="nmea"} 7.0' in (await server.http.get("/metrics")).text

    class Counting(NmeaPort):
        async def start(self, service: Service) -> None:
            host.append(service.threads)
            await super().start(service)

    host: list[Any] = []
    play(Counting([kept]), test, PAUSED)
    assert counts == [7]


def test_hello_and_sentences_have_one_utc() -> None:
    """It follows simulated time from `--start-utc` on."""
    kept, ages = Kept(), []

    async def test(server: Any) -> None:
        station = server.stations[0]
        while not any(line[3:6] == b"ZDA" for line in kept.pieces):
            await asyncio.sleep(0.01)
        ages.append(station.radar_info(station.epoch).utc)

    play(NmeaPort([kept]), test, PAUSED, start_utc=START)
    (zda,) = {line for line in kept.pieces if line[3:6] == b"ZDA"}
    assert ages == [START] and fields_of(zda)[1][:4] == ["235930.00", "31", "12", "2026"]
    assert options("--start-utc", "2026-12-31T23:59:30").start_utc == START
