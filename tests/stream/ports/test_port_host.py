"""Who runs the ports: in which order they start and end, where they are called, and which clock they have."""

import asyncio
import threading
from collections.abc import Sequence
from typing import Any

import pytest

from radar_service.stream.http.app import create_app
from radar_service.stream.ports import port_host
from radar_service.stream.ports.port import Port, Service
from radar_service.stream.ports.port_host import PortHost
from radar_service.stream.ports.state_changes import StateChange, StateWatch
from radar_service.stream.radio.station import Station
from radar_service.stream.settings import Pace, Settings
from radar_service.stream.spokes import SpokeSink
from tests.stream.asgi import running
from tests.stream.fake import FakeEngine, factory, scene
from tests.stream.radio.recording import RecordingSink


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
        station = Station("0", FakeEngine(scene()), factory(), settings=settings, sinks=host.sinks("0"))
        async with running(create_app([station], host)):
            await asyncio.to_thread(test)

    asyncio.run(asyncio.wait_for(whole(), 30))
    host.close()
    return host


def test_a_port_starts_before_the_radars_and_ends_after_them() -> None:
    port = Noted()
    play(port, Settings(pace=Pace("run", 100.0)), lambda: port.sink.wait_for(lambda: port.sink.spokes > 5))
    assert [name for name, _ in port.calls] == ["sinks", "start", "stop", "close"] and port.calls[1][1] == ["0"]
    assert port.sink.calls[0][0] == "open" and port.changed_at.is_set()


def test_all_calls_come_from_the_thread_of_the_port() -> None:
    port = Noted(period=0.01)

    def test() -> None:
        assert port.changed_at.wait(10.0) and port.ticked.acquire(timeout=10.0)

    play(port, Settings(pace=Pace("pause")), test)
    assert port.threads == {"port noted"}


@pytest.mark.parametrize("factor", [1.0, 5.0, float("inf")])
def test_its_clock_is_that_of_the_world(factor: float) -> None:
    """Two calls are at least a period of the world's time apart, at any pace, and never the world's time as a whole."""
    port = Noted(period=0.25)

    def test() -> None:
        for _ in range(4):
            assert port.ticked.acquire(timeout=10.0)

    play(port, Settings(pace=Pace("run", factor)), test)
    times = [time for name, time in port.calls if name == "tick"]
    assert all(later - earlier >= 0.25 for earlier, later in zip(times[:-1], times[1:], strict=True))


def test_a_port_that_cannot_start_ends_the_service() -> None:
    class Failing(Port):
        name = "failing"

        async def start(self, service: Service) -> None:
            raise OSError("its address is in use")

    with pytest.raises(OSError, match="its address is in use"):
        play(Failing(), Settings(), lambda: None)


def test_a_port_that_delays_radars_has_no_thread() -> None:
    class Delaying(Noted):
        delays = True

    port = Delaying()
    host = PortHost((port,))
    assert not host.threads and host.sinks("0") == [port.sink]


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
