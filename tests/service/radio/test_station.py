"""A station: its parts together, further sinks, and whom it refuses."""

import asyncio
import contextlib
import threading
import tracemalloc
from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls, display_video
from radar_service.processes.call import Progress
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.feed_request import View
from radar_service.service.radio import status
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene, scene_in
from tests.service.radio.recording import RecordingSink


@contextlib.asynccontextmanager
async def playing(**options: Any) -> AsyncIterator[Station]:
    station = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")), **options)
    await station.start()
    try:
        yield station
    finally:
        for client in list(station.hub.clients):  # the station waits for those that stay
            station.leave(client)
        await station.stop()


async def test_a_further_sink_receives_what_the_feed_receives() -> None:
    sink = RecordingSink()
    async with playing(sinks=[sink]) as station:
        station.hub.join(client := ClientQueue(View("u8")))
        station.transmitter.pacer.step(AZIMUTHS)
        while sink.spokes < AZIMUTHS:
            await asyncio.sleep(0.001)
        sent = [(item.first, item.count) for item in client.waiting if item.count]
        assert sent == [(batch.first, len(batch)) for batch in sink.batches]
        assert [epoch.name for epoch in sink.epochs] == [station.hub.epoch]


async def test_a_sink_that_needs_labels_has_them_without_any_client() -> None:
    sink = RecordingSink()
    async with playing(sinks=[sink], recorded=SourceRequest(labels=True)) as station:
        station.transmitter.pacer.step(AZIMUTHS)
        while sink.spokes < AZIMUTHS:
            await asyncio.sleep(0.001)
    assert sink.numbers == list(range(AZIMUTHS)) and all(batch.block.labels is not None for batch in sink.batches)


async def test_a_client_with_labels_ends_the_wait_of_spokes_without_them() -> None:
    async with playing() as station:
        before = station.transmitter.pacer.run_control().version
        station.join(ClientQueue(View("u8")))
        assert station.transmitter.pacer.run_control().version == before
        station.join(ClientQueue(View("u8", labels=True)))
        assert station.transmitter.pacer.run_control().version > before


