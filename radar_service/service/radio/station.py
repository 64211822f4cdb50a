"""The radars on the air: each a transmitter in its own threads, a hub on the event loop, and the requests of REST to both."""

import asyncio
import contextlib
import logging
import time
from collections import UserDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import datetime
from functools import partial
from typing import Any

from radar_service.records import SourceRequest, Truth
from radar_service.service.controls import changed_request, changed_settings, controls_state, needs_new_spoke_source
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import DRAIN, STOP_DRAIN, FeedEncoder, FeedRefused, Hub
from radar_service.service.logs import log_event
from radar_service.service.radio.error_stage import ErrorStage
from radar_service.service.radio.last_scan import CorrelationStage, LastScan
from radar_service.service.radio.preparation import Preparations
from radar_service.service.radio.radar_group import RadarGroup
from radar_service.service.radio.radio_state import RESTARTS
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.transmitter import STOPPING, SceneChanged, Transmitter
from radar_service.service.radio.truth_stream import FeedTruth, Follower, TruthStream
from radar_service.service.scene_request import MakeSpokeSource, SceneRequest, SceneSpokeSource
from radar_service.service.settings import Settings
from radar_service.service.spokes import Epoch, RadarInfo, SpokeSink
from radar_service.spoke_source import SpokeSourceInfo
from radar_service.world import SceneError, SceneOutline

NOTHING = SourceRequest()
LEAVE_TIMEOUT = 0.6  # s for clients to take what waits and their bye; then the server closes their connections
MAX_LEADS = 64.0  # a minute: a spoke source that takes longer for its first spokes does not keep pace
LOOK = 0.05  # s between two looks at whether another scene has begun
STOP_TIMEOUT = 3.0  # s to wait for each thread


