"""The feed from engine to websocket, in process, with a simulator whose every cell is known."""

import asyncio

import numpy as np
import pytest

from radar_service import wire
from radar_service.ports.feed.feed_socket import ConnectionErrors
from radar_service.records.cell_sources import SourceList
from radar_service.world.reporting import ErrorSettings
from tests.ports.asgi import Closed
from tests.ports.playing import FLAT_OUT, playing, station
from tests.service.fake import AZIMUTHS, BINS, SOURCES, STEP, FakeEngine, labels_of, power_of, scene
from tests.world.test_world import settings

CONTROLS = "/api/radars/0/controls"


async def test_hello_says_what_is_coming() -> None:
    async with playing() as server:
        hello = await (await server.feed("?encoding=u8&bins=5")).receive()
        assert (hello["type"], hello["protocol"], hello["seed"], hello["fidelity"]) == ("hello", 1, 7, "balanced")
        assert hello["scene"] == {"name": "test scene", "origin": None, "bodies": 0, "warnings": []}
        radar = hello["radar"]
        assert (radar["id"], radar["azimuths"], radar["bins"]) == ("0", AZIMUTHS, BINS)
        assert radar["rpm"] == pytest.approx(24.0) and radar["range_step_m"] == pytest.approx(STEP)
        encoding = hello["encoding"]
        assert (encoding["name"], encoding["bins"], encoding["dtype"]) == ("u8", 5, "|u1")
        positions = [encoding[key] for key in ("range_step_m", "range_first_m", "range_m")]
        assert positions == pytest.approx([40.0, 20.0, 200.0]) and encoding["db_per_step"] > 0
        assert hello["clocks"]["pace"] == {"state": "pause", "factor": 1.0} and hello["mode"] == "live"
        assert hello["controls"]["range_m"] == 200.0 and hello["truth"] is False and hello["plan"] == {"modelled": []}