async def test_scan_correlation_is_the_same_for_clients_that_join_late_or_catch_up() -> None:
    """Of a view with fewer bins, from the third scan on, and of one that catches up: the bytes of the first client."""
    sink = RecordingSink()

    def bytes_of(client: ClientQueue) -> np.ndarray:
        messages = [wire.unpack(item.data) for item in client.waiting if item.count]
        return np.concatenate([wire.samples(message) for message in messages if message["type"] == "spokes"])[-AZIMUTHS:]

    async with playing(sinks=[sink]) as station:
        await station.change({"gain": 0.0, "sea_auto": False, "scan_correlation": True})
        clients = [ClientQueue(View("u8")), ClientQueue(View("u8", 5)), ClientQueue(View("u8"))]
        for scan in range(4):
            if scan in (0, 2):
                station.hub.join(clients[scan // 2])
            station.transmitter.pacer.step(AZIMUTHS)
            while sink.spokes < (scan + 1) * AZIMUTHS:
                await asyncio.sleep(0.001)
        station.hub.join(clients[2], since=(station.hub.epoch, 0))
        first, late, again = map(bytes_of, clients)
        np.testing.assert_array_equal(late, first.reshape(AZIMUTHS, 5, -1).max(axis=2))
        np.testing.assert_array_equal(again, first)
        power = np.concatenate([batch.block.power for batch in sink.batches])[-AZIMUTHS:]
        to, by_hand = sink.epochs[0].layout(None), Controls(gain=0.0, gain_auto=False, sea_auto=False)
        plain = display_video(power, to, by_hand, station.epoch.spoke_source.noise_power)
        assert np.all(first <= plain) and np.all(first[:, -3:] < plain[:, -3:])  # each spoke is stronger than the one before


async def test_clients_are_refused_with_the_reason() -> None:
    async with playing() as station:
        with pytest.raises(FeedRefused, match="--truth"):
            station.join(ClientQueue(View("u8"), truth=True))
        await station.stop()
        with pytest.raises(FeedRefused, match="the server is stopping"):
            station.join(ClientQueue(View("u8")))


async def test_a_change_acts_on_settings_steps_and_scene() -> None:
    async with playing() as station:
        await station.change({"rpm": 48.0, "gain": 70.0, "pace": {"state": "step", "steps": 3}})
        while station.transmitter.state.sent < 3:
            await asyncio.sleep(0.001)
        controls = station.controls()
        assert (controls["rpm"], controls["gain"], controls["pace"]["state"]) == (pytest.approx(48.0), 70.0, "pause")


async def test_a_prepared_scene_is_that_which_would_run() -> None:
    async with playing() as station:
        source = await station.prepare(SceneRequest(scene("other")))
        assert source.info.scene.name == "other" and source.info.plan == {"modelled": []}
        assert station.epoch.info.scene.name == "test scene"


@pytest.mark.parametrize("later_first", [False, True])
async def test_of_two_swaps_the_later_wins_whichever_is_prepared_first(later_first: bool) -> None:
    """Two workers prepare; each preparation waits until the test lets it go."""
    go = {"first": threading.Event(), "second": threading.Event()}
    made: dict[str, FakeEngine] = {}

    def make(order: SceneRequest, progress: Progress) -> FakeEngine:
        name = scene_in(order).name
        assert go[name].wait(60)
        made[name] = factory()(order, progress)
        return made[name]

    station = Station("0", FakeEngine(scene()), make, settings=Settings(pace=Pace("pause")))
    await station.start()
    swaps = [asyncio.create_task(station.swap(SceneRequest(scene(name)))) for name in go]
    await asyncio.sleep(0)
    for swap, name in list(zip(swaps, go, strict=True))[:: -1 if later_first else 1]:
        go[name].set()
        await swap
    pending = station.transmitter.supervisor.pending_spoke_source
    while station.epoch.spoke_source is not pending:  # paused: it takes over at once
        await asyncio.sleep(0.001)
    assert pending is made["second"] and made["first"].closed
    await station.stop()


async def test_the_first_spoke_waits_for_as_many_clients() -> None:
    clients = [ClientQueue(View("f32")) for _ in range(2)]

    async def first(client: ClientQueue) -> int:
        while (item := await client.get()) is not None:
            if item.count:
                return item.first
        raise AssertionError

    async with playing(wait_for=2) as station:
        station.transmitter.pacer.step(5)
        station.join(clients[0])
        assert station.transmitter.pacer.held and status.state(station) == "waiting" and status.is_ready(station)
        station.join(clients[1])
        assert not station.transmitter.pacer.held and status.state(station) == "paused"
        assert [await first(client) for client in clients] == [0, 0]
        for client in clients:
            station.leave(client)
        assert not station.transmitter.pacer.held


async def test_memory_stays_flat_over_swaps_of_wide_scenes() -> None:
    """Each scene has 4,000 cells; the spokes that are computed ahead take six megabytes."""
    held = list[int]()
    tracemalloc.start()
    async with playing() as station:
        for _ in range(12):
            epoch, _ = await station.swap(SceneRequest(scene("wide", range_max_m=40_000)))
            while station.epoch.name != epoch:
                await asyncio.sleep(0.001)
            engine = station.epoch.spoke_source
            station.transmitter.pacer.step(AZIMUTHS)
            while station.last_scan.read().next < AZIMUTHS:
                await asyncio.sleep(0.001)
            assert isinstance(engine, FakeEngine)
            await asyncio.to_thread(engine.wait_for_blocks, 31, 10.0)  # a scan that was sent, and AZIMUTHS_AHEAD
            held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert held[0] > 6e6 and max(held[4:]) <= 1.1 * max(held[:4])
