"""A change of the rate of rotation on the air: where the next engine takes over, and what happens meanwhile."""

import asyncio
import threading
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
import pytest

from radar_service.radar.parameters import Origin
from radar_service.recording.simulated_source import SimulatedSource
from radar_service.scene.commands import Command
from radar_service.scene.error import SceneError
from radar_service.scene.load import load_scene
from radar_service.simulator import Simulator
from radar_service.stream.radio.handover import Handover
from radar_service.stream.radio.station import Station
from radar_service.stream.radio.world_process import scene_of
from radar_service.stream.settings import Pace, Settings
from radar_service.stream.source import Progress, SceneOrder
from tests.stream.fake import AZIMUTHS, FakeEngine, factory, scene
from tests.stream.radio.recording import RecordingSink

PERIOD = 2.5  # s of a scan
FAST, PAUSED = Settings(pace=Pace("run", float("inf"))), Settings(pace=Pace("pause"))


def play(test: Callable[[Station, RecordingSink], Awaitable[None]], settings: Settings, make: Any = None) -> RecordingSink:
    async def body() -> RecordingSink:
        sink = RecordingSink()
        station = Station("0", FakeEngine(scene()), make or factory(), settings=settings, sinks=[sink])
        await station.start()
        try:
            await test(station, sink)
        finally:
            await station.stop()
        return sink

    return asyncio.run(asyncio.wait_for(body(), 30))


def goes_on(sink: RecordingSink, epoch: int, period: float) -> None:
    """Each epoch's first spoke begins the scan after the last one, at the time when that has ended."""
    last = [b for b in sink.batches if b.epoch.name == sink.epochs[epoch - 1].name][-1].block
    first = next(b for b in sink.batches if b.epoch.name == sink.epochs[epoch].name)
    assert (first.first, first.block.index, first.block.scan) == (0, 0, last.scan + 1)
    assert last.index + len(last) == AZIMUTHS
    assert first.block.time[0] == pytest.approx(last.time[-1] + period / AZIMUTHS, rel=1e-12)


def test_an_agreement_is_the_end_of_a_scan_ahead() -> None:
    radar = scene().radar
    for sent, lead, at in ((0, 0.0, 24), (23, 0.0, 24), (24, 0.0, 48), (30, 0.1, 72), (30, 6.0, 120)):
        handover = Handover()
        assert handover.agree(radar, sent, False, lead) == Origin(at / AZIMUTHS * PERIOD, at // AZIMUTHS)
        assert handover.at == at and handover.is_open and handover.is_due(at) and not handover.is_due(at - 1)
        assert handover.agree(radar, sent + 1, False, 99.0).scan == at // AZIMUTHS  # another request: the same
        handover.settle()
        assert handover.is_open
        handover.settle()
        assert not handover.is_open


def test_an_idle_radar_hands_over_where_it_stands() -> None:
    handover = Handover()
    assert handover.agree(scene().radar, 30, True, 5.0) == Origin(30 / AZIMUTHS * PERIOD, 2)
    assert handover.is_due(30)
    handover.end(48)
    assert handover.at is None and handover.agree(scene().radar, 0, True, 0.0) == Origin(2 * PERIOD, 2)


def test_spokes_that_are_being_sent_are_before_the_handover() -> None:
    handover = Handover()
    assert handover.claim(20, 26)  # sent now, while the count of the event loop still says 20
    assert handover.agree(scene().radar, 20, True, 0.0).time == pytest.approx(26 / AZIMUTHS * PERIOD)
    assert not handover.claim(26, 30) and handover.claim(25, 26)


def test_time_and_scans_go_on_twice() -> None:
    async def test(station: Station, sink: RecordingSink) -> None:
        for count, rpm in ((2, 48.0), (3, 12.0)):
            await station.change({"rpm": rpm})
            await asyncio.to_thread(sink.wait_for, lambda count=count: len(sink.epochs) == count)
            await asyncio.to_thread(sink.wait_for, lambda: sink.batches[-1].epoch is sink.epochs[-1])

    sink = play(test, FAST)
    assert [60 / epoch.engine.scene.radar.rotation_period for epoch in sink.epochs] == pytest.approx([24, 48, 12])
    goes_on(sink, 1, PERIOD)
    goes_on(sink, 2, PERIOD / 2)


def test_a_paused_radar_changes_at_once() -> None:
    async def test(station: Station, sink: RecordingSink) -> None:
        station.transmitter.pacer.step(5)
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == 5)
        await station.change({"rpm": 48.0})
        await asyncio.to_thread(sink.wait_for, lambda: len(sink.epochs) == 2)
        assert station.transmitter.simulated == pytest.approx(5 / AZIMUTHS * PERIOD)
        station.transmitter.pacer.step(3)
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == 8)

    block = play(test, PAUSED).batches[-1].block
    assert (block.scan, block.index + len(block)) == (1, 3)
    np.testing.assert_allclose(block.time, (5 / AZIMUTHS + (3 - len(block) + np.arange(len(block))) / AZIMUTHS / 2) * PERIOD)


