"""The worker of a spoke source: bounded, in order, and it always reports its end."""

import threading
import weakref
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import numpy as np
import pytest

from radar_service.records.cell_sources import PowersOf, SourceRequest
from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio import scene_process
from radar_service.service.radio.scene_process import SpokeWorker, prepared
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world.commands import CommandError
from radar_service.world.scene import scene_at_rpm
from tests.service.fake import FakeEngine, commanded, scene, steerable_scene

SOON = 60.0  # s, for what should take milliseconds


def started(engine: FakeEngine, azimuths: int = 12) -> SpokeWorker:
    worker = SpokeWorker(engine, azimuths)
    worker.start()
    return worker


@pytest.mark.parametrize("taken", [0, 1, 4])
def test_no_more_than_the_bound_is_computed_ahead(taken: int) -> None:
    engine = FakeEngine(scene(), turns=threading.Semaphore(100))
    worker = started(engine)
    for _ in range(taken):
        assert worker.take(SOON) is not None
    engine.wait_for_blocks(3 + taken, SOON)  # 3 blocks of up to 5 make 12
    worker.stop(SOON)
    assert not worker.is_alive and engine.blocks_made == 3 + taken


def test_wide_spokes_are_computed_ahead_up_to_a_number_of_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many blocks as fill BYTES_AHEAD, whatever the spokes; and free memory is returned after so many bytes."""
    returned = list[int]()
    engine = FakeEngine(scene(), turns=threading.Semaphore(100))
    size = engine.block(0, 5).nbytes
    monkeypatch.setattr(scene_process, "BYTES_AHEAD", 2 * size)
    monkeypatch.setattr(scene_process, "BYTES_BETWEEN", 3 * size - 1)
    monkeypatch.setattr(scene_process, "return_free_memory", lambda: returned.append(1))
    worker = started(engine, azimuths=1000)
    engine.wait_for_blocks(2, SOON)
    assert not returned
    assert worker.take(SOON) is not None
    engine.wait_for_blocks(3, SOON)
    worker.stop(SOON)
    assert (engine.blocks_made, len(returned)) == (3, 1)


def test_a_slow_engine_is_waited_for_only_so_long() -> None:
    turns = threading.Semaphore(0)
    worker = started(FakeEngine(scene(), turns=turns))
    assert worker.take(0.01) is None
    turns.release()
    block = worker.take(SOON)
    assert block is not None and block.first == 0
    worker.stop()
    turns.release()


def test_what_a_dying_engine_had_computed_is_still_given() -> None:
    worker = started(FakeEngine(scene(), dies_at=7))
    block = worker.take(SOON)
    assert block is not None and len(block) == 5
    with pytest.raises(SpokeSourceFault, match="RuntimeError: the wheel came off"):
        worker.take(SOON)


def test_blocks_that_do_not_know_a_command_are_dropped() -> None:
    worker = started(FakeEngine(steerable_scene()))
    first = worker.take(SOON)
    assert first is not None and (first.first, first.commands) == (0, 0)
    assert commanded(worker, 3, "buoy", {"speed_kn": 5}).spoke == 3
    again = [worker.take(SOON) for _ in range(3)]
    assert [(block.first, block.commands) for block in again if block] == [(3, 1), (8, 1), (13, 1)]
    with pytest.raises(CommandError):
        commanded(worker, 8, "buoy", {"speed_kn": 50})
    block = worker.take(SOON)
    assert block is not None and (block.first, block.commands) == (18, 1)
    worker.stop(SOON)


def test_more_told_of_sources_comes_from_a_spoke_on_and_less_drops_nothing() -> None:
    worker = started(FakeEngine(scene()))
    spokes: list[tuple[int, bool, bool]] = []

    def take(count: int) -> None:
        while len(spokes) < count:
            block = worker.take(SOON)
            assert block is not None
            spokes.extend((spoke.number, spoke.labels is not None, spoke.powers is not None) for spoke in block.spokes())

    take(5)
    assert worker.request_sources(SourceRequest(labels=True), 5) and worker.requested == SourceRequest(labels=True)
    take(20)
    assert not worker.request_sources(SourceRequest(), 20)
    assert worker.request_sources(SourceRequest(labels=True), 20)  # before the first blocks without labels have come
    take(30)
    with_powers = len(spokes)
    assert worker.request_sources(SourceRequest(labels=True, powers=(256,)), with_powers)
    take(40)
    with_less = len(spokes)
    assert not worker.request_sources(SourceRequest(powers=(256,)), with_less)
    take(60)
    worker.stop(SOON)
    numbers, labels, powers = zip(*spokes, strict=True)
    assert numbers == tuple(range(len(spokes)))
    assert labels[:with_less] == (False,) * 5 + (True,) * (with_less - 5) and not labels[-1]
    assert powers == (False,) * with_powers + (True,) * (len(spokes) - with_powers)


class Overtaken(FakeEngine):
    """Has spokes 5 to 9 under way when a request comes that acts from spoke 5 on."""

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        yield self.block(0, 5)
        under_way = self.block(5, 5)
        with self._made:
            assert self._made.wait_for(lambda: self.requests, SOON)
        yield under_way
        yield self.block(5, 5)

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        super().request_sources(labels, powers, spoke)
        with self._made:
            self._made.notify_all()


def test_blocks_under_way_that_do_not_follow_a_request_are_dropped() -> None:
    worker = started(Overtaken(scene()))
    first = worker.take(SOON)
    assert first is not None and worker.request_sources(SourceRequest(labels=True), 5)
    second = worker.take(SOON)
    worker.stop(SOON)
    assert second is not None and (second.first, second.requests) == (5, 1) and second.labels is not None


class Interrupted(threading.Condition):
    """Lets another thread in wherever the thread that made it releases the lock: `then` is called there, once."""

    made: ClassVar[list["Interrupted"]] = []

    def __init__(self, lock: Any = None) -> None:
        super().__init__(lock)
        self.then: Callable[[], object] | None = None
        self._maker = threading.current_thread()
        self.made.append(self)

    def __exit__(self, *details: Any) -> None:
        super().__exit__(*details)
        if self.then and threading.current_thread() is self._maker:
            then, self.then = self.then, None
            then()


def test_a_command_never_takes_away_the_block_that_was_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = FakeEngine(steerable_scene())
    with monkeypatch.context() as patch:
        patch.setattr(threading, "Condition", Interrupted)
        worker = SpokeWorker(engine)
    changed = Interrupted.made[0]  # the worker's own; the next ones are its thread's
    worker.start()
    assert worker.wait_until_ready(SOON)
    changed.then = lambda: commanded(worker, 0, "buoy", {"speed_kn": 5})
    block = worker.take(SOON)
    assert block is not None and block.first == 0 and changed.then is None
    worker.stop(SOON)


def test_a_worker_that_was_stopped_keeps_no_spokes() -> None:
    """Whoever holds it still: a list of jobs, an earlier epoch."""
    made = list[weakref.ref[SpokeBlock]]()
    engine = FakeEngine(scene())
    compute = engine.block

    def noted(number: int, count: int) -> SpokeBlock:
        block = compute(number, count)
        made.append(weakref.ref(block))
        return block

    engine.block = noted  # type: ignore[method-assign]
    worker = started(engine)
    engine.wait_for_blocks(3, SOON)
    worker.stop(SOON)
    assert len(made) == 3 and not any(block() for block in made)
    assert worker.take(SOON) is None


def test_stopping_ends_a_wait() -> None:
    worker = started(FakeEngine(scene(), turns=threading.Semaphore(0)))
    taken: list[object] = []
    taker = threading.Thread(target=lambda: taken.append(worker.take(SOON)))
    taker.start()
    worker.stop()
    taker.join(SOON)
    assert taken == [None]


def test_spokes_before_a_command_are_kept() -> None:
    """A radar whose next spoke comes long before the command, as where another radar of the world is ahead."""
    engine = FakeEngine(steerable_scene(), turns=(turns := threading.Semaphore(2)))
    worker = started(engine)
    engine.wait_for_blocks(2, SOON)
    taken = worker.take(SOON)
    assert taken is not None and worker.known_part(taken) is taken
    assert commanded(worker, None, "buoy", {"speed_kn": 5}, 7.5 * 2.5 / 24).spoke == 8
    for _ in range(20):
        turns.release()
    blocks = [worker.take(SOON) for _ in range(3)]
    assert [(block.first, len(block), block.commands) for block in blocks if block] == [(5, 3, 0), (8, 5, 1), (13, 5, 1)]
    commanded(worker, 3, "buoy", {"speed_kn": 6})
    rest = worker.known_part(taken)
    assert rest is not None and (rest.first, len(rest)) == (0, 3)
    worker.stop(SOON)
    turns.release(20)


def test_a_worker_follows_the_commands_to_another_engine() -> None:
    of = steerable_scene()
    old, new = SpokeWorker(FakeEngine(of)), SpokeWorker(FakeEngine(scene_at_rpm(of, 48)))
    for spoke in (7, 24, 30):
        commanded(old, spoke, "buoy", {"speed_kn": 5})
    new.command(list(old.commands)[0])
    new.follow(old.commands)
    new.follow(old.commands)
    assert [command.spoke for command in new.commands] == [7, 48, 60]
    assert [command.time for command in new.commands] == [command.time for command in old.commands]


def test_spokes_before_the_first_one_are_not_queued() -> None:
    """A command of the time before a restart takes the engine back; what it computes again there is not sent."""
    worker = prepared(FakeEngine(steerable_scene()), 1)
    commanded(worker, 20, "buoy", {"speed_kn": 5})
    block = worker.take(SOON)
    worker.stop(SOON)
    assert block is not None and (block.first, block.commands) == (24, 1)


@pytest.mark.parametrize(("cells", "spokes"), [(20, 32), (10_922, 32), (10_923, 31), (45_000, 7), (10**6, 1)])
def test_wide_spokes_come_in_small_blocks_and_their_end_is_a_fault(cells: int, spokes: int) -> None:
    """A block of 32 spokes of 10,922 cells has 4 MiB: 8 bytes of field and 4 of power in each cell."""
    asked, engine = list[int](), FakeEngine(scene())
    engine.range = np.arange(cells, dtype=np.float64)
    engine.blocks = lambda size: iter(asked.append(size) or ())  # type: ignore[method-assign]
    with pytest.raises(SpokeSourceFault, match="ended"):
        started(engine).take(SOON)
    assert asked == [spokes]


def test_after_a_command_less_is_computed_ahead_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    """The next command may drop it again. Of blocks of five, eight are ahead at rest; steered two, and one in hand."""
    now = [100.0]
    monkeypatch.setattr(scene_process, "monotonic", lambda: now[0])
    monkeypatch.setattr(scene_process, "STEERED_AHEAD", 10)
    engine = FakeEngine(steerable_scene())
    worker = started(engine, 40)
    engine.wait_for_blocks(8, SOON)
    commanded(worker, 0, "buoy", {"speed_kn": 5})
    engine.wait_for_blocks(8 + 2, SOON)
    before, ahead = engine.blocks_made, []
    for taken in range(1, 200):
        assert worker.take(SOON) is not None
        ahead.append(engine.blocks_made - before - taken)
    assert max(ahead) <= 3
    now[0] += scene_process.STEERED_SECONDS
    worker.take(SOON)
    engine.wait_for_blocks(before + 200 + 5, SOON)
    worker.stop(SOON)
