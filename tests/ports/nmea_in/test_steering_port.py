"""Own ship steered by sentences: over sockets of this machine, in services that stand, so that truths can be compared."""

import asyncio
import contextlib
import json
import logging
import math
import random
import re
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from radar_service.__main__ import main
from radar_service.numerics.constants import KNOT
from radar_service.ports.app import create_app
from radar_service.ports.nmea.listeners import TcpSender
from radar_service.ports.nmea.nmea_port import NmeaPort
from radar_service.ports.nmea_in.receivers import RATE, TcpReceiver, UdpReceiver
from radar_service.ports.nmea_in.sentence_reader import Reading, SentenceIgnoredError
from radar_service.ports.nmea_in.steering_port import POSES, SILENCE, Helm, NmeaSteering, SteeringPort, unfitness
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.sender import UdpSender
from radar_service.service.logs import Refusals
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Settings
from radar_service.terminal.arguments import UsageError
from radar_service.world.commands import Command, CommandError
from radar_service.world.geo import map_from_geographic
from tests.ports.asgi import Server, running
from tests.ports.nmea.reading import hdt, line, rmc
from tests.ports.nmea.test_senders import HERE, free_port
from tests.ports.nmea_in.test_nmea_in import Clock
from tests.ports.playing import PAUSED
from tests.service.in_process import InProcess

ORIGIN = {"latitude_deg": 50.0, "longitude_deg": -1.0}
RADAR = {"azimuths": 8, "range_max_m": 500, "coarse_azimuths": True, "rpm": 60}
OWN, TRUTH = "/api/radars/0/own-ship", "/api/radars/0/truth"
HALF_MINUTE_DIGIT = 0.5e-5  # minutes
HALF_DIGIT = 0.005  # of degrees and knots
ROUNDING = 1e-7  # of minutes, degrees, knots and metres: decimal numbers, geodesics


def scene(own: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"radar": RADAR, "own_ship": own, "origin": ORIGIN, **more}


def station(input_: dict[str, Any], settings: Settings = PAUSED) -> Station:
    def make(order: SceneRequest, progress: Any) -> InProcess:
        return InProcess(order, "fast")

    return Station("0", InProcess(SceneRequest(input_), "fast"), make, settings=settings, allow_truth=True)


@contextlib.asynccontextmanager
async def served(of: Station, *ports: Port) -> AsyncIterator[Server]:
    try:
        async with running(create_app([of], PortHost((RestPort(), *ports)))) as server:
            yield server
    finally:
        for port in ports:
            port.close()


async def until(holds: Callable[[], Awaitable[bool]]) -> None:
    async with asyncio.timeout(10):
        while not await holds():
            await asyncio.sleep(0.01)


async def truth(server: Server, at: float | None = None) -> dict[str, Any]:
    return dict((await server.http.get(TRUTH, params={} if at is None else {"t": at})).json()["own_ship"])


@contextlib.asynccontextmanager
async def playing() -> AsyncIterator[tuple[Server, TcpReceiver]]:
    """A radar that is paused, with a TCP port in."""
    receiver = TcpReceiver("--nmea-in-tcp", Address(HERE, free_port()), [])
    async with served(station(scene({"steerable": {}})), SteeringPort([receiver])) as server:
        yield server, receiver


@contextlib.asynccontextmanager
async def connected(receiver: TcpReceiver) -> AsyncIterator[asyncio.StreamWriter]:
    _, writer = await asyncio.open_connection(*receiver.address)
    try:
        yield writer
    finally:
        await closed(writer)


async def closed(writer: asyncio.StreamWriter) -> None:
    writer.close()
    with contextlib.suppress(ConnectionError):
        await writer.wait_closed()


def say(writer: asyncio.StreamWriter, *sentences: bytes) -> None:
    writer.write(b"".join(each + b"\r\n" for each in sentences))


async def latest(server: Server) -> dict[str, Any]:
    return dict((await server.http.get(OWN)).json()["latest"] or {})


TURNING = {"course_deg": 100, "speed_kn": 14, "manoeuvre": [{"time_s": 0.5, "turn_rate_deg_s": 5.0}]}


