"""An engine ahead: bounded, in order, and never silent about its end."""

import threading

import pytest

from radar_service.stream.ahead import Ahead, EngineFault
from tests.stream.fake import FakeEngine, scene

SOON = 10.0  # s, for what should take milliseconds


def ahead_of(engine: FakeEngine, azimuths: int = 12) -> Ahead:
    ahead = Ahead(engine, azimuths)
    ahead.start()
    return ahead


def test_blocks_come_in_order() -> None:
    ahead = ahead_of(FakeEngine(scene()))
    blocks = [ahead.take(SOON) for _ in range(20)]
    ahead.stop(SOON)
    numbers = [n for block in blocks if block for n in range(block.first, block.first + len(block))]
    assert numbers == list(range(numbers[-1] + 1)) and len(blocks) == 20


@pytest.mark.parametrize("taken", [0, 1, 4])
def test_no_more_than_the_bound_is_computed_ahead(taken: int) -> None:
    turns = threading.Semaphore(100)
    ahead = ahead_of(FakeEngine(scene(), turns=turns))
    for _ in range(taken):
        assert ahead.take(SOON) is not None
    with ahead._changed:
        assert ahead._changed.wait_for(lambda: len(ahead._blocks) >= 3, SOON)  # 3 blocks of up to 5 make 12
    ahead.stop(SOON)
    assert not ahead._thread.is_alive() and turns._value == 100 - 3 - taken


def test_a_slow_engine_is_waited_for_only_so_long() -> None:
    turns = threading.Semaphore(0)
    ahead = ahead_of(FakeEngine(scene(), turns=turns))
    assert ahead.take(0.01) is None
    turns.release()
    block = ahead.take(SOON)
    assert block is not None and block.first == 0
    ahead.stop()
    turns.release()


def test_what_a_dying_engine_had_computed_is_still_given() -> None:
    ahead = ahead_of(FakeEngine(scene(), dies_at=7))
    block = ahead.take(SOON)
    assert block is not None and len(block) == 5
    with pytest.raises(EngineFault, match="RuntimeError: the wheel came off"):
        ahead.take(SOON)


def test_an_engine_that_ends_is_a_fault_too() -> None:
    engine = FakeEngine(scene())
    whole = engine.blocks
    engine.blocks = lambda scans=None, size=16: whole(1, size)  # type: ignore[method-assign]
    ahead = ahead_of(engine, 1000)
    with pytest.raises(EngineFault, match="ended"):
        while ahead.take(SOON):
            pass


def test_stopping_ends_a_wait() -> None:
    ahead = ahead_of(FakeEngine(scene(), turns=threading.Semaphore(0)))
    taken: list[object] = []
    taker = threading.Thread(target=lambda: taken.append(ahead.take(SOON)))
    taker.start()
    ahead.stop()
    taker.join(SOON)
    assert taken == [None]
