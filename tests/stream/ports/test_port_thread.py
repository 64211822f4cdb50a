"""The thread of a port: what waits is bounded, what fails is counted, and its sinks are told of each number."""

import threading
from collections.abc import Callable

import pytest

from radar_service.stream.ports import port_thread
from radar_service.stream.ports.port_thread import BEHIND, PortThread, QueuedSink
from radar_service.stream.spokes import Epoch, RadarInfo, SpokeBatch
from tests.stream.fake import FakeEngine, scene
from tests.stream.radio.recording import RecordingSink

ENGINE = FakeEngine(scene())
SOON = 10.0  # s


def info(name: str) -> RadarInfo:
    return RadarInfo.unnamed(Epoch(name, ENGINE, None))  # type: ignore[arg-type]


def batch(epoch: RadarInfo, first: int, count: int = 4) -> SpokeBatch:
    return SpokeBatch(epoch.epoch, first, ENGINE.block(first, count), None)  # type: ignore[arg-type]


def played(*calls: Callable[[QueuedSink], None], blocked: bool = False) -> tuple[RecordingSink, PortThread]:
    """What a sink records of calls; blocked: these all come while the thread does something else."""
    sink, thread, gate = RecordingSink(), PortThread("test"), threading.Event()
    queued = QueuedSink(sink, thread)
    if blocked:
        thread.put(lambda: gate.wait(SOON) and None)
    thread.start()
    for call in calls:
        call(queued)
    gate.set()
    thread.stop(SOON)
    return sink, thread


def test_all_is_passed_on_in_order() -> None:
    one, two = info("one"), info("two")
    sink, thread = played(
        lambda queued: queued.open_epoch(one), lambda queued: queued.send(batch(one, 0)),
        lambda queued: queued.send(batch(one, 4)), lambda queued: queued.skip("one", 8, 3, "the engine has failed"),
        lambda queued: queued.send(batch(one, 11)),
        lambda queued: queued.open_epoch(two), lambda queued: queued.send(batch(two, 0)), lambda queued: queued.close("the end"),
    )  # fmt: skip
    assert sink.calls == [
        ("open", "one"), ("send", ("one", 0, 4)), ("send", ("one", 4, 4)), ("skip", ("one", 8, 3, "the engine has failed")),
        ("send", ("one", 11, 4)), ("open", "two"), ("send", ("two", 0, 4)), ("close", "the end"),
    ]  # fmt: skip
    assert thread.faults == thread.dropped == 0


def test_what_is_too_much_is_dropped_and_announced(monkeypatch: pytest.MonkeyPatch) -> None:
    one = info("one")
    monkeypatch.setattr(port_thread, "MAX_BYTES", 3 * batch(one, 0).block.nbytes)
    calls = [lambda queued, k=k: queued.send(batch(one, 4 * k)) for k in range(8)]
    sink, thread = played(lambda queued: queued.open_epoch(one), *calls, blocked=True)
    assert sink.calls == [
        ("open", "one"),
        ("skip", ("one", 0, 24, BEHIND)),
        ("send", ("one", 24, 4)),
        ("send", ("one", 28, 4)),
    ]
    assert thread.dropped == 24


def test_an_epoch_opens_and_a_notice_holds_where_all_calls_before_were_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    one, two = info("one"), info("two")
    monkeypatch.setattr(port_thread, "MAX_CALLS", 1)
    sink, thread, gate = RecordingSink(), PortThread("test"), threading.Event()
    queued = QueuedSink(sink, thread)
    thread.put(lambda: gate.wait(SOON) and None)
    for _ in range(2):
        queued.open_epoch(one)
        queued.send(batch(one, 0))
    queued.open_epoch(two)
    thread.start()
    gate.set()
    assert thread.dropped == 11  # two batches of four spokes, and three notices
    monkeypatch.setattr(port_thread, "MAX_CALLS", 100)
    queued.skip("two", 5, 2, "the engine has failed")
    queued.send(batch(two, 7))
    thread.stop(SOON)
    assert sink.calls == [
        ("open", "two"), ("skip", ("two", 0, 5, BEHIND)), ("skip", ("two", 5, 2, "the engine has failed")),
        ("send", ("two", 7, 4)),
    ]  # fmt: skip


@pytest.mark.parametrize("fault", [ZeroDivisionError, SystemExit, KeyboardInterrupt])
def test_what_raises_is_counted_and_the_rest_is_done(fault: type[BaseException], caplog: pytest.LogCaptureFixture) -> None:
    thread, done = PortThread("test"), threading.Event()

    def wrong() -> None:
        raise fault("a fault")

    thread.start()
    thread.put(wrong)
    thread.put(done.set)
    thread.stop(SOON)
    assert done.is_set() and thread.faults == 1
    assert [getattr(record, "fields", None) for record in caplog.records] == [
        {"port": "test", "reason": f"{fault.__name__}: a fault"}
    ]


def test_of_one_key_one_call_waits() -> None:
    thread, calls = PortThread("test"), list[int]()
    for number in range(5):
        thread.put(lambda number=number: calls.append(number), key="clock")
    thread.put(lambda: calls.append(99))
    thread.start()
    thread.stop(SOON)
    assert calls == [0, 99] and thread.dropped == 0


def test_a_thread_that_does_not_end_is_left_behind() -> None:
    thread, gate = PortThread("test"), threading.Event()
    thread.put(lambda: gate.wait(SOON) and None)
    thread.start()
    thread.stop(0.01)
    gate.set()
