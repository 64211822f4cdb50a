"""Who runs the ports: in which order they start and end, where they are called, and which clock they have."""

import asyncio
import threading
from collections.abc import Sequence
from typing import Any

import pytest

from radar_service.ports import port_host
from radar_service.ports.app import create_app
from radar_service.ports.port import Port, Service
from radar_service.ports.port_host import PortHost, ToldChanges
from radar_service.ports.port_thread import PortThread
from radar_service.ports.rest.rest_port import RestPort
from radar_service.service.radio.state_changes import StateChange, StateWatch
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import SpokeSink
from tests.ports.asgi import running
from tests.ports.playing import station
from tests.service.radio.recording import RecordingSink


class Noted(Port):
    """Notes what is called, and by which thread."""

    name = "noted"

    def __init__(self, period: float | None = None) -> None:
        self.period, self.sink, self.changed_at = period, RecordingSink(), threading.Event()
        self.calls: list[tuple[str, Any]] = []
        self.threads: set[str] = set()
        self.ticked = threading.Semaphore(0)

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        self.calls.append(("sinks", radar))
        return (self.sink,)

    async def start(self, service: Service) -> None:
        self.calls.append(("start", list(service.stations)))

    async def stop(self) -> None:
        self.calls.append(("stop", None))

    def close(self) -> None:
        self.calls.append(("close", None))

    def tick(self, radar: str, time: float) -> None:
        self.threads.add(threading.current_thread().name)
        self.calls.append(("tick", time))
        self.ticked.release()

    def changed(self, change: StateChange) -> None:
        self.threads.add(threading.current_thread().name)
        self.changed_at.set()


def play(port: Port, settings: Settings, test: Any) -> PortHost:
    host = PortHost((port,))

    async def whole() -> None:
        async with running(create_app([station(settings=settings, sinks=host.sinks("0"))], host)):
            await asyncio.to_thread(test)

    asyncio.run(asyncio.wait_for(whole(), 60))
    port.close()
    return host


def test_a_port_starts_before_the_radars_and_ends_after_them() -> None:
    port = Noted()
    play(port, Settings(pace=Pace("run", 100.0)), lambda: port.sink.wait_for(lambda: port.sink.spokes > 5))
    assert [name for name, _ in port.calls] == ["sinks", "start", "stop", "close"] and port.calls[1][1] == ["0"]
    assert port.sink.calls[0][0] == "open" and port.changed_at.is_set()


@pytest.mark.parametrize("delays", [False, True])
def test_clock_and_news_come_from_the_thread_of_the_port_whether_it_delays_radars_or_not(delays: bool) -> None:
    port = Noted(period=0.01)
    port.delays = delays  # type: ignore[misc]

    def test() -> None:
        assert port.changed_at.wait(60) and port.ticked.acquire(timeout=60.0)

    play(port, Settings(pace=Pace("pause")), test)
    assert port.threads == {"port noted"}


@pytest.mark.parametrize("factor", [1.0, 5.0, float("inf")])
def test_its_clock_is_that_of_the_world(factor: float) -> None:
    """So many calls come in so many periods of the world's time, no more, at any pace."""
    port = Noted(period=0.1)

    def test() -> None:
        for _ in range(4):
            assert port.ticked.acquire(timeout=60.0)

    play(port, Settings(pace=Pace("run", factor)), test)
    times = [time for name, time in port.calls if name == "tick"]
    assert all(time >= times[0] + 0.1 * number for number, time in enumerate(times))


def test_the_sinks_of_a_port_that_delays_radars_are_called_at_once() -> None:
    port = Noted()
    port.delays = True  # type: ignore[misc]
    assert PortHost((port,)).sinks("0") == [port.sink]


def test_a_look_that_fails_is_logged_and_the_next_one_is_told(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(port_host, "AFTER_FAULT", 0.0)
    looks, changes = [], StateWatch.changes

    def failing_once(watch: StateWatch) -> list[StateChange]:
        looks.append(watch)
        if len(looks) == 1:
            raise ZeroDivisionError("a fault")
        return changes(watch)

    monkeypatch.setattr(StateWatch, "changes", failing_once)
    port = Noted()
    play(port, Settings(pace=Pace("pause")), lambda: port.changed_at.wait(10.0))
    assert port.changed_at.is_set() and "changes not told" in caplog.text


@pytest.mark.parametrize("fault", ["blocks", "raises"])
async def test_a_port_that_does_not_stop_holds_up_nobody(
    fault: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(port_host, "STOP_SECONDS", 0.05)

    class Stubborn(Port):
        name = "stubborn"

        async def stop(self) -> None:
            if fault == "raises":
                raise RuntimeError("it will not")
            await asyncio.Event().wait()

    host = PortHost((Stubborn(), noted := Noted()))
    async with running(create_app([station()], host)):
        pass
    assert ("stop", None) in noted.calls
    assert "port not stopped" in caplog.text


async def test_changes_are_told_after_the_epoch_has_opened() -> None:
    class InOrder(Noted):
        def changed(self, change: StateChange) -> None:
            self.sink.calls.append(("changed", change.kind))
            super().changed(change)

    port = InOrder()
    host = PortHost((port,))
    sinks = host.sinks("0")
    radar = station(settings=Settings(), sinks=sinks)
    host.threads[port].start()
    host.watch(radar)
    await asyncio.sleep(2 * port_host.LOOK)
    assert port.sink.calls == []
    sinks[0].open_epoch(radar.radar_info(radar.epoch))
    assert await asyncio.to_thread(port.changed_at.wait, 60)
    await host.stop()
    assert [name for name, _ in port.sink.calls][:2] == ["open", "changed"]


def test_a_port_that_cannot_start_ends_the_service_and_those_that_were_not_started_are_not_stopped() -> None:
    class Failing(Port):
        name = "failing"

        async def start(self, service: Service) -> None:
            raise OSError("its address is in use")

        async def stop(self) -> None:
            stopped.append(self.name)

    stopped: list[str] = []
    before, after = Noted(), Noted()
    host = PortHost((before, Failing(), after))

    async def whole() -> None:
        async with running(create_app([station()], host)):
            pass

    with pytest.raises(OSError, match="in use"):
        asyncio.run(asyncio.wait_for(whole(), 60))
    assert [name for name, _ in before.calls] == ["start", "stop"] and not after.calls and not stopped


async def test_the_clock_of_another_scene_begins_at_once() -> None:
    """Its time is below that of the scene before, and the next call comes then, not when the old time is reached again."""
    port = Noted(period=1.0)

    def times() -> list[float]:
        return [time for name, time in port.calls if name == "tick"]

    host = PortHost((RestPort(), port))
    radar = station(settings=Settings(pace=Pace("run", 50.0)), sinks=host.sinks("0"))
    async with running(create_app([radar], host)) as server:
        for _ in range(4):
            assert await asyncio.to_thread(port.ticked.acquire, timeout=10.0)
        answer = await server.http.put("/api/radars/0/scene", json={"scene": {"name": "other"}})
        assert answer.status_code == 200
        while not any(later < earlier for earlier, later in zip(times(), times()[1:], strict=False)):
            assert await asyncio.to_thread(port.ticked.acquire, timeout=10.0)
    first = next(k for k in range(1, len(times())) if times()[k] < times()[k - 1])
    assert times()[first] < 50.0 * 0.5  # a half second of the wall clock at that pace


SOON = 60.0  # s


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