class Station:
    """One radar. All methods are for the event loop.

    group: the radars that share its clock and its scene.
    hub: its clients.
    feed: encodes for them; feed_truth: tells them the truth.
    last_scan: for pictures.
    errors: on purpose; the feed, the last scan and other sinks receive what it passes on.
    sensor_laws: of own ship, in force at a spoke; of a replay those of the recorded run.
    lacks: why a replay does not tell `ships` between spokes, or the `truth` of every instant.
    truth_stream: sends the truth of beam crossings, where `allow_truth` says so.
    transmitter: sends to all sinks.
    commands: steer own ship and bodies, on all radars of the group.
    stopping: whether new clients are refused; end: why another scene has ended it, "" until then; ended: set then.
    failed: called, from another thread, when the radar has failed.
    preparations: where its scenes are prepared; the radars of a server share them, and so
    stations: all of them.
    """

    def __init__(
        self, identity: str, spoke_source: SceneSpokeSource, make_spoke_source: MakeSpokeSource, *, name: str | None = None,
        settings: Settings | None = None, allow_truth: bool = False, clock: Callable[[], float] = time.monotonic,
        restarts: int = RESTARTS, failed: Callable[[], None] = lambda: None, sinks: Sequence[SpokeSink] = (),
        group: RadarGroup | None = None, wait_for: int = 0, recorded: SourceRequest = NOTHING,
        start_utc: datetime | None = None, worker: SpokeWorker | None = None,
    ) -> None:  # fmt: skip
        """restarts: of failed spoke sources, within RESTART_WINDOW; sinks: take the spokes too, beside the feed; group: that
        it shares with other radars, by default its own; wait_for: clients that must listen before the first spoke is sent;
        recorded: what `sinks` need of the sources of cells; start_utc: at simulated time 0, by default the present second;
        worker: of the spoke source, where that has computed its first spokes."""
        self.identity, self.name, self.allow_truth = identity, name or f"radar {identity}", allow_truth
        self.failed, self.lacks = failed, dict[str, str]()
        self.stopping, self.end, self.ended = False, "", asyncio.Event()
        self.group = group or RadarGroup()
        self.hub = Hub(clock)
        self.last_scan = LastScan(spoke_source)
        self._truths = ThreadPoolExecutor(1, thread_name_prefix="truth")
        self.feed, self.feed_truth = FeedEncoder(self.hub, self.radar_info, clock), FeedTruth(self.hub, self._truths)
        self.errors = ErrorStage(spoke_source, [CorrelationStage((self.feed, self.feed_truth, self.last_scan, *sinks))])
        self.sensor_laws = self.errors.laws_at
        self.truth_stream = TruthStream(spoke_source, self._truths, self.errors.completed)
        sinks = (self.errors, self.truth_stream)
        self.transmitter = Transmitter(
            worker or spoke_source, settings or Settings(), sinks, clock, make_spoke_source, restarts=restarts,
            command_worker=self.group.command_worker,
            on_restart=self._log_restart, on_failure=self._report_failure, held=wait_for > 0,
            sources=lambda: self.feed.requested() | recorded, describe=self.radar_info, start_utc=start_utc,
        )  # fmt: skip
        self.commands = self.transmitter.commands
        self.preparations, self.stations = Preparations(), Stations((self,))
        self._make_spoke_source = make_spoke_source
        self._wait_for = wait_for
        self._options: Any = {
            "allow_truth": allow_truth, "clock": clock, "restarts": restarts, "recorded": recorded, "group": self.group,
            "start_utc": self.start_utc,
        }  # fmt: skip
        self.group.join(identity, self.transmitter)
        self._change = 0  # request of the last change of an engine control

    @property
    def epoch(self) -> Epoch:
        """The running one, with what is known of its source of spokes."""
        return self.transmitter.epoch

    @property
    def start_utc(self) -> datetime:
        """UTC at simulated time 0."""
        return self.epoch.start_utc

    @property
    def settings(self) -> Settings:
        """The settings that REST has made."""
        return self.transmitter.pacer.settings

    async def start(self) -> None:
        """Starts to compute and to send, and to take clients."""
        self.feed.start()
        self.feed_truth.start()
        self.truth_stream.start()
        await asyncio.to_thread(self.transmitter.start)

    async def stop(self, reason: str = STOPPING) -> None:
        """Sends `bye` to every client and ends the threads; where another scene has ended it, after what waits for the client."""
        self.stopping = True
        self.hub.close(reason, DRAIN if self.end else STOP_DRAIN)
        self.truth_stream.end(reason)
        await asyncio.to_thread(self.transmitter.stop, STOP_TIMEOUT, reason)
        if self.end:  # the service goes on: its ports are told, and clients are waited for
            await asyncio.to_thread(self.errors.close, reason)
        self.feed_truth.stop()
        self._truths.shutdown(wait=False, cancel_futures=True)
        await self.hub.emptied(LEAVE_TIMEOUT)

    def join(self, client: ClientQueue, since: tuple[str, int] | None = None) -> None:
        """Adds a client to the feed. Raises FeedRefused with the reason, also when the radar has failed."""
        if client.truth and not self.allow_truth:
            raise FeedRefused("truth: this server does not send it; it must be started with --truth")
        if self.stopping:
            raise FeedRefused(STOPPING)
        if self.transmitter.state.fault:
            raise FeedRefused(f"the radar has stopped: {self.transmitter.state.fault}; give it another scene")
        self.hub.join(client, since)
        if client.view.sources:
            self.transmitter.pacer.interrupt()  # what waits to be sent does not tell its sources
        if self.transmitter.pacer.held and len(self.hub.clients) >= self._wait_for:
            self.transmitter.pacer.release()
        encoding = client.view.encoding
        log_event("client joined", radar=self.identity, client=client.number, encoding=encoding, mode=client.mode)

    def follow_truth(self, radiometric: bool = False) -> Follower:
        """Returns a client of the truth, also of the power of each body. Raises FeedRefused with the reason."""
        if self.stopping:
            raise FeedRefused(STOPPING)
        return self.truth_stream.join(radiometric)

    def leave(self, client: ClientQueue) -> None:
        """Removes a client from the feed."""
        self.hub.leave(client)
        log_event("client left", radar=self.identity, client=client.number, spokes=client.delivered, lost=client.lost)

    async def swap(self, scene_request: SceneRequest, job: str | None = None) -> tuple[str, SpokeSourceInfo]:
        """Prepares another scene beside the running one and lets its radars take over from all of this group; returns the epoch
        and what is known of the spoke source of this one, or of the scene's first radar where it has not this one.

        Of several requests the last one wins. job: name of the preparation. Raises what Preparations.workers raises, and
        SceneError where another group has a radar of the same id; the running scene then goes on.
        """

        request, identities = self.group.request(), list[str]()

        def others(scene: SceneOutline) -> dict[str, SceneRequest]:
            identities[:] = self.group.identities_in(scene)
            self.stations.check(self.group, identities)
            return {radar: replace(scene_request, radar=radar) for radar in scene.radar_ids[1:]}

        prepared = await self.preparations.workers(self._make_spoke_source, {"": scene_request}, job, others)
        return await self._let_take_over(request, dict(zip(identities, prepared.values(), strict=True)))

    async def _let_take_over(self, request: int, workers: Mapping[str, SpokeWorker]) -> tuple[str, SpokeSourceInfo]:
        """Lets prepared radars take over from all of this group; returns as `swap`."""
        new, held = list[Station](), self.group.clock.held
        pace = self.stations[self.group.identities[0]].settings.pace

        def begin(identity: str, worker: SpokeWorker) -> Transmitter:
            station = Station(
                identity, worker.spoke_source, self._make_spoke_source, settings=Settings(pace=pace), worker=worker,
                failed=self.failed, sinks=self.stations.sinks(identity), wait_for=self._wait_for if held else 0, **self._options,
            )  # fmt: skip
            station.preparations, station.stations = self.preparations, self.stations
            new.append(station)
            return station.transmitter

        stopping = any(station.stopping for station in self.stations.values())
        epochs = self.group.switch_to(request, workers, begin, stopping=stopping)
        await self.stations.exchange(self.group, new)
        identity = self.identity if self.identity in workers else next(iter(workers))
        return epochs[identity], workers[identity].spoke_source.info

    async def prepare(self, scene_request: SceneRequest, job: str | None = None) -> SceneSpokeSource:
        """Returns a scene as this radar would run it. Raises what `Preparations.spoke_source` raises."""
        return await self.preparations.spoke_source(self._make_spoke_source, scene_request, job)

    async def change(self, requested: Mapping[str, Any]) -> None:
        """Changes the requested controls; a value that is refused changes nothing.

        A change of a spoke source control prepares the scene anew, which then goes on with simulated time. Of several such
        changes the last one wins. Raises ControlError, and SceneError where such a scene is not
        valid.
        """
        changed_settings(self.settings, self.epoch.info.scene, requested)  # refuses before the scene changes
        if needs_new_spoke_source(self.epoch.info.scene, requested):
            await self._go_on(requested)
        self.transmitter.pacer.set(changed_settings(self.settings, self.epoch.info.scene, requested))
        pace = requested.get("pace", {})
        if pace.get("state") == "step":
            self.transmitter.pacer.step(pace["steps"])

    async def _go_on(self, requested: Mapping[str, Any]) -> None:
        """Prepares the running scene anew with other engine controls, and lets it go on so. Of several such changes the last one
        wins; a scene that was requested later keeps its own, one that was requested earlier begins first."""
        request = self._change = self.group.request()
        supervisor, leads = self.transmitter.supervisor, 1.0
        while self._is_last(request):
            running = supervisor.pending_spoke_source
            if supervisor.pending and not running.scene_request.goes_on:
                await asyncio.sleep(LOOK)
                continue
            if (scene_request := changed_request(self.settings, running, requested)) is None:
                return
            with contextlib.suppress(SceneChanged):
                scene_requests = {self.identity: replace(scene_request, goes_on=True)}
                begin = partial(self.transmitter.going_on, leads)
                workers = await self.preparations.workers(self._make_spoke_source, scene_requests, begin=begin)
                with contextlib.ExitStack() as unless_taken:
                    unless_taken.callback(workers[self.identity].stop)
                    if self._is_last(request) and self.transmitter.go_on_with(workers[self.identity]):
                        unless_taken.pop_all()
                        return
                leads = min(2.0 * leads, MAX_LEADS)

    def _is_last(self, request: int) -> bool:
        """Whether no other change has come since this one, nor a scene that was requested later."""
        return not self.stopping and self._change == request and not self.group.has_met_after(request)

    async def truth(self, at: float | None = None) -> Truth:
        """Returns the state of everything at `at` [s of simulation], by default now. Raises SpokeSourceFault."""
        time = self.transmitter.state.simulated if at is None else at
        return await asyncio.get_running_loop().run_in_executor(self._truths, self.epoch.spoke_source.truth, time)

    def controls(self) -> dict[str, Any]:
        """Returns the state of all controls, as REST and the feed give it."""
        return controls_state(
            self.settings, self.epoch.info.scene, self.transmitter.supervisor.pending_spoke_source.info.scene
        )

    def radar_info(self, epoch: Epoch) -> RadarInfo:
        """Returns the description of this radar in an epoch."""
        controls = self.controls()
        return RadarInfo(self.identity, self.name, epoch, self.transmitter.state.simulated, controls, self.allow_truth)

    def _log_restart(self, reason: str) -> None:
        log_event("engine restarted", logging.WARNING, radar=self.identity, reason=reason)

    def _report_failure(self, reason: str) -> None:
        log_event("radar failed", logging.ERROR, radar=self.identity, reason=reason)
        self.failed()


