"""A change of the rate of rotation on the air: when the next engine takes over, and what happens meanwhile."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Iterator
from typing import Any

import numpy as np
import pytest

from radar_service.processes.call import Progress
from radar_service.records.spokes import SpokeBlock
from radar_service.scene_file.load import load_scene
from radar_service.service.controls import ControlError
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.station import Station
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.simulator import Simulator
from radar_service.world.commands import Command
from radar_service.world.error import SceneError
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene
from tests.service.in_process import InProcess
from tests.service.radio.recording import RecordingSink

PERIOD = 2.5  # s of a scan
FAST, PAUSED = Settings(pace=Pace("run", float("inf"))), Settings(pace=Pace("pause"))


@contextlib.asynccontextmanager
async def playing(settings: Settings, make: Any = None) -> AsyncIterator[tuple[Station, RecordingSink]]:
    sink = RecordingSink()
    station = Station("0", FakeEngine(scene()), make or factory(), settings=settings, sinks=[sink])
    await station.start()
    try:
        yield station, sink
    finally:
        await station.stop()


def goes_on(sink: RecordingSink, epoch: int) -> None:
    """An epoch begins with number 0, to the north, at the time of a scan at its rate, within a spoke of the epoch before."""
    last = [b for b in sink.batches if b.epoch.name == sink.epochs[epoch - 1].name][-1]
    first = next(b for b in sink.batches if b.epoch.name == sink.epochs[epoch].name)
    before, after = last.epoch.info.radar, first.epoch.info.radar
    assert (first.first, first.block.index) == (0, 0)
    assert first.block.time[0] == after.time_of_turns(float(first.block.scan))
    assert 0.0 < first.block.time[0] - last.block.time[-1] <= before.spoke_period * (1 + 1e-9)


async def test_time_goes_on_twice() -> None:
    async with playing(FAST) as (station, sink):
        for count, rpm in ((2, 48.0), (3, 12.0)):
            await station.change({"rpm": rpm})
            await asyncio.to_thread(sink.wait_for, lambda count=count: len(sink.epochs) == count)
            await asyncio.to_thread(sink.wait_for, lambda: sink.batches[-1].epoch is sink.epochs[-1])
    assert [60 / epoch.info.scene.radar.rotation_period for epoch in sink.epochs] == pytest.approx([24, 48, 12])
    goes_on(sink, 1)
    goes_on(sink, 2)


async def test_a_range_of_a_set_that_is_sold_is_a_scale_prepared_anew_and_time_goes_on() -> None:
    """5.5 km becomes the scale of 6 NM with its own pulse; the scale that runs is no change, and one beyond all is refused."""
    order = SceneRequest({"radar": {"set": "furuno-1824c", "range_max_m": 1852, "azimuths": 64, "coarse_azimuths": True}})
    sink, made = RecordingSink(), list[InProcess]()

    def make(order: SceneRequest, progress: Progress) -> InProcess:
        made.append(InProcess(order, "fast"))
        return made[-1]

    station = Station("0", InProcess(order, "fast"), make, settings=FAST, sinks=[sink])
    await station.start()
    await station.change({"range_m": 7500.0})
    await asyncio.to_thread(sink.wait_for, lambda: sink.batches[-1].epoch is not sink.epochs[0])
    assert station.controls()["range_m"] == 6 * 1852
    count = len(made)
    await station.change({"range_m": 6 * 1852.0})
    assert len(made) == count
    with pytest.raises(ControlError, match="range_m: 150000; this radar allows 10 to 133344 m"):
        await station.change({"range_m": 150e3})
    await station.stop()
    radars = [epoch.info.radar for epoch in sink.epochs]
    assert [(radar.range_max / 1852, radar.pulse) for radar in radars] == [(1, 80e-9), (6, 800e-9)]
    goes_on(sink, 1)


async def test_a_paused_radar_changes_at_once() -> None:
    async with playing(PAUSED) as (station, sink):
        station.transmitter.pacer.step(5)
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == 5)
        await station.change({"rpm": 48.0})
        await asyncio.to_thread(sink.wait_for, lambda: len(sink.epochs) == 2)
        assert station.transmitter.state.simulated == PERIOD / 2
        station.transmitter.pacer.step(3)
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == 8)

    block = sink.batches[-1].block
    assert (block.scan, block.index + len(block)) == (1, 3)
    np.testing.assert_allclose(block.time, (1 + (3 - len(block) + np.arange(len(block))) / AZIMUTHS) * PERIOD / 2)


class Late:
    """Makes engines that are prepared, or compute their first spokes, when the test says so."""

    def __init__(self, turns: threading.Semaphore | None = None) -> None:
        self.ready, self.asked, self.made = threading.Event(), threading.Event(), list[FakeEngine]()
        self._turns = turns

    def __call__(self, order: SceneRequest, progress: Progress) -> FakeEngine:
        self.asked.set()
        assert self.ready.wait(60)
        self.made.append(factory(turns=self._turns)(order, progress))
        return self.made[-1]


async def test_pause_standby_and_step_overtake_a_change_of_rpm() -> None:
    late = Late()
    async with playing(FAST, late) as (station, sink):
        change = asyncio.create_task(station.change({"rpm": 48.0}))
        await asyncio.to_thread(late.asked.wait, 10)
        await station.change({"pace": {"state": "pause"}})
        await station.change({"pace": {"state": "step", "steps": 7}})
        await asyncio.to_thread(sink.wait_for, lambda: station.transmitter.pacer.idle)
        await station.change({"transmit": False})
        assert not change.done() and len(sink.epochs) == 1
        late.ready.set()
        await change
        await asyncio.to_thread(sink.wait_for, lambda: len(sink.epochs) == 2)
        assert station.controls()["pace"]["state"] == "pause" and not station.settings.transmit


async def test_an_engine_whose_first_spokes_are_late_is_not_waited_for_but_prepared_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first one computes no spoke before the radar has gone on; a later one is in time."""
    turns, chosen = threading.Semaphore(0), list[float]()
    going_on = Transmitter.going_on

    def recorded(transmitter: Transmitter, leads: float, engine: Any) -> Any:
        result = going_on(transmitter, leads, engine)
        chosen.append(engine.info.radar.time_of_turns(float(result[0])))
        return result

    monkeypatch.setattr(Transmitter, "going_on", recorded)
    late = Late(turns)
    late.ready.set()
    async with playing(FAST, late) as (station, sink):
        change = asyncio.create_task(station.change({"rpm": 48.0}))
        await asyncio.to_thread(sink.wait_for, lambda: chosen and station.transmitter.state.simulated > chosen[0] + PERIOD)
        turns.release(1000)
        await change
        await asyncio.to_thread(sink.wait_for, lambda: sink.batches[-1].epoch is not sink.epochs[0])
    goes_on(sink, 1)
    *missed, last = late.made
    assert missed and all(engine.closed for engine in missed) and sink.epochs[1].spoke_source is last


