"""One radar on the air: a transmitter in its own threads, a hub on the event loop, and what REST asks of both."""

import asyncio
import logging
import time
from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np

from radar_service.records import Truth
from radar_service.scene.convert import scene_at_rpm
from radar_service.scene.world import Scene
from radar_service.stream import messages, wire
from radar_service.stream.ahead import RESTARTS, Ahead, prepared
from radar_service.stream.hub import Batch, Hub, Refused
from radar_service.stream.journal import note
from radar_service.stream.mailbox import Client, Mode, View
from radar_service.stream.messages import Engine
from radar_service.stream.outlet import Epoch
from radar_service.stream.pace import KEEPING_UP
from radar_service.stream.transmitter import Settings, Transmitter

Factory = Callable[[Scene], Engine]
LEAVE_TIMEOUT = 2.0  # s for clients to take their bye
STOP_TIMEOUT = 3.0  # s to wait for each thread


class Station:
    """One radar. All methods are for the event loop, except those that the transmitter calls."""

    def __init__(
        self,
        identity: str,
        engine: Engine,
        factory: Factory,
        *,
        name: str | None = None,
        settings: Settings | None = None,
        allow_truth: bool = False,
        clock: Callable[[], float] = time.monotonic,
        restarts: int = RESTARTS,
        failed: Callable[[], None] = lambda: None,
    ) -> None:
        """restarts: how often an engine that dies is replaced, see transmitter; failed: called when it is not any more."""
        self.identity, self.name, self.allow_truth = identity, name or f"radar {identity}", allow_truth
        self.hub = Hub(clock)
        self.transmitter = Transmitter(engine, settings or Settings(), self, clock, factory, restarts)
        self._factory, self.failed = factory, failed
        self._swapping = asyncio.Lock()
        self._stopping = False
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def engine(self) -> Engine:
        """The engine that runs."""
        return self.transmitter.epoch.engine

    @property
    def settings(self) -> Settings:
        """What REST has set."""
        return self.transmitter.settings

    async def start(self) -> None:
        """Begin to compute and to send; clients are taken from here on."""
        self._loop = asyncio.get_running_loop()
        self._open_epoch(self.transmitter.epoch)
        self.transmitter.start()

    async def stop(self, reason: str = "the server is stopping") -> None:
        """Say bye to every client and end the threads."""
        self._stopping = True
        self.hub.close(reason)
        await asyncio.to_thread(self.transmitter.stop, STOP_TIMEOUT)
        await self.hub.emptied(LEAVE_TIMEOUT)

    def join(self, client: Client, since: tuple[str, int] | None = None) -> None:
        """Add a client to the feed. Raises Refused with the reason, also when the engine has died."""
        if client.truth and not self.allow_truth:
            raise Refused("truth: this server does not give it; it must be started with --truth")
        if self._stopping:
            raise Refused("the server is stopping")
        if self.transmitter.fault:
            raise Refused(f"the radar has stopped: {self.transmitter.fault}; give it another scene")
        self.hub.join(client, since)
        note("client joined", radar=self.identity, client=client.number, encoding=client.view.encoding, mode=client.mode)

    def leave(self, client: Client) -> None:
        """Remove a client from the feed."""
        self.hub.leave(client)
        note("client left", radar=self.identity, client=client.number, spokes=client.delivered, lost=client.lost)

    async def swap(self, scene: Scene) -> tuple[str, Engine]:
        """Prepare another scene beside the running one and let it take over; gives its epoch and engine.

        Whatever the factory raises comes out and the running scene goes on.
        """
        async with self._swapping:
            ahead = await asyncio.to_thread(self._prepare, scene)
            return self.transmitter.follow_with(ahead), ahead.engine

    async def plan(self, scene: Scene) -> dict[str, Any]:
        """What this radar would model of a scene, in plain data. Whatever the factory raises comes out."""
        async with self._swapping:
            return dict((await asyncio.to_thread(self._factory, scene)).plan.as_dict())

    async def turn(self, rpm: float) -> tuple[str, Engine]:
        """The same scene at another rate of rotation, as another scene.

        Simulated time starts again at 0, so that the spokes are those of a scene written with that rpm. Raises SceneError
        where such a scene would be refused.
        """
        return await self.swap(scene_at_rpm(self.transmitter.coming.scene, rpm))

    def truth(self, at: float | None = None) -> Truth:
        """The state of everything at `at` [s of simulation], by default now."""
        return self.engine.truth(self.transmitter.simulated if at is None else at)

    def controls(self) -> dict[str, Any]:
        """The settings as REST and the feed say them; rpm is that of the engine to come, where one is."""
        radar, settings = self.engine.scene.radar, self.settings
        return {
            "transmit": settings.transmit,
            "range_m": min(settings.range or radar.range_max, radar.range_max),
            "gain": settings.video.gain,
            "sea": settings.video.sea,
            "rain": settings.video.rain,
            "rpm": 60.0 / self.transmitter.coming.scene.radar.rotation_period,
            "pace": settings.pace.as_dict(),
        }

    def state(self) -> str:
        """failed, restarting, paused, behind, standby or running."""
        if self.transmitter.fault:
            return "failed"
        if self.transmitter.reviving:
            return "restarting"
        if self.settings.pace.state == "pause":
            return "paused"
        factor, reached = self.settings.pace.factor, self.transmitter.reached()
        if np.isfinite(factor) and reached is not None and reached < KEEPING_UP * factor:
            return "behind"
        return "running" if self.settings.transmit else "standby"

    @property
    def ready(self) -> bool:
        """Whether clients are taken and spokes come, or would but for the pause or standby that was asked for."""
        waiting = self.settings.pace.state == "pause" or not self.settings.transmit
        return (
            not self._stopping
            and not self.transmitter.fault
            and not self.transmitter.reviving
            and (waiting or self.transmitter.sent > 0)
        )

    def health(self) -> dict[str, Any]:
        """How the radar does, in plain data."""
        clients = self.hub.clients
        return {
            "id": self.identity,
            "state": self.state(),
            "fault": self.transmitter.fault,
            "pace": self.settings.pace.as_dict(),
            "factor_reached": self.transmitter.reached(),
            "restarts": self.transmitter.restarts,
            "lag_s": self.transmitter.schedule.lag,
            "slips": self.transmitter.schedule.slips,
            "simulated_s": self.transmitter.simulated,
            "epoch": self.hub.epoch,
            "next": self.hub.next,
            "spokes_sent": self.transmitter.sent,
            "spokes_lost": self.hub.lost + sum(client.lost for client in clients),
            "clients": len(clients),
            "views": len(self.hub.views),
        }

    def figures(self) -> dict[str, float | None]:
        """The figures of `metrics`, by name; None: not known yet."""
        hub, transmitter, clients = self.hub, self.transmitter, list(self.hub.clients)
        return {
            "radar_azimuths": transmitter.sent,
            "radar_spokes_lost": hub.lost + sum(client.lost for client in clients),
            "radar_gaps": hub.gaps + sum(client.gaps for client in clients),
            "radar_bytes": hub.bytes + sum(client.bytes for client in clients),
            "radar_slips": transmitter.schedule.slips,
            "radar_restarts": transmitter.restarts,
            "radar_lag_seconds": transmitter.schedule.lag,
            "radar_real_time_factor": transmitter.reached(),
            "radar_factor_asked": self.settings.pace.factor,
            "radar_views": len(hub.views),
        }

    # The transmitter's outlet, called from its thread.

    def open_epoch(self, epoch: Epoch) -> None:
        """Tell the clients of a new epoch."""
        self._on_loop(self._open_epoch_soon(epoch))

    def views(self) -> tuple[View, ...]:
        """What clients look at."""
        return self.hub.views

    def wants_truth(self) -> bool:
        """Whether a client has asked for it."""
        return self.hub.truth_wanted

    def publish(self, batch: Batch) -> None:
        """Hand spokes to the clients; returns when they are queued, lossless ones included."""
        self._on_loop(self.hub.publish(batch))

    def died(self, reason: str) -> None:
        """Tell the clients that no more spokes come."""
        note("radar failed", logging.ERROR, radar=self.identity, reason=reason)
        self._on_loop(self._close_soon(f"the radar has stopped: {reason}"))
        self.failed()

    def _on_loop(self, call: Coroutine[Any, Any, None]) -> None:
        assert self._loop is not None, "start() comes first"
        asyncio.run_coroutine_threadsafe(call, self._loop).result()

    def missed(self, epoch: str, count: int, reason: str) -> None:
        """Announce spokes that will never come."""
        self._on_loop(self._skip_soon(epoch, count, reason))

    def restarting(self, reason: str) -> None:
        """Note that an engine died and is being replaced."""
        note("engine restarted", logging.WARNING, radar=self.identity, reason=reason)

    async def _skip_soon(self, epoch: str, count: int, reason: str) -> None:
        self.hub.skip(epoch, count, reason)

    async def _open_epoch_soon(self, epoch: Epoch) -> None:
        self._open_epoch(epoch)

    async def _close_soon(self, reason: str) -> None:
        self.hub.close(reason)

    def _open_epoch(self, epoch: Epoch) -> None:
        def hello(view: View, mode: Mode) -> bytes:
            to, now = epoch.layout(view.bins), self.transmitter.simulated
            greeting = messages.hello(
                epoch.name, self.identity, self.name, epoch.engine, view.encoding, to, now, self.controls(), mode,
                self.allow_truth,
            )  # fmt: skip
            return wire.pack(greeting | {"view": view.as_dict()})

        self.hub.open_epoch(epoch.name, hello)
        note("epoch", radar=self.identity, epoch=epoch.name, scene=epoch.engine.scene.name)

    def _prepare(self, scene: Scene) -> Ahead:
        return prepared(self._factory(scene))
