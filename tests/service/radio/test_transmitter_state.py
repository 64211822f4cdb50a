"""The table of the transmitter's states is complete, and a transmitter passes all of it, in the order expected."""

import threading
from collections.abc import Iterator

import pytest

from radar_service.processes.call import Progress
from radar_service.service.radio.prefetch import SpokeWorker, prepared
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.radio.transmitter_state import TRANSITIONS, Event, State, TransitionError, TransmitterState
from radar_service.service.scene_request import SceneRequest
from radar_service.service.spokes import RadarInfo, SpokeBatch
from radar_service.world.scene import Scene
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene
from tests.service.radio.recording import SOON, RecordingSink
from tests.service.radio.test_transmitter import FLAT_OUT, PAUSED, stepped, transmitting

Passed = list[tuple[Event, State]]


def reached_from(state: State) -> set[State]:
    """All states that some events lead to from one."""
    reached: set[State] = set()
    fresh = {state}
    while fresh := {TRANSITIONS[key].state for key in TRANSITIONS if key[0] in fresh} - reached:
        reached |= fresh
    return reached


def test_each_state_is_reached_and_all_end_stopped() -> None:
    assert reached_from(State.READY) == {*State} - {State.READY}
    assert all(State.STOPPED in reached_from(state) for state in State if state is not State.STOPPED)
    assert not reached_from(State.STOPPED)


def test_each_event_has_a_place_and_each_transition_a_sentence() -> None:
    assert {event for _, event in TRANSITIONS} == {*Event}
    assert all(each.meaning.endswith(".") for each in TRANSITIONS.values())


@pytest.mark.parametrize("state", State)
@pytest.mark.parametrize("event", Event)
def test_an_event_without_a_place_is_refused(state: State, event: Event) -> None:
    present = TransmitterState()
    present.now = state
    assert present.allows(event) == ((state, event) in TRANSITIONS)
    if present.allows(event):
        present.on(event)
        assert present.now is TRANSITIONS[state, event].state
        return
    with pytest.raises(TransitionError, match=f"{event.name} in state {state.name}"):
        present.on(event)
    assert present.now is state and present.fault is None


def test_a_fault_lasts_until_an_engine_takes_over_and_longer_than_the_radar() -> None:
    for last, fault in ((Event.TAKEN_OVER, None), (Event.STOP, "it broke")):
        state = TransmitterState()
        state.on(Event.START)
        state.on(state.fail("it broke"))
        assert state.fault is None
        state.on(Event.GIVEN_UP)
        assert state.fault == "it broke"
        state.on(last)
        assert state.fault == fault


class Passing:
    """Records the events of the transmitters of a test, with the states that followed."""

    def __init__(self) -> None:
        self.steps: Passed = []
        self._changed = threading.Condition()

    def add(self, event: Event, state: State) -> None:
        with self._changed:
            self.steps.append((event, state))
            self._changed.notify_all()

    def wait_for(self, state: State) -> None:
        """Waits until this is the last state. Raises AssertionError after SOON."""
        with self._changed:
            assert self._changed.wait_for(lambda: self.steps[-1][1] is state, SOON), self.steps


@pytest.fixture
def passed(monkeypatch: pytest.MonkeyPatch) -> Iterator[Passing]:
    passing, whole = Passing(), TransmitterState.on

    def on(state: TransmitterState, event: Event) -> None:
        whole(state, event)
        passing.add(event, state.now)

    monkeypatch.setattr(TransmitterState, "on", on)
    yield passing
    assert passing.steps[0] == (Event.START, State.SENDING) and passing.steps[-1] == (Event.STOP, State.STOPPED)


def going_on(transmitter: Transmitter, of: Scene) -> SpokeWorker:
    """Returns the worker of an engine that goes on with the running one."""
    engine = FakeEngine(of)
    engine.scene_request = SceneRequest(of, rpm=48.0, goes_on=True)
    scan, commands = transmitter.going_on(0.0, engine)
    return prepared(engine, scan, commands=commands)


