"""The thread of a port: what waits is bounded, what fails is counted, and its sinks are told of each number."""

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from radar_service.ports import port_thread
from radar_service.ports.port_thread import BEHIND, PortThread, QueuedSink
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import FakeEngine, scene
from tests.service.radio.recording import RecordingSink

ENGINE = FakeEngine(scene())
SOON = 60.0  # s


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


def test_what_is_dropped_at_the_end_of_an_epoch_is_announced_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the next epoch opens, before the radar closes, and where nothing comes any more."""
    one, two = info("one"), info("two")
    monkeypatch.setattr(port_thread, "MAX_BYTES", batch(one, 0).block.nbytes)
    sends = [lambda queued, k=k: queued.send(batch(one, 4 * k)) for k in range(6)]
    opened: list[Any] = [lambda queued: queued.open_epoch(one), *sends]
    lost, last = ("skip", ("one", 0, 20, BEHIND)), ("send", ("one", 20, 4))
    sink, _ = played(*opened, blocked=True)
    assert sink.calls == [("open", "one"), lost, last]
    then: list[Any] = [lambda queued: queued.open_epoch(two), lambda queued: queued.send(batch(two, 0))]
    sink, _ = played(*opened, *then, blocked=True)
    assert sink.calls == [("open", "one"), ("skip", ("one", 0, 24, BEHIND)), ("open", "two"), ("send", ("two", 0, 4))]
    sink, _ = played(*opened, lambda queued: queued.close("it failed"), blocked=True)
    assert sink.calls == [("open", "one"), lost, last, ("close", "it failed")]


def test_no_number_of_any_opened_epoch_is_unaccounted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 200 random calls before a thread that is stopped at times: each number comes once, or is told as lost."""
    rng = np.random.default_rng(5)
    monkeypatch.setattr(port_thread, "MAX_BYTES", 4 * batch(info("x"), 0).block.nbytes)
    sink, thread = RecordingSink(), PortThread("test")
    queued, sent, epoch, number = QueuedSink(sink, thread), dict[str, int](), info("0"), 0
    queued.open_epoch(epoch)
    thread.start()
    for step in range(200):
        if rng.random() < 0.1:
            gate = threading.Event()
            thread.put(lambda gate=gate: gate.wait(SOON) and None)
            threading.Timer(0.001, gate.set).start()
        if rng.random() < 0.05:
            epoch, number = info(str(step + 1)), 0
            queued.open_epoch(epoch)
        elif rng.random() < 0.1:
            queued.skip(epoch.epoch.name, number, 3, "the engine has failed")
            number += 3
        else:
            queued.send(batch(epoch, number))
            number += 4
        sent[epoch.epoch.name] = number
    thread.stop(SOON)
    seen: dict[str, list[int]] = {}
    for name, what in sink.calls:
        if name in ("send", "skip"):
            seen.setdefault(what[0], []).extend(range(what[1], what[1] + what[2]))
    opened = [what for name, what in sink.calls if name == "open"]
    assert opened == sorted(set(opened), key=int) and opened[-1] == epoch.epoch.name
    for name in opened:
        assert seen.get(name, []) == list(range(sent.get(name, 0)))


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


class MuteError(Exception):
    def __str__(self) -> str:
        raise ValueError("no text")


@pytest.mark.parametrize("fault", [ZeroDivisionError, SystemExit, KeyboardInterrupt, MuteError])
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
        {"port": "test", "reason": fault.__name__ + ": a fault" * (fault is not MuteError)}
    ]


def test_of_one_key_one_call_waits() -> None:
    thread, calls = PortThread("test"), list[int]()
    for number in range(5):
        thread.put(lambda number=number: calls.append(number), key="clock")
    thread.put(lambda: calls.append(99))
    thread.start()
    thread.stop(SOON)
    assert calls == [4, 99] and thread.dropped == 0  # the last one, in place of those before


def test_a_thread_that_does_not_end_in_time_is_left_behind_and_calls_nothing_more() -> None:
    thread, gate, calls = PortThread("test"), threading.Event(), list[int]()
    thread.start()
    thread.put(lambda: gate.wait(SOON) and None)
    thread.put(lambda: calls.append(1))
    thread.stop(0.01)
    thread.put(lambda: calls.append(2))
    gate.set()
    thread.stop(SOON)
    assert not calls and thread.dropped == 2