async def test_spokes_arrive_whole_and_in_order() -> None:
    async with playing() as server:
        feed = await server.feed("?encoding=f32")
        await feed.until("hello")
        await server.step(2 * AZIMUTHS)
        got = await feed.spokes(2 * AZIMUTHS)
        numbers = np.concatenate([np.arange(m["first"], m["first"] + m["count"]) for m in got])
        np.testing.assert_array_equal(numbers, np.arange(2 * AZIMUTHS))
        data = np.concatenate([wire.samples(m) for m in got])
        np.testing.assert_array_equal(data, power_of(numbers, BINS))
        azimuth = np.concatenate([m["azimuth"] for m in got])
        np.testing.assert_array_equal(azimuth, np.rint((numbers % AZIMUTHS) * 65536 / AZIMUTHS))
        time = np.concatenate([m["time"] for m in got])
        np.testing.assert_allclose(time, numbers * 2.5 / AZIMUTHS, rtol=1e-12)
        assert all(m["index"] == m["first"] % AZIMUTHS and m["scan"] == m["first"] // AZIMUTHS for m in got)
        assert all(m["index"] + m["count"] <= AZIMUTHS for m in got)  # no batch spans two scans
        assert {h for m in got for h in m["heading"]} == {round(30 / 360 * 65536)}


async def test_batches_are_cut_by_time() -> None:
    async with playing() as server:
        # 24 spokes in 2.5 s are 104 ms each: one a message at factor 1; at factor 14 two in 15 ms
        feed = await server.feed()
        await server.step(3)
        assert [m["count"] for m in await feed.spokes(3)] == [1, 1, 1]
        await server.http.patch(CONTROLS, json={"pace": {"factor": 14}})
        await server.step(7)
        assert [m["count"] for m in await feed.spokes(7)] == [2, 2, 2, 1]  # 3 and 4 end a block, 9 ends the steps


async def test_another_range_is_another_epoch_at_once() -> None:
    async with playing() as server:
        feed = await server.feed("?encoding=f32")
        old = (await feed.until("hello"))["epoch"]
        await server.step(5)
        await feed.spokes(5)
        await server.http.patch(CONTROLS, json={"range_m": 100})
        hello = await feed.receive()
        assert hello["type"] == "hello" and hello["epoch"] != old and hello["encoding"]["bins"] == 10
        assert hello["controls"]["range_m"] == 100.0 and hello["encoding"]["range_m"] == pytest.approx(100.0)
        await server.step(2)
        message = await feed.until("spokes")
        assert (message["first"], message["index"], message["bins"]) == (0, 5, 10)  # the scan goes on, numbers start anew
        np.testing.assert_array_equal(wire.samples(message)[0], power_of([5], BINS)[0, :10])


async def test_truth_is_sent_on_request_where_it_is_allowed() -> None:
    async with playing(station(allow_truth=True)) as server:
        feed = await server.feed("?truth=1&encoding=f32")
        hello = await feed.receive()
        assert hello["truth"] is True
        await server.step(AZIMUTHS)
        times, seen = [], 0
        while seen < AZIMUTHS or len(times) < 8:
            message = await feed.receive()
            if message["type"] == "truth":
                times.append(message["time"])
                assert message["bodies"][0]["name"] == "buoy" and message["epoch"] == hello["epoch"]
            else:
                seen += message["count"]
        np.testing.assert_allclose(times, np.arange(8) * 2.5 / 8, rtol=1e-12)  # eight a scan


async def test_labels_are_sent_on_request_from_the_first_spoke_on() -> None:
    async with playing(station(allow_truth=True)) as server:
        plain = await server.feed("?encoding=f32")
        hello = await plain.receive()
        await server.step(5)
        before = await plain.spokes(5)
        feed = await server.feed("?encoding=f32&labels=1&powers=256")
        greeting = await feed.receive()
        assert greeting["sources"] == [{"number": number, "name": name} for number, name in SOURCES.items()]
        assert "sources" not in hello and greeting["epoch"] == hello["epoch"]
        await server.step(2 * AZIMUTHS)
        messages, others = await feed.spokes(2 * AZIMUTHS), [*before, *await plain.spokes(2 * AZIMUTHS)]
        assert others[0]["first"] == 0 and messages[0]["first"] == 5
        for message in messages:
            number = message["first"] + np.arange(message["count"])
            np.testing.assert_array_equal(wire.labels(message), labels_of(number, BINS))
            powers = wire.powers(message)
            assert powers is not None and powers[256].tobytes() == wire.samples(message).tobytes()
        for message in others:
            np.testing.assert_array_equal(
                wire.samples(message), power_of(message["first"] + np.arange(message["count"]), BINS)
            )
            assert "labels" not in message and "powers" not in message


async def test_spoke_0_waits_for_the_labels_of_a_client() -> None:
    async with playing(station(settings=FLAT_OUT, allow_truth=True, wait_for=1)) as server:
        feed = await server.feed("?mode=lossless&labels=1")
        messages = await feed.spokes(3)
        assert messages[0]["first"] == 0
        np.testing.assert_array_equal(wire.labels(messages[0])[0], labels_of([0], BINS)[0])


async def test_a_client_with_labels_that_comes_back_misses_nothing() -> None:
    async with playing(station(allow_truth=True)) as server:
        query = "?encoding=u8&bins=4&labels=1&spokes=2&compress=deflate"
        first = await server.feed(query)
        epoch = (await first.until("hello"))["epoch"]
        await server.step(AZIMUTHS)
        whole = await first.spokes(AZIMUTHS)
        await first.leave()
        await server.step(AZIMUTHS)
        second = await server.feed(f"{query}&since={epoch}:{whole[1]['first']}")
        assert (await second.receive())["epoch"] == epoch
        message = await second.receive()
        assert message["first"] == whole[1]["first"]
        np.testing.assert_array_equal(wire.labels(message), wire.labels(whole[1]))
        while message["first"] + message["count"] < 2 * AZIMUTHS:
            message = await second.receive()
            assert message["type"] == "spokes" and "labels" in message


async def test_sources_that_the_radar_cannot_tell_are_refused() -> None:
    engine = FakeEngine(scene())
    engine.sources = SourceList(SOURCES, no_labels="it has several pulses")
    async with playing(station(engine, allow_truth=True)) as server:
        for query, reason in (
            ("?labels=1", "labels: it has several pulses, or leave labels out"),
            ("?powers=1,999", "powers: 999 is no source of this scene; it has 0 noise, 1 sea, 256 buoy"),
        ):
            feed = await server.feed(query)
            assert (await feed.receive())["reason"] == reason
            with pytest.raises(Closed) as closed:
                await feed.receive()
            assert closed.value.code == 4400


async def test_a_bad_request_is_refused_with_the_reason() -> None:
    async with playing() as server:
        for query, code, reason in (
            ("?encoding=png", 4400, 'encoding: "png" is not one of u8'), ("?bins=0", 4400, 'bins: "0" is not a whole number'),
            ("?bins=1e9", 4400, "bins"), ("?mode=fast", 4400, "mode"), ("?since=12", 4400, "EPOCH:SEQ"),
            ("?truth=yes", 4400, "truth"), ("?colour=red", 4400, "no such parameter"), ("?truth=1", 4403, "--truth"),
            ("?labels=1", 4403, "labels and powers: this server does not send them; start it with --truth"),
            ("?powers=all", 4403, "--truth"), ("?labels=2", 4400, 'labels: "2" is not 0 or 1'),
            ("", 4404, 'radar: there is no "9"'),
            ("?powers=1,x", 4400, 'powers: "1,x" is not all, nor 1 to 64 numbers of sources'),
        ):  # fmt: skip
            feed = await server.feed(query, "0" if query else "9")
            bye = await feed.receive()
            assert bye["type"] == "bye" and reason in bye["reason"], query
            with pytest.raises(Closed) as closed:
                await feed.receive()
            assert closed.value.code == code


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


def test_a_slow_connection_is_fast_again_where_the_error_ends_and_ends_where_it_is_cut() -> None:
    played = Played()
    played.errors = settings({"feed": {"bytes_per_s": 2000}})
    asyncio.run(played.connection.carry(500))
    assert played.clock.now == 100.25 and played.connection.is_faulty()

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
