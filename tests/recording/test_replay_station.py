"""Replay: clients get the bytes that the recorded radar sent; what needs an engine is refused in a sentence."""

import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from radar_service import wire
from radar_service.commands.record import record_scans
from radar_service.ports.ais.ais_port import AisPort
from radar_service.ports.nmea.nmea_port import NmeaPort
from radar_service.ports.recorder.recorder_port import RecordingSink
from radar_service.recording import replay_station
from radar_service.recording.chunk_table import ChunkTable
from radar_service.recording.radar_recording import RadarRecording
from radar_service.recording.recording_file import RecordingFile
from radar_service.recording.replay_station import ReplaySpokeSource, ReplayStation, refuse
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.station import Station, Stations
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.simulator import Simulator
from radar_service.terminal.arguments import UsageError
from radar_service.world.commands import CommandError
from tests.ports.asgi import Closed
from tests.ports.kept import Kept
from tests.ports.playing import playing
from tests.recording.scenes import AZIMUTHS, MOVING, SEED, spokes_of
from tests.service.in_process import InProcess

FAST = Settings(pace=Pace("run", float("inf")))


async def feed(station: Station, query: str) -> list[dict[str, Any]]:
    """The spokes of three scans, as a lossless client of that station gets them."""
    async with playing(station) as server:
        socket, got, spokes = await server.feed(f"?mode=lossless&{query}"), list[bytes](), 0
        while spokes < 3 * AZIMUTHS:
            got.append(await socket.raw())
            spokes += wire.unpack(got[-1]).get("count", 0)
    return [spoke for spoke in spokes_of(got) if spoke["number"] < 3 * AZIMUTHS]


def replayed(path: Path, start: float = 0.0, **options: Any) -> ReplayStation:
    return ReplayStation("0", ReplaySpokeSource(path, "0", 0, start), refuse, settings=FAST, wait_for=1, **options)


@pytest.mark.parametrize(
    "query", ["encoding=c64", "encoding=f32", "encoding=f16", "encoding=u8-log&bins=40", "encoding=u8&sector=10,200"]
)
async def test_a_client_gets_the_bytes_that_the_radar_sent(query: str, recording: Path) -> None:
    live = Station("0", InProcess(SceneRequest(MOVING), "balanced", SEED), refuse, settings=FAST, wait_for=1)
    sent, again = await feed(live, query), await feed(replayed(recording), query)
    assert len(sent) > 3 * AZIMUTHS / 4 and any(spoke["blind"] for spoke in sent)
    assert again == sent


@pytest.mark.parametrize("query", ["encoding=f32&labels=1&powers=all", "encoding=u8&bins=40&labels=1&compress=zstd"])
async def test_labels_and_powers_are_replayed(query: str, labelled_recording: Path) -> None:
    live = Station(
        "0", InProcess(SceneRequest(MOVING), "balanced", SEED), refuse, settings=FAST, wait_for=1, allow_truth=True
    )  # fmt: skip
    query = query.replace("powers=all", "powers=256,257")
    sent, again = await told(live, query), await told(replayed(labelled_recording, allow_truth=True), query)
    assert len(sent) == 3 * AZIMUTHS and again == sent


async def told(station: Station, query: str) -> list[tuple[bytes, ...]]:
    """Samples, labels and powers of each spoke of three scans, as a lossless client gets them."""
    async with playing(station) as server:
        socket, got = await server.feed(f"?mode=lossless&{query}"), list[tuple[bytes, ...]]()
        while len(got) < 3 * AZIMUTHS:
            message = await socket.receive()
            if message["type"] == "spokes":
                arrays = [wire.samples(message), wire.labels(message), *(wire.powers(message) or {}).values()]
                got += [tuple(array[k].tobytes() for array in arrays if array is not None) for k in range(message["count"])]
            else:
                assert message["sources"][-1] == {"number": 257, "name": "b"}
        return got[: 3 * AZIMUTHS]


@pytest.mark.parametrize(("query", "reason"), [("labels=1", "labels: the recording has none"),
                                               ("powers=all", "powers: the recording has none")])  # fmt: skip
async def test_labels_that_are_not_recorded_are_refused(query: str, reason: str, recording: Path) -> None:
    async with playing(replayed(recording, allow_truth=True)) as server:
        assert reason in (await (await server.feed(f"?{query}")).receive())["reason"]