def test_the_radar_waits_at_the_end_of_the_scan_for_an_engine_that_is_late() -> None:
    ready, asked = threading.Event(), threading.Event()

    def make(order: SceneOrder, progress: Progress) -> FakeEngine:
        asked.set()
        assert ready.wait(10)
        return factory()(order, progress)

    async def test(station: Station, sink: RecordingSink) -> None:
        change = asyncio.create_task(station.change({"rpm": 48.0}))
        await asyncio.to_thread(asked.wait, 10)
        at = station.transmitter.handover.at
        assert at is not None and at % AZIMUTHS == 0
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == at)
        ready.set()
        await change
        await asyncio.to_thread(sink.wait_for, lambda: sink.batches[-1].epoch is not sink.epochs[0])

    goes_on(play(test, FAST, make), 1, PERIOD)


def test_a_change_that_fails_lets_the_radar_go_on() -> None:
    def refuse(order: SceneOrder, progress: Progress) -> FakeEngine:
        raise SceneError("rpm: no")

    async def test(station: Station, sink: RecordingSink) -> None:
        with pytest.raises(SceneError):
            await station.change({"rpm": 48.0})
        sent = sink.spokes
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes > sent + 3 * AZIMUTHS)
        assert station.transmitter.handover.at is None

    assert len(play(test, FAST, refuse).epochs) == 1


def test_of_two_changes_at_once_the_last_one_wins() -> None:
    async def test(station: Station, sink: RecordingSink) -> None:
        await asyncio.gather(station.change({"rpm": 48.0}), station.change({"rpm": 12.0}))
        await asyncio.to_thread(
            sink.wait_for, lambda: sink.epochs[-1].engine.order.rpm == 12.0 and sink.batches[-1].epoch is sink.epochs[-1]
        )

    sink = play(test, FAST)
    for epoch in range(1, len(sink.epochs)):
        goes_on(sink, epoch, sink.epochs[epoch - 1].engine.scene.radar.rotation_period)


def test_no_agreement_ends_before_its_engine_has_taken_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else another request in between would take the pending engine for that of another scene, and begin at time 0."""
    pending = list[bool]()
    whole = Handover.end

    async def test(station: Station, sink: RecordingSink) -> None:
        def end(handover: Handover, number: int) -> None:
            pending.append(handover.at is not None and station.transmitter.engines.has_pending)
            whole(handover, number)

        monkeypatch.setattr(Handover, "end", end)
        for count, rpm in ((2, 48.0), (3, 12.0)):
            await station.change({"rpm": rpm})
            await asyncio.to_thread(sink.wait_for, lambda count=count: len(sink.epochs) == count)

    play(test, FAST)
    assert pending == [False, False]


STEERED: dict[str, Any] = {
    "radar": {"azimuths": 64, "beamwidth_deg": 8, "range_max_m": 256, "pulse_s": 1e-6},
    "environment": {"noise": True},
    "own_ship": {"steerable": {"max_speed_kn": 40}},
    "body": [{"name": "buoy", "shape": "point", "rcs_dbsm": 10, "position_m": [0, 150, 5], "steerable": {}}],
}


def test_commands_that_come_while_an_engine_is_prepared_act_as_in_process() -> None:
    ready, asked = threading.Event(), threading.Event()
    sink, commands = RecordingSink(), list[Command]()

    def make(order: SceneOrder, progress: Progress) -> SimulatedSource:
        asked.set()
        assert ready.wait(10)
        return SimulatedSource(Simulator(scene_of(order), "fast"), order)

    async def body() -> None:
        order = SceneOrder(STEERED)
        engine = SimulatedSource(Simulator(scene_of(order), "fast"), order)
        station = Station("0", engine, make, settings=FAST, sinks=[sink])
        await station.start()
        commands.append(await station.command("buoy", lambda time: {"speed_kn": 20, "course_deg": 70}))
        change = asyncio.create_task(station.change({"rpm": 60.0}))
        await asyncio.to_thread(asked.wait, 10)
        at = station.transmitter.handover.at
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == at)
        commands.append(await station.command(None, lambda time: {"speed_kn": 30}))
        commands.append(await station.command("buoy", lambda time: {"position_m": [100, 60]}))
        ready.set()
        await change
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes > (at or 0) + 130)
        await station.stop()

    asyncio.run(asyncio.wait_for(body(), 30))
    alone = Simulator(load_scene(STEERED), "fast", commands=commands[:1])
    parts = [[batch.block for batch in sink.batches if batch.epoch is epoch] for epoch in sink.epochs]
    scans = parts[1][0].scan
    assert commands[2].time == commands[1].time == scans * PERIOD == parts[1][0].time[0]
    expected = [spoke.power for spoke in alone.spokes(scans)]
    alone.command(speed_kn=30)
    alone.command("buoy", position_m=[100, 60])
    expected += [spoke.power for spoke in alone.at_rpm(60).spokes(2)]
    sent = np.concatenate([block.power for part in parts for block in part])[: len(expected)]
    assert sent.tobytes() == np.array(expected).tobytes()
