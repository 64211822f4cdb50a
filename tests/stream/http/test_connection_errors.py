"""A connection that is slow or cut on purpose, on a clock that the test turns."""

import asyncio

from radar_service.scene.error_settings import ErrorSettings
from radar_service.stream.http.connection_errors import ConnectionErrors
from tests.scene.test_error_settings import settings


class Clock:
    """A clock in seconds, which sleeping turns."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        self.now += seconds


class Played:
    def __init__(self) -> None:
        self.errors: ErrorSettings | None = None
        self.clock = Clock()
        self.connection = ConnectionErrors(lambda: self.errors, self.clock, self.clock.sleep)


def test_a_connection_without_errors_carries_at_once() -> None:
    played = Played()
    for played.errors in (None, settings({"gyro": {"bias_deg": 1}}), settings({"feed": {"drop_rate": 1}})):
        asyncio.run(played.connection.carry(1_000_000))
        assert not played.connection.is_faulty() and not played.connection.is_cut
    assert played.clock.now == 100.0


def test_a_slow_connection_carries_its_bytes_per_second() -> None:
    played = Played()
    played.errors = settings({"feed": {"bytes_per_s": 2000}})
    asyncio.run(played.connection.carry(500))
    assert played.clock.now == 100.25 and played.connection.is_faulty()


def test_a_slow_connection_is_fast_again_where_the_error_ends_and_ends_where_it_is_cut() -> None:
    played = Played()

    def errors() -> ErrorSettings | None:
        return settings({"feed": {"bytes_per_s": 100}}) if played.clock.now < 103.0 else None

    asyncio.run(ConnectionErrors(errors, played.clock, played.clock.sleep).carry(1_000_000))
    assert played.clock.now == 103.0
    played.errors = settings({"feed": {"bytes_per_s": 100, "cut_after_s": 7}})
    asyncio.run(played.connection.carry(1_000_000))
    assert played.clock.now == 107.0 and played.connection.is_cut


def test_a_connection_is_cut_at_its_age() -> None:
    played = Played()
    played.errors = settings({"feed": {"cut_after_s": 5}})
    assert played.connection.is_faulty() and not played.connection.is_cut
    played.clock.now += 5.0
    assert played.connection.is_cut
    played.errors = None
    assert not played.connection.is_cut and not played.connection.is_faulty()
