"""Commands that wait; commands to all radars of a world: one time, no spoke lost, and no deadlock with a client that does not
read."""

import asyncio
import contextlib
import json
import math
import os
import signal
import threading
import time
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest

from radar_service.commands.shared_options import SimulatorOptions
from radar_service.processes.call import Progress
from radar_service.processes.fork_server import ForkServer
from radar_service.scene_file.load import load_scene
from radar_service.service.radio import command_worker
from radar_service.service.radio.command_worker import (
    CommandQueue,
    CommandWorker,
    NoRadarError,
    Steered,
    TooManyCommandsError,
    time_of_commands,
)
from radar_service.service.radio.pacer import GroupClock
from radar_service.service.radio.scene_process import SceneProcessMaker, SpokeWorker, prepared
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.simulator import Simulator
from radar_service.spoke_source import SpokeSource
from radar_service.world.commands import Command, CommandError, CommandLog, NotSteerableError
from radar_service.world.scene import Scene
from tests.processes.test_fork_server import until
from tests.service.fake import AZIMUTHS, RADAR, FakeEngine, factory
from tests.service.radio.recording import SOON, RecordingSink

PAUSED, FLAT_OUT = Pace("pause", math.inf), Pace("run", math.inf)
RATES = {"bow": 24.0, "pier": 36.0, "slow": 0.5}  # rpm
BUOY = {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 100, 5], "steerable": {"max_speed_kn": 20}}
ROCK = {"name": "rock", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 150, 5]}


def world_scene(*ids: str, own_ship: dict[str, Any] | None = None) -> Scene:
    """Radars at their RATES; the pier stands on land."""
    radars = [RADAR | {"id": name, "rpm": RATES[name]} for name in ids]
    radars = [each | {"platform": {"position_m": [60, 0]}} if each["id"] == "pier" else each for each in radars]
    return load_scene({"radar": radars, "own_ship": own_ship or {"steerable": {}}, "body": [BUOY, ROCK]})


class Radars:
    """The radars of a world on the air."""

    def __init__(self, engines: dict[str, Any], make: Any, sinks: dict[str, Any]) -> None:
        self.command_worker = CommandWorker(GroupClock())
        self.sinks = {name: sinks.get(name) or RecordingSink() for name in engines}
        self.transmitters = {
            name: Transmitter(
                engine,
                Settings(pace=PAUSED),
                (self.sinks[name],),
                time.monotonic,
                make,
                command_worker=self.command_worker,
                restarts=1,
            )
            for name, engine in engines.items()
        }

    def put(self, radar: str, body: str | None, **values: Any) -> Any:
        """The answer to a command."""
        return self.transmitters[radar].commands.put(body, lambda time: values).result(SOON)

    def stepped(self, radar: str, spokes: int) -> None:
        """Lets a radar send so many spokes more, and the others up to that time."""
        total = self.sinks[radar].spokes + spokes
        self.transmitters[radar].pacer.step(spokes)
        self.sinks[radar].wait_for(lambda: self.sinks[radar].spokes >= total)
        until(lambda: all(each.pacer.idle or each.state.fault for each in self.transmitters.values()))

    def run(self) -> None:
        """Lets all run as fast as they can."""
        pacer = next(iter(self.transmitters.values())).pacer
        pacer.set(Settings(pace=FLAT_OUT))

    def commands(self, radar: str) -> CommandLog:
        return self.transmitters[radar].supervisor.worker.commands

    def engine(self, radar: str) -> SpokeSource:
        return self.transmitters[radar].supervisor.worker.spoke_source


@contextlib.contextmanager
def on_air(engines: dict[str, Any], make: Any = None, **sinks: Any) -> Iterator[Radars]:
    radars = Radars(engines, make or factory(), sinks)
    for transmitter in radars.transmitters.values():
        transmitter.start()
    try:
        yield radars
    finally:
        for transmitter in radars.transmitters.values():
            transmitter.stop(SOON)