async def test_a_change_back_before_the_first_is_prepared_leaves_the_radar_as_it_is() -> None:
    late = Late()
    async with playing(FAST, late) as (station, sink):
        change = asyncio.create_task(station.change({"rpm": 48.0}))
        await asyncio.to_thread(late.asked.wait, 10)
        await station.change({"rpm": 24.0})
        late.ready.set()
        await change
        sent = sink.spokes
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes > sent + 3 * AZIMUTHS)

    assert len(sink.epochs) == 1 and late.made[0].closed


def never(identity: str, worker: SpokeWorker) -> Transmitter:
    """Begins no radar."""
    raise AssertionError(identity)


@pytest.mark.parametrize("swap_first", [False, True])
async def test_another_scene_comes_while_an_engine_is_prepared(swap_first: bool) -> None:
    """A scene that was requested later has its own rate of rotation, one that was requested earlier takes the new one."""
    slow, other = Late(), scene("other")

    def make(order: SceneRequest, progress: Progress) -> FakeEngine:
        return (slow if order.rpm is not None and order.scene_input is not other else factory())(order, progress)

    async with playing(FAST, make) as (station, sink):
        request = station.group.request() if swap_first else 0
        change = asyncio.create_task(station.change({"rpm": 48.0}))
        await asyncio.to_thread(slow.asked.wait, 10)
        if swap_first:
            workers = await station.preparations.workers(make, {"0": SceneRequest(other)})
            station.group.switch_to(request, workers, never, stopping=False)
        else:
            await station.swap(SceneRequest(other))
        await asyncio.to_thread(sink.wait_for, lambda: sink.epochs[-1].info.scene.name == "other")
        slow.ready.set()
        await change
        if swap_first:
            await asyncio.to_thread(sink.wait_for, lambda: len(sink.epochs) == 3)

    last = sink.epochs[-1].info.scene
    assert (last.name, 60 / last.radar.rotation_period) == ("other", pytest.approx(48 if swap_first else 24))


