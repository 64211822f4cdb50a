"""The transmitter with recording sinks: what it sends, in which order, and when its orders act. No event loop, no sockets."""

import contextlib
import math
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from radar_service.processes.call import Progress
from radar_service.records.cell_sources import SourceList, SourceRequest
from radar_service.service.radio.command_worker import NoRadarError
from radar_service.service.radio.radio_state import State, TakeOver
from radar_service.service.radio.scene_process import SpokeWorker, prepared
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import RadarInfo, SpokeBatch
from radar_service.world.scene import Scene
from tests.processes.test_fork_server import until
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene, steerable_scene
from tests.service.radio.recording import SOON, RecordingSink

PAUSED = Settings(pace=Pace("pause", math.inf))
FLAT_OUT = Settings(pace=Pace("run", math.inf))


@contextlib.contextmanager
def transmitting(settings: Settings = PAUSED, *sinks: Any, **options: Any) -> Iterator[tuple[Transmitter, RecordingSink]]:
    """A started transmitter, and the recording sink beside `sinks`."""
    sink, engine = RecordingSink(), options.pop("engine", FakeEngine(scene()))
    make_engine = options.pop("make_spoke_source", factory())
    transmitter = Transmitter(engine, settings, (sink, *sinks), time.monotonic, make_engine, **options)
    transmitter.start()
    try:
        yield transmitter, sink
    finally:
        transmitter.stop(SOON)


def stepped(transmitter: Transmitter, sink: RecordingSink, spokes: int) -> None:
    """RunControl so many spokes and waits for them."""
    total = sink.spokes + spokes
    transmitter.pacer.step(spokes)
    sink.wait_for(lambda: sink.spokes >= total)


def test_a_radar_that_fails_too_often_closes_its_sinks_until_the_next_scene() -> None:
    failures: list[str] = []
    options: dict[str, Any] = {"engine": FakeEngine(scene(), dies_at=10), "make_spoke_source": factory(dies_at=0)}
    with transmitting(FLAT_OUT, restarts=2, on_failure=failures.append, **options) as (transmitter, sink):
        sink.wait_for(lambda: sink.calls[-1] == ("close", "RuntimeError: the wheel came off"))
        until(lambda: bool(failures))
        assert transmitter.state.fault == "RuntimeError: the wheel came off" and transmitter.state.restarts == 2
        transmitter.switch_to(prepared(FakeEngine(scene("second"))))
        sink.wait_for(lambda: len(sink.epochs) == 2 and sink.calls[-1][0] == "send")
        assert transmitter.state.fault is None


def test_a_command_acts_from_the_next_spoke_and_no_spoke_is_lost_or_sent_twice() -> None:
    with transmitting(engine=FakeEngine(steerable_scene())) as (transmitter, sink):
        stepped(transmitter, sink, 7)
        command = transmitter.commands.put("buoy", lambda time: {"speed_kn": 5}).result(SOON)
        assert (command.spoke, command.time) == (7, 7 * transmitter.epoch.info.scene.radar.spoke_period)
        stepped(transmitter, sink, 6)
        assert transmitter.commands.put(None, lambda time: {"course_deg": time}).result(SOON).spoke == 13
        stepped(transmitter, sink, AZIMUTHS)
    assert sink.numbers == list(range(13 + AZIMUTHS))
    known = [batch.block.commands for batch in sink.batches for _ in range(len(batch))]
    assert known == [0] * 7 + [1] * 6 + [2] * AZIMUTHS


def test_every_next_engine_tells_what_is_requested() -> None:
    """Another scene, and the engine that replaces one that has failed."""
    with transmitting(sources=lambda: SourceRequest(True), make_spoke_source=factory(), restarts=3) as (transmitter, sink):
        stepped(transmitter, sink, 3)
        transmitter.switch_to(prepared(FakeEngine(scene("second"), dies_at=20)))
        sink.wait_for(lambda: len(sink.epochs) == 2)
        stepped(transmitter, sink, AZIMUTHS)
        assert transmitter.state.restarts == 1
    assert all(batch.block.labels is not None for batch in sink.batches)


def test_a_radar_without_labels_sends_its_spokes_all_the_same() -> None:
    engine = FakeEngine(scene())
    engine.sources = SourceList(no_labels="none", no_powers="none")
    with transmitting(engine=engine, sources=lambda: SourceRequest(True, "all")) as (transmitter, sink):
        stepped(transmitter, sink, AZIMUTHS)
    assert sink.numbers == list(range(AZIMUTHS)) and engine.requests == 0


@pytest.mark.parametrize("failing", [40, 20])
def test_the_next_engine_knows_the_commands_of_the_one_that_failed(failing: int) -> None:
    """With 20 it fails while the radar is paused before the command, with 40 after it."""
    of = steerable_scene()
    failed = FakeEngine(of, dies_at=failing)
    with transmitting(engine=failed, make_spoke_source=factory()) as (transmitter, sink):
        transmitter.supervisor.worker.spoke_source.scene_request = SceneRequest(of)  # type: ignore[misc]
        stepped(transmitter, sink, 7)
        command = transmitter.commands.put("buoy", lambda time: {"speed_kn": 5}).result(SOON)
        transmitter.pacer.step(3 * AZIMUTHS)
        sink.wait_for(lambda: sink.numbers[-1] > 2 * AZIMUTHS)
        engine = transmitter.epoch.spoke_source
        assert engine is not failed and list(engine.commands) == [command]
        assert sink.batches[-1].block.commands == 1