def fakes(*ids: str, **options: Any) -> dict[str, FakeEngine]:
    of = world_scene(*ids, own_ship=options.pop("own_ship", None))
    return {name: FakeEngine(of.for_radar(name), **options.get(name, {})) for name in ids}


def test_one_command_acts_on_all_radars_at_one_time() -> None:
    with on_air(fakes("bow", "pier")) as radars:
        radars.stepped("bow", 7)
        command = radars.put("bow", "buoy", speed_kn=5)
        newest = max(float(sink.batches[-1].block.time[-1]) for sink in radars.sinks.values())
        others = [list(radars.commands(name)) for name in ("bow", "pier")]
        assert command.time > newest and others[0] == [command] and others[1][0].time == command.time
        for name, (other,) in zip(("bow", "pier"), others, strict=True):
            radar = radars.engine(name).scene.radar
            assert radar.time_of_spokes(other.spoke - 1.0) < command.time <= radar.time_of_spokes(float(other.spoke))
        assert radars.put("pier", "buoy", speed_kn=6).time >= command.time
        radars.stepped("pier", 2 * AZIMUTHS)
        for name, (other,) in zip(("bow", "pier"), others, strict=True):
            sink = radars.sinks[name]
            assert sink.numbers == list(range(len(sink.numbers)))
            known = {batch.block.first: batch.block.commands for batch in sink.batches}
            assert all(count == 2 for first, count in known.items() if first > other.spoke + 1)


def test_the_time_is_that_of_the_first_spoke_after_all_that_were_sent() -> None:
    bow, slow = (SpokeWorker(engine) for engine in fakes("bow", "slow").values())
    of, period = bow.spoke_source.scene.radar, 2.5 / AZIMUTHS
    assert time_of_commands([Steered(bow, 0, -math.inf), Steered(slow, 0, -math.inf)]) == 0.0
    one = Steered(bow, 7, of.time_of_spokes(6.0))
    assert time_of_commands([one]) == of.time_of_spokes(7.0)
    assert time_of_commands([one, Steered(slow, 1, 0.0)]) == of.time_of_spokes(7.0)
    ahead = Steered(slow, 2, 5.0)  # it has sent the spoke of 5 s, the bow that of 0.6 s
    assert time_of_commands([one, ahead]) == of.time_of_spokes(math.floor(5.0 / period) + 1.0) > 5.0


class HeldSink(RecordingSink):
    """Waits in each `send` until it is open, as for a lossless client."""

    def __init__(self) -> None:
        super().__init__()
        self.open, self.sending = threading.Event(), threading.Event()

    def send(self, batch: Any) -> None:
        self.sending.set()
        assert self.open.wait(SOON)
        super().send(batch)


@pytest.mark.parametrize("ids", [("bow",), ("bow", "pier")])
def test_commands_are_carried_out_while_a_radar_waits_for_a_client(ids: tuple[str, ...]) -> None:
    """Ten commands, each after the answer to the one before, and no spoke is read meanwhile."""
    sink = HeldSink()
    with on_air(fakes(*ids), bow=sink) as radars:
        radars.run()
        assert sink.sending.wait(SOON)
        commands = [radars.put(ids[-1], "buoy", speed_kn=n) for n in range(10)]
        assert not sink.spokes
        sink.open.set()
        bow_commands = list(radars.engine("bow").commands)
        sink.wait_for(lambda: sink.spokes > bow_commands[-1].spoke + AZIMUTHS)
        assert sink.numbers == list(range(len(sink.numbers)))
        assert [each.time for each in bow_commands] == [each.time for each in commands]
        assert {batch.block.commands for batch in sink.batches if batch.block.first >= bow_commands[-1].spoke} == {10}