@pytest.mark.parametrize("others_are_over", [True, False])
async def test_a_replay_begins_where_it_is_told_and_ends_with_a_reason(recording: Path, others_are_over: bool) -> None:
    """The service ends with the last radar."""
    station, other = replayed(recording, 2.0), ReplaySpokeSource(recording, "0", 0)
    assert isinstance(source := station.epoch.spoke_source, ReplaySpokeSource)
    other.is_over, source.together = others_are_over, (source, other)
    ended = []
    station.failed = lambda: ended.append(True)
    async with playing(station) as server:
        socket = await server.feed("?mode=lossless&encoding=c64")
        first = await socket.until("spokes")
        assert first["first"] == 0 and first["time"][0] >= 2.0 > first["time"][0] - 60 / 33 / AZIMUTHS
        assert (await socket.until("bye"))["reason"] == "the radar has stopped: the recording has ended"
    assert ended == [True] * others_are_over and source.has_ended


async def test_a_damaged_chunk_ends_the_replay_with_its_place(recording: Path, tmp_path: Path) -> None:
    data, place = bytearray(recording.read_bytes()), ChunkTable(recording).chunks[1]
    data[place.offset + place.length // 2] ^= 0xFF
    (path := tmp_path / "damaged.mcap").write_bytes(data)
    station = replayed(path)
    async with playing(station) as server:
        socket = await server.feed("?mode=lossless")
        reason = (await socket.until("bye"))["reason"]
        assert reason.startswith(f"the radar has stopped: {path}: the chunk at byte {place.offset} is damaged")
    assert isinstance(station.epoch.spoke_source, ReplaySpokeSource) and not station.epoch.spoke_source.has_ended


async def test_what_needs_an_engine_is_refused_and_the_replay_goes_on(recording: Path) -> None:
    async with playing(replayed(recording, allow_truth=True)) as server:
        refused = [
            await server.http.put("/api/radars/0/scene", json={"scene": "harbour"}),
            await server.http.patch("/api/radars/0/controls", json={"rpm": 20}),
        ]
        for answer in refused:
            assert answer.status_code == 422 and "this radar replays a recording" in answer.json()["detail"][0]
        answer = await server.http.get("/api/radars/0/truth")
        assert answer.status_code == 422 and "the truth of beam crossings" in answer.json()["detail"][0]
        with pytest.raises(Closed):
            await (await server.feed("?truth=1")).until("hello")
        assert (await server.http.patch("/api/radars/0/controls", json={"gain": 60})).status_code == 200
        present = (await server.http.get("/api/radars/0")).json()["controls"]
        same = await server.http.patch("/api/radars/0/controls", json={"rpm": present["rpm"], "range_m": present["range_m"]})
        assert same.status_code == 200 and same.json() == present
        assert (await server.http.get("/api/radars/0")).json()["scene"]["name"] == "two ships"
        lines = await server.open("/api/radars/0/truth/stream")
        assert json.loads(await lines.text())["type"] == "header"
        socket = await server.feed("?mode=lossless")
        await socket.spokes(AZIMUTHS)
        assert {json.loads(await lines.text())["type"] for _ in range(3)} == {"crossing", "snapshot"}


def test_the_display_starts_with_the_recorded_controls(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = ReplaySpokeSource(recording)
    monkeypatch.setitem(source.record["controls"], "gain", 71)
    for name, value in (("rpm", 3), ("transmit", False)):  # are no controls of the display
        monkeypatch.setitem(source.record["controls"], name, value)
    monkeypatch.setitem(source.record["controls"], "range_m", 20.0)  # the recording has no cells beyond
    station = ReplayStation("0", source, refuse, settings=FAST)
    assert station.settings == replace(FAST, range=20.0, video=replace(FAST.video, gain=71))


async def test_a_recording_of_a_steered_radar_is_served_whole_and_is_not_steered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a ship with more commands than a motion remembers the states would be wrong."""
    scene = {**MOVING, "own_ship": {**MOVING["own_ship"], "steerable": {}}}
    steered = Simulator(load_scene(scene), "fast", 1)
    steered.command(spoke=20, course_deg=90)
    steered.command(spoke=100, speed_kn=15)
    with RecordingFile(tmp_path / "steered.mcap") as file:
        record_scans(RadarRecording(file, "0", False), steered, scene, 3, False)
    for most, reason in ((3, ""), (2, "commands: own ship has 2; at most 1 are replayed; record fewer")):
        monkeypatch.setattr(replay_station, "MAX_SEGMENTS", most)
        (source := ReplaySpokeSource(tmp_path / "steered.mcap")).make_scene_again(tmp_path)
        assert source.no_ships.removeprefix("the recorded scene cannot be built again: ") == reason
    station = replayed(tmp_path / "steered.mcap")
    async with playing(station) as server:
        with pytest.raises(CommandError, match="replays a recording; nothing is steered"):
            await station.commands.command(None, lambda time: {"speed_kn": 1.0})
        socket = await server.feed("?mode=lossless&encoding=f32")
        got = [await socket.raw() for _ in range(3 * AZIMUTHS // 32 + 1)]
    assert [spoke["number"] for spoke in spokes_of(got)] == list(range(3 * AZIMUTHS))


SHIPS: dict[str, Any] = {
    **MOVING, "environment": {"current_kn": 2, "current_to_deg": 70},
    "ais": {"latency_s": 1.3, "loss_percent": 20, "position_error_m": 5},
    "own_ship": {**MOVING["own_ship"], "mmsi": 235000001, "gnss_offset_m": [2, 30], "steerable": {}},
    "errors": {"profile": "imo-2004", "gyro": {"noise_deg": 0.3, "latency_s": 0.4}, "position": {"noise_m": 4, "latency_s": 0.7}},
    "body": [{**MOVING["body"][0], "mmsi": 235000002, "steerable": {}},
             {**MOVING["body"][1], "mmsi": 235000003, "ais": {"class": "B-SO"}}],
}  # fmt: skip


async def sentences(station: Station, begin: int, end: int) -> list[list[bytes]]:
    """What the ports of NMEA and AIS send from one tenth of a second to another."""
    service: Any = SimpleNamespace(stations=Stations([station]))
    kept = Kept(), Kept()
    for port in (NmeaPort([kept[0]]), AisPort([kept[1]])):
        port.check(service.stations)
        port.begins = begin / 10
        await port.start(service)
        for tenth in range(begin, end):
            port.tick("0", tenth / 10)
    return [sender.pieces for sender in kept]


async def test_nmea_and_ais_of_a_replay_are_those_of_the_live_radar(tmp_path: Path) -> None:
    """With commands to two ships, sensor errors that change, lost AIS reports; also from the middle on."""
    with RecordingFile(path := tmp_path / "live.mcap") as file:
        recording = RadarRecording(file, "0", False)
        sink = RecordingSink(lambda: recording, lambda work: work.do())
        options: dict[str, Any] = {"settings": FAST, "start_utc": datetime(2026, 12, 31, 23, 59, tzinfo=UTC)}
        live = Station("0", InProcess(SceneRequest(SHIPS), "fast", SEED), refuse, wait_for=1, sinks=[sink], **options)
        async with playing(live) as server:
            socket = await server.feed("?mode=lossless&bins=1")
            changes = {"own-ship": {"course_deg": 250}, "errors": {"gyro": {"bias_deg": 5}}, "bodies/a": {"speed_kn": 9}}
            for path_of, values in changes.items():
                await socket.spokes(4 * AZIMUTHS)
                assert (await server.http.patch(f"/api/radars/0/{path_of}", json=values)).status_code == 200
            await socket.spokes(4 * AZIMUTHS)
            await live.stop()
        end = int(live.transmitter.state.simulated * 10)
        sent = await sentences(live, 0, end)
    (source := ReplaySpokeSource(path)).make_scene_again(tmp_path)
    again = ReplayStation("0", source, refuse, **options)
    reports = [line.split(b",") for line in sent[1] if line.startswith(b"!AIVDM,1,")]
    assert {fields[4] for fields in reports if fields[5].startswith(b"1")} == {b"A", b"B"}  # of a class A position
    assert min(map(len, sent)) > 30 and await sentences(again, 0, end) == sent
    for late, whole in zip(await sentences(again, 145, end), sent, strict=True):
        assert len(late) > 10 and whole[-len(late) :] == late


def test_what_a_recording_cannot_tell_is_refused(recording: Path) -> None:
    source = ReplaySpokeSource(recording)
    source.record = {**source.record, "files": {"a.obj": "0"}}
    source.make_scene_again(recording.parent)
    stations = {"0": ReplayStation("0", source, refuse, settings=FAST)}
    with pytest.raises(
        UsageError,
        match="--ais-tcp, --ais-udp: the recorded scene cannot be built again: files: a.obj is not as recorded; copy",
    ):
        AisPort([]).check(stations)
    with pytest.raises(UsageError, match="--nmea-truth: a recording has the truth of beam crossings"):
        NmeaPort([], tells_truth=True).check({"0": replayed(recording)})