async def piped(start: tuple[str, int], end: tuple[str, int]) -> None:
    """Hands on what one service serves to the one that listens, as `socat TCP:... TCP:...` does."""
    (reader, there), (_, writer) = await asyncio.open_connection(*start), await asyncio.open_connection(*end)
    try:
        while data := await reader.read(4096):
            writer.write(data)
    finally:
        await closed(there)
        await closed(writer)


@pytest.mark.parametrize("protocol", ["tcp", "udp"])
async def test_one_service_steers_another_one_and_the_truths_agree(protocol: str) -> None:
    """Both stand at the same instants, through a turn; each number agrees to half of the last digit of its sentence."""
    listening = Address(HERE, free_port())
    receiver = (
        TcpReceiver("--nmea-in-tcp", listening, []) if protocol == "tcp" else UdpReceiver("--nmea-in-udp", listening, [])
    )
    serving = Address(HERE, free_port())
    sender = TcpSender("--nmea-tcp", serving, []) if protocol == "tcp" else UdpSender("--nmea-udp", listening)
    leader = station(scene({**TURNING, "position_m": [60e3, 30e3]}))  # true north is 0.6 degrees off that of the map there
    follower = station(scene({"steerable": {}, "position_m": [5000, 5000]}))
    port = NmeaPort([sender])
    port.period = 0.02  # s: in a pause positions come with each tenth call
    async with served(leader, port) as a, served(follower, SteeringPort([receiver])) as b:
        pipe = asyncio.create_task(piped(serving[:2], listening[:2])) if protocol == "tcp" else None
        for _ in range(2):
            await a.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 7}})
            await until(lambda: agree(a, b))
        assert (await latest(b))["by"] == "nmea"
        if pipe is not None:
            pipe.cancel()
            await asyncio.gather(pipe, return_exceptions=True)


async def agree(a: Server, b: Server) -> bool:
    """Whether own ship of b, now, is that of a at the tenth of a second of which its sentences tell in a pause."""
    simulated = (await a.http.get(TRUTH)).json()["time"]
    one, other = await truth(a, math.floor(simulated * 10 + 1e-6) / 10), await truth(b)

    def close(key: str, scale: float, half: float, turn: float = 0.0) -> bool:
        difference = (one[key] - other[key]) * scale
        return abs(math.remainder(difference, turn) if turn else difference) <= half + ROUNDING

    return (
        all(close(key, 60.0, HALF_MINUTE_DIGIT) for key in ("latitude_deg", "longitude_deg"))
        and all(close(key, math.degrees(1.0), HALF_DIGIT, 360.0) for key in ("heading", "course"))
        and close("speed", 1 / KNOT, HALF_DIGIT)
    )


async def test_the_state_says_who_steers_and_the_last_one_wins() -> None:
    async with playing() as (server, receiver):
        async with connected(receiver) as writer:
            say(writer, hdt(33), rmc("120000.00"))
            await until(lambda: steered_by(server, "nmea"))
            await server.http.patch(OWN, json={"course_deg": 200})
            assert (await latest(server))["by"] == "rest"
            socket_ = await server.open("/api/radars/0/poses")
            await socket_.say(text='{"speed_kn": 1}')
            assert json.loads(await socket_.text())["by"] == "poses" == (await latest(server))["by"]
            say(writer, hdt(34))
            await until(lambda: steered_by(server, "nmea"))
            last = await latest(server)
            motion = [last[key] for key in ("heading_deg", "course_deg", "speed_kn")]
            assert motion == pytest.approx([34.0, 80.0, 6.0], abs=ROUNDING)  # at the origin true north is that of the map
            assert last["position_m"] is None  # the fix before the others steered does not come again


async def steered_by(server: Server, who: str) -> bool:
    return (await latest(server)).get("by") == who