def test_a_flood_of_commands_stops_no_radar() -> None:
    with on_air(fakes("bow", "pier")) as radars:
        queue = radars.transmitters["pier"].commands

        def again(time: float) -> dict[str, float]:
            with contextlib.suppress(NoRadarError):
                queue.put("buoy", again)
            return {"speed_kn": 5}

        queue.put("buoy", again)
        radars.run()
        for sink in radars.sinks.values():
            sink.wait_for(lambda sink=sink: sink.batches and sink.batches[-1].block.commands > 20)
            assert (numbers := sink.numbers) == list(range(len(numbers)))


def test_own_ship_that_is_a_body_is_that_body_to_other_radars() -> None:
    with on_air(fakes("bow", "pier", own_ship={"body": "buoy"})) as radars:
        assert radars.put("bow", None, course_deg=30).body is None
        (pier_command,) = radars.commands("pier")
        assert (pier_command.body, pier_command.course_deg) == ("buoy", 30.0)
        assert radars.commands("bow").latest("buoy") is radars.commands("bow").latest(None)


def test_radars_elsewhere_do_not_know_own_ship() -> None:
    with on_air(fakes("bow", "slow", "pier")) as radars:
        assert radars.put("bow", None, course_deg=30).course_deg == 30.0
        assert [len(radars.commands(name)) for name in ("bow", "slow", "pier")] == [1, 1, 0]
        with pytest.raises(NotSteerableError, match="own ship is not steerable"):
            radars.put("pier", None, course_deg=40)


def test_a_refused_command_changes_no_radar() -> None:
    with on_air(fakes("bow", "pier")) as radars:
        radars.stepped("bow", 5)
        for body, values in (("buoy", {"speed_kn": 21}), ("rock", {"speed_kn": 1}), ("nobody", {"speed_kn": 1})):
            with pytest.raises(CommandError):
                radars.put("pier", body, **values)
        assert [len(radars.commands(name)) for name in ("bow", "pier")] == [0, 0]
        assert radars.put("pier", "buoy", speed_kn=20).time > 0.0


def test_a_radar_that_has_failed_is_left_out_and_says_so() -> None:
    engines = fakes("bow", "pier", pier={"dies_at": 0})
    with on_air(engines, lambda order, progress: FakeEngine(engines["pier"].scene, dies_at=0)) as radars:
        radars.sinks["pier"].wait_for(lambda: "close" in radars.sinks["pier"].names())
        with pytest.raises(NoRadarError, match="the wheel came off"):
            radars.put("pier", "buoy", speed_kn=5)
        assert radars.put("bow", "buoy", speed_kn=5).spoke == 0
        radars.stepped("bow", 3)


def test_radars_that_are_about_to_begin_another_scene_are_steered_in_that() -> None:
    """While the sinks of one hold it in the old scene, the other one is in the new scene already."""
    sink = HeldSink()
    with on_air(fakes("bow", "pier"), bow=sink) as radars:
        radars.run()
        assert sink.sending.wait(SOON)
        radars.command_worker.clock.restart()
        workers = {name: prepared(engine) for name, engine in fakes("bow", "pier").items()}
        for name, worker in workers.items():
            radars.transmitters[name].switch_to(worker)
        radars.sinks["pier"].wait_for(lambda: len(radars.sinks["pier"].epochs) == 2)
        command = radars.put("pier", "buoy", speed_kn=5)
        assert list(workers["bow"].commands)[0].time == command.time
        assert not len(radars.transmitters["bow"].epoch.spoke_source.commands)
        sink.open.set()
        sink.wait_for(lambda: len(sink.epochs) == 2 and sink.batches[-1].block.commands == 1)


def test_the_thread_ends_with_the_last_radar() -> None:
    with on_air(fakes("bow", "pier")) as radars:
        waiting = radars.transmitters["bow"].commands
    assert not any(thread.name == "radar commands" for thread in threading.enumerate())
    with pytest.raises(NoRadarError, match="stopping"):
        waiting.put("buoy", lambda time: {"speed_kn": 5})


