"""No change is lost before a port that is busy: those that wait become one of their kind."""

import threading

from radar_service.stream.ports.port_thread import PortThread
from radar_service.stream.ports.state_changes import StateChange
from radar_service.stream.ports.told_changes import ToldChanges

SOON = 10.0  # s


def change(kind: str, time: float, radar: str = "0", **values: object) -> StateChange:
    return StateChange(radar, kind, values, time)  # type: ignore[arg-type]


def test_what_waits_becomes_one_change_of_its_kind() -> None:
    got, thread, gate = list[StateChange](), PortThread("test"), threading.Event()
    told = ToldChanges(got.append, thread)
    thread.start()
    thread.put(lambda: gate.wait(SOON) and None)
    told.put(change("controls", 1.0, gain=1.0, sea=2.0))
    told.put(change("status", 2.0, state="paused"))
    told.put(change("controls", 3.0, gain=5.0))
    told.put(change("status", 4.0, radar="1", state="failed"))
    told.put(change("status", 5.0, state="running"))
    told.put(change("commands", 6.0, bodies={"a": 1, "b": 1}))
    told.put(change("commands", 7.0, own_ship=2, bodies={"b": 3}))
    gate.set()
    thread.stop(SOON)
    assert got == [
        change("controls", 3.0, gain=5.0, sea=2.0), change("status", 4.0, radar="1", state="failed"),
        change("status", 5.0, state="running"), change("commands", 7.0, own_ship=2, bodies={"a": 1, "b": 3}),
    ]  # fmt: skip


def test_each_change_is_told_where_there_is_time() -> None:
    got, thread, done = list[StateChange](), PortThread("test"), threading.Semaphore(0)
    told = ToldChanges(lambda each: (got.append(each), done.release())[0], thread)
    thread.start()
    for number in range(5):
        told.put(change("status", float(number), state="running"))
        assert done.acquire(timeout=SOON)
    thread.stop(SOON)
    assert [each.time for each in got] == [0.0, 1.0, 2.0, 3.0, 4.0]