async def test_bad_input_is_counted_and_the_radar_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rubbish, floods and silence of others do not keep the one who steers from steering."""
    monkeypatch.setattr("radar_service.ports.nmea_in.steering_port.SILENCE", 1e9)  # however slow the machine is
    counts: dict[str, float] = {}

    async def read_all(server: Server) -> bool:
        text = (await server.http.get("/metrics")).text
        found = re.findall(r'radar_refused_total\{reason="nmea-([a-z]+)"\} (\S+)', text)
        counts.update((word, float(count)) for word, count in found)
        return sum(counts.get(word, 0.0) for word in ("holder", "flood")) >= 10_001

    async with playing() as (server, receiver):
        async with connected(receiver) as steers, connected(receiver) as bad, connected(receiver):
            say(steers, hdt(10))
            await until(lambda: steered_by(server, "nmea"))
            say(
                bad,
                hdt(99),
                hdt(98)[:-2] + b"00",
                line("XXHDT,12,T"),
                line("GPGSV,1"),
                line("HEHDT,,T"),
                line("HEHDT,400,T"),
            )
            bad.write(random.Random(1).randbytes(2**20).replace(b"\n", b"") + b"\n")
            await bad.drain()
            bad.write(b"".join(hdt(n / 100) + b"\r\n" for n in range(10_000)))
            await bad.drain()
            say(steers, hdt(20))
            await until(lambda: heads(server, 20.0))
            await server.step(16)
            await until(lambda: is_at(server, 2.0))
            await until(lambda: read_all(server))
            assert (await latest(server))["heading_deg"] == pytest.approx(20.0, abs=ROUNDING)
    assert {word: counts[word] for word in ("checksum", "talker", "kind", "invalid", "value")} == dict.fromkeys(
        ("checksum", "talker", "kind", "invalid", "value"), 1.0
    )
    assert counts["form"] == 1 and counts["flood"] >= 10_001 - 100 - 30 * RATE


async def heads(server: Server, heading_deg: float) -> bool:
    return bool(abs((await latest(server)).get("heading_deg", math.inf) - heading_deg) < ROUNDING)


async def is_at(server: Server, time: float) -> bool:
    return bool((await server.http.get(TRUTH)).json()["time"] == time)


class Queue:
    """What takes commands: keeps them, with an answer that the test gives."""

    def __init__(self) -> None:
        self.put_: list[tuple[Any, Any, Future[Command]]] = []

    def put(self, body: str | None, values: Any, supersedes: bool = False, by: str | None = None) -> "Future[Command]":
        self.put_.append((values, by, Future()))
        return self.put_[-1][2]


class FakeStation:
    identity = "0"

    def __init__(self, input_: dict[str, Any]) -> None:
        self.commands, self.transmitter = Queue(), SimpleNamespace(state=SimpleNamespace(simulated=5.0))
        self.show(input_)

    def show(self, input_: dict[str, Any]) -> None:
        source = InProcess(SceneRequest(input_), "fast")
        self.epoch = SimpleNamespace(info=source.info, spoke_source=source)


def steering(input_: dict[str, Any] | None = None) -> tuple[NmeaSteering, FakeStation, Clock, Refusals]:
    fake, clock, refused = FakeStation(input_ or scene({"steerable": {}})), Clock(), Refusals()
    return NmeaSteering(cast(Station, fake), refused, clock), fake, clock, refused


def test_the_time_of_arrival_counts() -> None:
    """The pose holds when its position came, and goes on from there until a spoke shows it; sentences meanwhile are added."""
    made, fake, clock, _ = steering()
    made.hear("a", [rmc("120000.00", "5000.1000,N,00100.0000,W", 6.0, 90.0)])
    made.steer()
    ((first, by, answer),) = fake.commands.put_
    east, north = map_from_geographic(50.0 + 0.1 / 60.0, -1.0, (50.0, -1.0)).tolist()
    moved = first(5.5)["position_m"]
    assert by == "nmea" and moved == pytest.approx((east + 6.0 * KNOT * 0.5, north), abs=ROUNDING)
    fake.transmitter.state.simulated, clock.now = 6.0, 1.0
    made.hear("a", [rmc("120001.00", "5000.2000,N,00100.0000,W", 6.0, 90.0)])
    fake.transmitter.state.simulated = 6.2
    made.hear("a", [hdt(45.0)])
    made.steer()
    assert len(fake.commands.put_) == 1 and made.waits  # the one before is not answered
    answer.set_result(Command(0, 0.0, None))
    made.steer()
    second = fake.commands.put_[1][0](6.2)
    assert second["heading_deg"] == pytest.approx(45.0, abs=1e-3)  # 0.2 minutes of the origin's meridian
    assert second["position_m"][0] == pytest.approx(
        6.0 * KNOT * 0.2, abs=ROUNDING
    )  # of 6.0 s, though the heading came later


def test_poses_are_few_however_many_sentences_come() -> None:
    made, fake, clock, _ = steering()
    for n in range(100):
        clock.now = n / 100
        made.hear("a", [hdt(n)] * 5)
        made.steer()
        if not fake.commands.put_[-1][2].done():
            fake.commands.put_[-1][2].set_result(Command(0, 0.0, None))
    assert POSES - 3 <= len(fake.commands.put_) <= POSES + 1


def test_a_pose_that_is_refused_is_counted_and_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    made, fake, clock, refused = steering()
    with caplog.at_level(logging.WARNING, logger="radar_service"):
        for n in range(3):
            clock.now = float(n)
            made.hear("a", [hdt(n)])
            made.steer()
            fake.commands.put_[-1][2].set_exception(CommandError("speed_kn: 99 is not allowed"))
        made.steer()
    assert refused.counts["nmea-refused"] == 3 and [record.message for record in caplog.records] == ["own ship not steered"]


def test_a_position_that_is_refused_turns_no_heading() -> None:
    """One beyond the map, where true north is another: the next heading counts from north at own ship."""
    made, fake, clock, _ = steering()
    made.hear("a", [rmc("120000.00", "8959.0000,N,17000.0000,E", 6.0, 90.0), hdt(10.0)])
    made.steer()
    fake.commands.put_[-1][2].set_exception(CommandError("position_m"))
    clock.now = 1.0
    made.hear("a", [hdt(20.0)])
    made.steer()
    assert fake.commands.put_[-1][0](5.0)["heading_deg"] == pytest.approx(20.0, abs=1e-9)


def test_a_jump_is_one_line_of_the_log(caplog: pytest.LogCaptureFixture) -> None:
    """A ship at 6 knots says where it is each 2 s, jumps 1000 m, and goes on; a pose that is refused is no jump."""
    made, fake, clock, _ = steering()
    with caplog.at_level(logging.INFO, logger="radar_service"):
        for n in range(8):
            clock.now, fake.transmitter.state.simulated = 2.0 * n, 5.0 + 2.0 * n
            minutes = (6.0 * KNOT * 2 * n + (1000.0 if n >= 4 else 0.0)) / 1852.0  # of latitude
            made.hear("a", [rmc(f"1200{2 * n:02d}.00", f"50{minutes:07.4f},N,00100.0000,W", 6.0, 0.0)])
            made.steer()
            answer = fake.commands.put_[-1][2]
            answer.set_exception(CommandError("position_m")) if n == 6 else answer.set_result(Command(0, 0.0, None))
            made.steer()
    lines = [record for record in caplog.records if record.message == "own ship jumped"]
    assert [line.__dict__["fields"] for line in lines] == [
        {
            "radar": "0",
            "by": "nmea",
            "distance_m": pytest.approx(1006, abs=3),
        }  # as the arc of a minute is longer than 1852 m there
    ]


def test_the_first_position_is_compared_with_where_own_ship_is(caplog: pytest.LogCaptureFixture) -> None:
    made, fake, _, _ = steering()
    with caplog.at_level(logging.INFO, logger="radar_service"):
        made.hear("a", [rmc("120000.00", "5001.0000,N,00100.0000,W", 6.0, 0.0)])
        made.steer()
        fake.commands.put_[-1][2].set_result(Command(0, 0.0, None))
        made.steer()
    assert "own ship jumped" in [record.message for record in caplog.records]


UNFIT = {
    "add steerable": scene({}), "add an \\[origin\\]": {"radar": RADAR, "own_ship": {"steerable": {}}},
}  # fmt: skip


@pytest.mark.parametrize("words", UNFIT)
def test_a_scene_that_sentences_cannot_steer_ends_the_start(words: str) -> None:
    host = PortHost([SteeringPort([])])
    with pytest.raises(UsageError, match=f"--nmea-in: .*{words}"):
        host.check({"0": station(UNFIT[words])})
    host.check({"0": station(scene({"steerable": {}}))})


def test_the_command_says_so_in_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "s.json").write_text(json.dumps(scene({})))
    words = ["serve", str(tmp_path / "s.json"), "--port", "0", "--nmea-in-tcp", str(free_port())]
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("--nmea-in: own ship is not steerable in this scene; add")


@pytest.mark.parametrize("words", UNFIT)
def test_such_a_scene_that_comes_later_is_logged_once(words: str, caplog: pytest.LogCaptureFixture) -> None:
    made, fake, _, refused = steering()
    assert not unfitness(fake.epoch.info.scene)
    fake.show(UNFIT[words])
    with caplog.at_level(logging.WARNING, logger="radar_service"):
        made.hear("a", [hdt(1.0), hdt(2.0)])
        made.steer()
    assert refused.counts == {"nmea-scene": 2} and not fake.commands.put_
    assert [record.message for record in caplog.records] == ["sentences not followed"]
    fake.show(scene({"steerable": {}}))
    made.hear("a", [hdt(3.0)])
    made.steer()
    assert len(fake.commands.put_) == 1


def test_a_fault_in_one_reading_does_not_end_the_port() -> None:
    """It is counted as a fault of the port, and the next sentences steer."""
    faults = Counter[str]()

    class Failing(TcpReceiver):
        def received(self, count: Any) -> Any:
            faults["calls"] += 1
            if faults["calls"] == 1:
                raise ZeroDivisionError
            return super().received(count)

    async def whole() -> None:
        receiver = Failing("--nmea-in-tcp", Address(HERE, free_port()), [])
        async with served(station(scene({"steerable": {}})), SteeringPort([receiver])) as server:
            async with connected(receiver) as writer:
                say(writer, hdt(7))
                await until(lambda: heads(server, 7.0))
            assert 'radar_port_faults_total{port="nmea-in"} 1.0' in (await server.http.get("/metrics")).text

    asyncio.run(asyncio.wait_for(whole(), 60))


# Who steers, by times that the test gives.
HEADING = Reading(heading_deg=30.0)


def at(clock: float) -> Reading:
    return Reading(position=(50.0, -1.0), clock=clock)


def word(helm: Helm, sender: str, reading: Reading, now: float) -> str:
    with pytest.raises(SentenceIgnoredError) as ignored:
        helm.hear(sender, reading, now)
    return str(ignored.value)


def test_the_first_one_steers_until_three_seconds_of_silence() -> None:
    helm = Helm()
    assert SILENCE == 3.0
    helm.hear("a", HEADING, 10.0)
    assert word(helm, "b", HEADING, 12.9) == "holder"
    helm.hear("a", HEADING, 12.95)
    assert word(helm, "b", HEADING, 15.9) == "holder" and helm.holder == "a"
    helm.hear("b", HEADING, 15.95)
    assert helm.holder == "b" and word(helm, "a", HEADING, 16.0) == "holder"


def test_what_one_has_said_stays_but_for_the_position() -> None:
    helm = Helm()
    helm.hear("a", Reading(None, 80.0, 6.0, (50.0, -1.0), 1.0), 0.0)
    order = helm.hear("a", HEADING, 0.1)
    assert order.motion == {"heading_deg": 30.0, "course_deg": 80.0, "speed_kn": 6.0} and order.position is None
    assert helm.hear("b", HEADING, 3.2).motion == {"heading_deg": 30.0}  # nothing of the one before


def test_the_past_is_not_followed_and_holds_no_helm() -> None:
    helm = Helm()
    helm.hear("a", at(100.0), 0.0)
    helm.hear("a", at(100.0), 0.1)  # two sentences of one second
    assert word(helm, "a", at(99.9), 1.0) == "past" and word(helm, "a", at(99.9), 3.0) == "past"
    helm.hear("b", at(5.0), 3.2)
    assert helm.holder == "b"


def test_a_clock_that_was_set_back_is_followed_after_three_seconds() -> None:
    """The heading goes on meanwhile: another scene of that simulator."""
    helm = Helm()
    helm.hear("a", at(1000.0), 0.0)
    for tenth in range(1, 30):
        helm.hear("a", HEADING, tenth / 10)
        assert word(helm, "a", at(tenth / 10), tenth / 10) == "past"
    assert helm.hear("a", at(3.0), 3.0).position == (50.0, -1.0)


def test_midnight_is_not_the_past() -> None:
    helm = Helm()
    helm.hear("a", at(86_399.5), 0.0)
    helm.hear("a", at(0.5), 1.0)
    assert word(helm, "a", at(86_399.9), 1.1) == "past"