WORLD: dict[str, Any] = {
    "name": "two radars",
    "radar": [
        {"id": "bow", "azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600},
        {"id": "pier", "azimuths": 64, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 37, "platform": {"position_m": [150, 0]}},
    ],
    "environment": {"noise": True},
    "own_ship": {"body": "ship"},
    "body": [
        {"name": "ship", "shape": "box", "length_m": 20, "width_m": 5, "height_m": 5, "steerable": {}},
        {"name": "buoy", "shape": "point", "position_m": [200, 0, 5], "rcs_dbsm": 10, "steerable": {}},
    ],
}  # fmt: skip
ORDERS: list[
    tuple[str, int, str | None, dict[str, Any]]
] = [  # the radar that is asked, after so many spokes more of the bow
    ("bow", 17, None, {"course_deg": 70, "speed_kn": 20}),
    ("pier", 30, "buoy", {"position_m": [100, 200], "speed_kn": 12}),
    ("pier", 41, "ship", {"turn_rate_deg_s": -4}),
    ("bow", 1, "buoy", {"present": False}),
    ("bow", 60, "buoy", {"present": True, "heading_deg": 40}),
]


def test_each_radar_replays_to_the_same_bytes_and_their_truths_agree(fork_server: ForkServer) -> None:
    """In processes of their own, of which one crashes between two commands."""
    maker = SceneProcessMaker(fork_server, SimulatorOptions(fidelity="fast"))
    sources = {name: maker(SceneRequest(WORLD, radar=name), Progress()) for name in ("bow", "pier")}
    with on_air(dict(sources), maker) as radars:
        for number, (radar, spokes, body, values) in enumerate(ORDERS):
            radars.stepped("bow", spokes)
            radars.put(radar, body, **values)
            if number == 2:
                os.kill(sources["pier"].process, signal.SIGKILL)
        radars.stepped("bow", 80)
        times = np.linspace(0.0, radars.transmitters["pier"].state.simulated, 50)
        truths = [[radars.engine(name).truth(float(t)) for t in times] for name in ("bow", "pier")]
        sent = {name: list(radars.commands(name)) for name in sources}
        assert radars.transmitters["pier"].state.restarts == 1
    assert [command.time for command in sent["bow"]] == [command.time for command in sent["pier"]]
    for bow, pier in zip(*truths, strict=True):
        ships = [bow.own_ship, next(body for body in pier.bodies if body.name == "ship")]
        buoys = [next(body for body in truth.bodies if body.name == "buoy") for truth in (bow, pier)]
        for one, other in (ships, buoys):
            assert (one.position, one.velocity, one.heading) == (other.position, other.velocity, other.heading)
    for name, commands in sent.items():
        recorded = json.loads(json.dumps([command.as_dict() for command in commands]))
        replay = Simulator(load_scene(WORLD), "fast", radar=name, commands=recorded)
        expected = {spoke.number: spoke.power for spoke in replay.spokes(6)}
        numbers = radars.sinks[name].numbers
        assert len(numbers) > 150 and (name == "pier" or numbers == list(range(len(numbers))))
        for batch in radars.sinks[name].batches:
            for number, power in enumerate(batch.block.power, batch.block.first):
                np.testing.assert_array_equal(power, expected[number])


def speed(value: float) -> Any:
    return lambda time: {"speed_kn": value + time}


def carried_out(queue: CommandQueue, time: float = 1.5) -> list[bool]:
    """Carries out and answers all commands that wait and are awaited; returns whether each was accepted."""
    outcomes = [(each, each.carry_out(time, carry_out)) for each in queue.take() if each.begin()]
    for each, outcome in outcomes:
        each.answer(outcome)
    return [isinstance(outcome, Command) for _, outcome in outcomes]


def carry_out(body: str | None, values: Mapping[str, Any]) -> Command:
    if values["speed_kn"] > 50:
        raise CommandError("too fast")
    return Command(3, 1.5, body, **values)


def test_commands_are_taken_in_order_and_answered() -> None:
    calls: list[int] = []
    queue = CommandQueue(lambda: calls.append(len(queue)))
    answers = [queue.put(body, speed(value)) for body, value in (("a", 1), (None, 2), ("a", 99), ("a", 4))]
    assert calls == [1, 2, 3, 4]
    assert carried_out(queue) == [True, True, False, True]
    assert len(queue) == 0 and queue.take() == []
    assert [answers[n].result().speed_kn for n in (0, 1, 3)] == [2.5, 3.5, 5.5] and answers[1].result().body is None
    with pytest.raises(CommandError, match="too fast"):
        answers[2].result()


def test_what_nobody_waits_for_is_not_carried_out() -> None:
    """Whoever was told that it took too long may have ordered something else since."""
    queue = CommandQueue(lambda: None)
    late, first, second = queue.put("a", speed(1)), *(queue.put("b", speed(n), supersedes=True) for n in (2, 3))
    late.cancel()
    first.cancel()
    (waiting,) = [each for each in queue.take() if each.begin()]
    assert not second.cancel() and waiting.body == "b"
    waiting.answer(waiting.carry_out(0.0, carry_out))
    assert second.result().speed_kn == 3


def test_commands_of_several_queues_are_numbered_together() -> None:
    one, other = CommandQueue(lambda: None), CommandQueue(lambda: None)
    for queue, value in ((one, 1), (other, 2), (one, 3)):
        queue.put("a", speed(value))
    waiting = sorted(one.take() + other.take(), key=lambda each: each.number)
    assert [each.values(0.0)["speed_kn"] for each in waiting] == [1, 2, 3]


def test_a_pose_supersedes_the_pose_of_its_body_that_waits_and_no_command() -> None:
    queue = CommandQueue(lambda: None)
    command = queue.put("a", speed(1))
    old, other, new = (queue.put(body, speed(n), supersedes=True) for n, body in enumerate(("a", "b", "a")))
    assert carried_out(queue, 0.0) == [True, True, True]
    assert command.result().speed_kn == 1 and other.result().speed_kn == 1
    assert old.result() is new.result() and new.result().speed_kn == 2


def test_who_commands_from_an_event_loop_has_the_answer_of_the_pose_that_superseded_his() -> None:
    async def body() -> list[Command]:
        queue = CommandQueue(lambda: None)
        asked = [asyncio.ensure_future(queue.command("a", speed(n), supersedes=True)) for n in range(2)]
        await asyncio.sleep(0)
        assert carried_out(queue, 0.0) == [True]
        return await asyncio.gather(*asked)

    first, second = asyncio.run(body())
    assert first is second and second.speed_kn == 1


def test_a_command_that_takes_too_long_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_worker, "COMMAND_TIMEOUT", 0.001)
    queue = CommandQueue(lambda: None)
    with pytest.raises(TooManyCommandsError, match=r"sent no spoke for 0\.001 s, and takes no command meanwhile"):
        asyncio.run(queue.command("a", speed(1)))
    assert len(queue) == 1 and carried_out(queue) == []


def test_too_many_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_worker, "MAX_WAITING", 2)
    queue = CommandQueue(lambda: None)
    for _ in range(2):
        queue.put("a", speed(1))
    with pytest.raises(TooManyCommandsError, match="2 commands wait already; send fewer"):
        queue.put("a", speed(1))


def test_a_closed_queue_refuses_all_until_it_is_open_again() -> None:
    queue = CommandQueue(lambda: None)
    waiting = queue.put("a", speed(1))
    queue.close("the radar has stopped")
    with pytest.raises(NoRadarError, match="the radar has stopped"):
        waiting.result()
    with pytest.raises(NoRadarError, match="the radar has stopped"):
        queue.put("a", speed(1))
    queue.close(None)
    queue.put("a", speed(1))
    assert len(queue) == 1