def test_a_stopped_or_failed_radar_refuses_commands() -> None:
    with transmitting(FLAT_OUT, engine=FakeEngine(steerable_scene(), dies_at=7), restarts=0) as (transmitter, sink):
        sink.wait_for(lambda: "close" in sink.names())
        with pytest.raises(NoRadarError, match="the wheel came off; give it another scene"):
            transmitter.commands.put("buoy", lambda time: {"speed_kn": 5})
        transmitter.switch_to(prepared(FakeEngine(steerable_scene("second"))))
        sink.wait_for(lambda: len(sink.epochs) == 2 and sink.names()[-1] == "send")
        assert transmitter.commands.put("buoy", lambda time: {"speed_kn": 5}).result(SOON).spoke > 0
    with pytest.raises(NoRadarError, match="stopping"):
        transmitter.commands.put("buoy", lambda time: {"speed_kn": 5})


def going_on(transmitter: Transmitter, of: Scene, scans_later: int = 0) -> SpokeWorker:
    """Returns the worker of an engine that goes on with the running one."""
    engine = FakeEngine(of)
    engine.scene_request = SceneRequest(of, rpm=48.0, goes_on=True)
    scan, commands = transmitter.going_on(0.0, engine)
    return prepared(engine, scan + scans_later, commands=commands)


def scene_of(transmitter: Transmitter) -> Scene:
    """The scene that a transmitter of a fake engine runs."""
    engine = transmitter.supervisor.worker.spoke_source
    assert isinstance(engine, FakeEngine)
    return engine.scene


def when_it_decides_to_take_over(transmitter: Transmitter, act: Callable[[], object], patch: pytest.MonkeyPatch) -> None:
    """Calls `act` between that decision and what follows from it."""
    handle = transmitter.state.handle

    def handled(event: Any) -> Any:
        instructions = handle(event)
        if any(isinstance(each, TakeOver) for each in instructions):
            act()
        return instructions

    patch.setattr(transmitter.state, "handle", handled)


def test_an_engine_that_is_about_to_take_over_is_not_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    turns, answers = threading.Semaphore(1), list[bool]()
    with transmitting(FLAT_OUT, engine=FakeEngine(scene(), turns=turns)) as (transmitter, sink):
        sink.wait_for(lambda: sink.spokes == 5)
        first, later = (going_on(transmitter, scene_of(transmitter), scans) for scans in (0, 1))
        when_it_decides_to_take_over(transmitter, lambda: answers.append(transmitter.go_on_with(later)), monkeypatch)
        assert transmitter.go_on_with(first)
        turns.release(10)
        sink.wait_for(lambda: sink.batches[-1].epoch is not sink.batches[0].epoch)
        later.stop()
    numbers = [spoke for batch in sink.batches for spoke in range(batch.block.first, batch.block.first + len(batch))]
    assert answers == [False] and numbers == list(range(len(numbers)))


def test_a_radar_that_stops_while_another_scene_takes_over_refuses_commands(monkeypatch: pytest.MonkeyPatch) -> None:
    with transmitting(engine=FakeEngine(scene(), dies_at=0), restarts=0) as (transmitter, _):
        until(lambda: transmitter.state.now is State.FAILED)

        def stop() -> None:
            transmitter.pacer.stop()
            transmitter.commands.close("stopping")

        when_it_decides_to_take_over(transmitter, stop, monkeypatch)
        transmitter.switch_to(prepared(FakeEngine(scene("second"))))
        until(lambda: transmitter.state.now is State.STOPPED)
        assert transmitter.commands.fault == "stopping"


def test_an_engine_that_is_made_while_the_radar_stops_ends_too() -> None:
    made, making, may_go_on = list[FakeEngine](), threading.Event(), threading.Event()

    def make(order: SceneRequest, progress: Progress) -> FakeEngine:
        making.set()
        assert may_go_on.wait(SOON)
        made.append(factory()(order, progress))
        return made[0]

    engine = FakeEngine(scene(), dies_at=0)
    transmitter = Transmitter(engine, FLAT_OUT, (RecordingSink(),), time.monotonic, make)
    transmitter.start()
    assert making.wait(SOON)
    transmitter.stop(0.0)
    may_go_on.set()
    until(lambda: bool(made) and made[0].closed)


class FailingOnce(RecordingSink):
    """Fails at its second batch."""

    def send(self, batch: SpokeBatch) -> None:
        super().send(batch)
        if len(self.batches) == 2:
            raise ValueError("no room")


def test_where_a_sink_fails_the_rest_of_the_block_is_given_up_with_the_scan() -> None:
    """It fails at spoke 3, within a block."""
    failing = FailingOnce()
    with transmitting(PAUSED, failing) as (transmitter, sink):
        stepped(transmitter, sink, 3)
        stepped(transmitter, sink, 1)
        stepped(transmitter, sink, 2)
    assert sink.numbers == failing.numbers == [0, 1, 2, 3, AZIMUTHS, AZIMUTHS + 1]
    assert transmitter.state.restarts == 1


class RefusingSink(RecordingSink):
    """Refuses the second epoch; `before` is called first."""

    def __init__(self) -> None:
        super().__init__()
        self.before = lambda: None

    def open_epoch(self, radar: RadarInfo) -> None:
        if self.epochs:
            self.before()
            raise ValueError("one epoch is enough")
        super().open_epoch(radar)


@pytest.mark.parametrize("stops", [False, True])
def test_a_sink_may_refuse_the_epoch_of_an_engine_that_goes_on(stops: bool) -> None:
    refusing = RefusingSink()
    with transmitting(PAUSED, refusing, restarts=0) as (transmitter, sink):
        refusing.before = transmitter.pacer.stop if stops else refusing.before
        stepped(transmitter, sink, 3)
        assert transmitter.go_on_with(going_on(transmitter, scene_of(transmitter)))
        until(lambda: transmitter.state.now is (State.STOPPED if stops else State.FAILED))
    assert transmitter.state.fault == (None if stops else "ValueError: one epoch is enough")