class Stations(UserDict[str, Station]):
    """The radars of a service, by their ids; those of a scene come and go with it. Belongs to the event loop, but for `of`.

    sinks: returns those of the ports for a radar; came, went: called with a radar that has begun, and with one that ends.
    """

    def __init__(self, stations: Iterable[Station] = ()) -> None:
        self.sinks: Callable[[str], Sequence[SpokeSink]] = lambda identity: ()
        self.came: Callable[[Station], None] = lambda station: None
        self.went: Callable[[Station], None] = lambda station: None
        self._changing, self._ending = asyncio.Lock(), dict[asyncio.Task[None], Station]()
        super().__init__(
            {station.identity: station for station in stations}
        )  # `data` is replaced whole: other threads read it

    def of(self, identity: str | None) -> Station | None:
        """Returns the radar of that id, None where it is not on the air; without an id the first one. From any thread."""
        everyone = self.data
        return next(iter(everyone.values()), None) if identity is None else everyone.get(identity)

    def add(self, station: Station) -> None:
        """Adds a radar, before the service starts. Raises SceneError where another one has its id."""
        self.check(None, [station.identity])
        self.data = {**self.data, station.identity: station}

    def check(self, group: RadarGroup | None, identities: Iterable[str]) -> None:
        """Raises SceneError where a radar that is not of this group has one of these ids."""
        for identity in identities:
            if identity in self and self[identity].group is not group:
                raise SceneError(
                    f'radar.id: "{identity}" is the id of two radars; ids are unique on a server: change one, or serve the '
                    "scenes apart"
                )

    async def exchange(self, group: RadarGroup, new: Sequence[Station]) -> None:
        """Starts the radars that a group has now and had not, and ends those that it has no more."""
        before = self.data
        everyone = before | {station.identity: station for station in new}
        kept = [station for station in everyone.values() if station.group is not group]
        kept += [everyone[identity] for identity in group.identities]
        self.data = {station.identity: station for station in sorted(kept, key=lambda station: station.group.number)}
        async with self._changing:
            await asyncio.gather(*(station.start() for station in new))
            for station in new:
                self.came(station)
            for station in before.values():
                if station not in kept:
                    self._end(station)

    def _end(self, station: Station) -> None:
        radars = ", ".join(station.group.identities)
        station.end = f"radar {station.identity} has ended: another scene runs, with {radars}"
        station.ended.set()
        self.went(station)
        ending = asyncio.create_task(station.stop(station.end))
        self._ending[ending] = station
        ending.add_done_callback(self._ending.pop)

    async def stop(self) -> None:
        """Ends all radars."""
        for station in self._ending.values():
            station.hub.close(STOPPING, STOP_DRAIN)
        await asyncio.gather(*(station.stop() for station in self.data.values()))
        if self._ending:
            await asyncio.wait(self._ending, timeout=LEAVE_TIMEOUT)