def test_a_long_life(passed: Passing) -> None:
    """Its engine fails, the next one too, and after it none comes up; another scene, which goes on, and one more scene."""
    dying, second = iter((100, 0)), scene("second")
    sink = RecordingSink()

    def make(order: SceneRequest, progress: Progress) -> FakeEngine:
        return factory(dies_at=next(dying))(order, progress)

    options = {"engine": FakeEngine(scene(), dies_at=40), "make_spoke_source": make}
    with transmitting(FLAT_OUT, sink, restarts=2, **options) as (transmitter, _):
        passed.wait_for(State.FAILED)
        transmitter.pacer.set(PAUSED)
        transmitter.switch_to(prepared(FakeEngine(second)))
        passed.wait_for(State.SENDING)
        stepped(transmitter, sink, 3)
        assert transmitter.go_on_with(going_on(transmitter, second))
        sink.wait_for(lambda: len(sink.epochs) == 3)
        transmitter.switch_to(prepared(FakeEngine(scene("third"))))
        sink.wait_for(lambda: len(sink.epochs) == 4)
    assert [epoch.info.scene.name for epoch in sink.epochs] == ["test scene", "second", "second", "third"]
    assert passed.steps == [
        (Event.START, State.SENDING),
        (Event.FAILURE, State.RESTARTING),
        (Event.RESTARTED, State.SENDING),
        (Event.FAILURE, State.RESTARTING),
        (Event.GIVEN_UP, State.FAILED),
        (Event.TAKEN_OVER, State.SENDING),
        (Event.TAKEN_OVER, State.SENDING),
        (Event.TAKEN_OVER, State.SENDING),
        (Event.STOP, State.STOPPED),
    ]


def scene_of(transmitter: Transmitter) -> Scene:
    """The scene that a transmitter of a fake engine runs."""
    engine = transmitter.supervisor.worker.spoke_source
    assert isinstance(engine, FakeEngine)
    return engine.scene


def test_an_engine_that_is_ready_takes_the_place_of_one_that_fails(passed: Passing) -> None:
    turns = threading.Semaphore(1)
    with transmitting(FLAT_OUT, engine=FakeEngine(scene(), dies_at=20, turns=turns)) as (transmitter, sink):
        sink.wait_for(lambda: sink.spokes == 5)
        assert transmitter.go_on_with(going_on(transmitter, scene_of(transmitter)))
        turns.release(10)
        sink.wait_for(lambda: len(sink.epochs) == 2)
    assert passed.steps[1:-1] == [(Event.FAILURE, State.RESTARTING), (Event.TAKEN_OVER, State.SENDING)]
    assert transmitter.supervisor.restarts == 0


def test_a_failed_radar_that_stops_keeps_its_fault(passed: Passing) -> None:
    with transmitting(FLAT_OUT, engine=FakeEngine(scene(), dies_at=7), restarts=0) as (transmitter, _):
        passed.wait_for(State.FAILED)
    assert passed.steps[1:] == [
        (Event.FAILURE, State.RESTARTING),
        (Event.GIVEN_UP, State.FAILED),
        (Event.STOP, State.STOPPED),
    ]
    assert transmitter.fault == "RuntimeError: the wheel came off"


class FailingOnce(RecordingSink):
    """Fails at its second batch."""

    def send(self, batch: SpokeBatch) -> None:
        super().send(batch)
        if len(self.batches) == 2:
            raise ValueError("no room")


def test_where_a_sink_fails_the_rest_of_the_block_is_given_up_with_the_scan(passed: Passing) -> None:
    """It fails at spoke 3, within a block."""
    failing = FailingOnce()
    with transmitting(PAUSED, failing) as (transmitter, sink):
        stepped(transmitter, sink, 3)
        stepped(transmitter, sink, 1)
        stepped(transmitter, sink, 2)
    assert sink.numbers == failing.numbers == [0, 1, 2, 3, AZIMUTHS, AZIMUTHS + 1]
    assert passed.steps[1:-1] == [(Event.FAILURE, State.RESTARTING), (Event.RESTARTED, State.SENDING)]


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
def test_a_sink_may_refuse_the_epoch_of_an_engine_that_goes_on(passed: Passing, stops: bool) -> None:
    refusing = RefusingSink()
    with transmitting(PAUSED, refusing, restarts=0) as (transmitter, sink):
        refusing.before = transmitter.pacer.stop if stops else refusing.before
        stepped(transmitter, sink, 3)
        assert transmitter.go_on_with(going_on(transmitter, scene_of(transmitter)))
        passed.wait_for(State.STOPPED if stops else State.FAILED)
    failed = [(Event.FAILURE, State.RESTARTING), (Event.GIVEN_UP, State.FAILED)]
    assert passed.steps[1:-1] == ([] if stops else failed)
    assert transmitter.fault == (None if stops else "ValueError: one epoch is enough")