async def test_a_change_that_fails_lets_the_radar_go_on() -> None:
    def refuse(order: SceneRequest, progress: Progress) -> FakeEngine:
        raise SceneError("rpm: no")

    async with playing(FAST, refuse) as (station, sink):
        with pytest.raises(SceneError):
            await station.change({"rpm": 48.0})
        sent = sink.spokes
        await asyncio.to_thread(sink.wait_for, lambda: sink.spokes > sent + 3 * AZIMUTHS)
        assert not station.transmitter.supervisor.pending

    assert len(sink.epochs) == 1


STEERED: dict[str, Any] = {
    "radar": {"azimuths": 64, "beamwidth_deg": 8, "range_max_m": 256, "pulse_s": 1e-6},
    "environment": {"noise": True},
    "own_ship": {"steerable": {"max_speed_kn": 40}},
    "body": [{"name": "buoy", "shape": "point", "rcs_dbsm": 10, "position_m": [0, 150, 5], "steerable": {}}],
}


async def test_commands_that_come_while_an_engine_is_prepared_act_as_in_process() -> None:
    """One comes before the first scan is chosen, two while the first spokes are computed."""
    ready, asked, begun = threading.Event(), threading.Event(), threading.Event()
    sink, commands, made = RecordingSink(), list[Command](), list[InProcess]()

    class Slow(InProcess):
        def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
            begun.set()
            assert ready.wait(60)
            return super().blocks(scans, size)

    def make(order: SceneRequest, progress: Progress) -> InProcess:
        asked.set()
        made.append(Slow(order, "fast"))
        return made[0]

    station = Station("0", InProcess(SceneRequest(STEERED), "fast"), make, settings=PAUSED, sinks=[sink])
    await station.start()
    commands.append(await station.commands.command("buoy", lambda time: {"speed_kn": 20, "course_deg": 70}))
    station.transmitter.pacer.step(128)
    await asyncio.to_thread(sink.wait_for, lambda: sink.spokes == 128)
    change = asyncio.create_task(station.change({"rpm": 60.0}))
    await asyncio.to_thread(begun.wait, 10)
    assert len(made[0].commands) == 1  # its first spokes follow it: none is computed again
    commands.append(await station.commands.command(None, lambda time: {"speed_kn": 30}))
    commands.append(await station.commands.command("buoy", lambda time: {"position_m": [100, 60]}))
    ready.set()
    await change
    await station.change({"pace": {"state": "run", "factor": "max"}})
    await asyncio.to_thread(sink.wait_for, lambda: sink.spokes > 128 + 130)
    await station.stop()
    alone = Simulator(load_scene(STEERED), "fast", commands=commands[:1])
    parts = [np.concatenate([b.block.power for b in sink.batches if b.epoch is epoch]) for epoch in sink.epochs]
    assert [len(part) for part in parts][0] == 128 and [epoch.info.radar.rotation_period for epoch in sink.epochs] == [
        2.5,
        1.0,
    ]
    assert parts[0].tobytes() == np.array([spoke.power for spoke in alone.spokes(2)]).tobytes()
    assert commands[1].time == commands[2].time == 128 / 64 * PERIOD
    alone.command(speed_kn=30)
    alone.command("buoy", position_m=[100, 60])
    expected = np.array([spoke.power for spoke in alone.at_rpm(60).spokes(2)])
    assert parts[1][:128].tobytes() == expected.tobytes()
