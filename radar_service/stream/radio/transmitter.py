"""The thread that sends: takes blocks from the engine's worker, waits until they are due, hands them to the sinks.

When an order acts:
- gain, sea, rain, transmit, pace: from the next batch on. Standby sends no spokes and uses no numbers; time goes on.
- range: a new epoch at once. Another scene: a new epoch when the running scan ends; at once while paused or failed,
  and where the world has several radars, which all begin it together.
- commands: from the next spoke on; the blocks that the engine has computed beyond it are dropped. Those that come while the
  next spokes are computed wait until these are sent, so that many commands do not stop the feed.
- labels and powers of sources: from the next spoke on, when the first client asks; the blocks beyond it come again with them.
- rpm: a new epoch at the end of a scan that was agreed before its engine was prepared (`handover`); until then nothing is
  sent beyond that scan.
- the engine fails: another one continues the same epoch with the next scan, and the spokes between become a gap. If that
  happens too often the radar fails and the sinks are closed; the next scene restarts it.
"""

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from radar_service.cell_sources import SourceRequest
from radar_service.radar.parameters import Origin
from radar_service.records import SpokeBlock
from radar_service.stream.radio.command_queue import CommandQueue
from radar_service.stream.radio.engine_supervisor import RESTARTS, EngineSupervisor, RestartLimiter
from radar_service.stream.radio.handover import Handover
from radar_service.stream.radio.pacer import Pacer
from radar_service.stream.radio.pacing import batch_spokes
from radar_service.stream.radio.prefetch import EngineFault, EngineWorker
from radar_service.stream.radio.world_clock import WorldClock
from radar_service.stream.settings import Settings
from radar_service.stream.source import MakeSource, SpokeSource
from radar_service.stream.spokes import Epoch, SpokeBatch, SpokeSink, new_epoch_name
from radar_service.types import Singles

BLOCK_TIMEOUT = 0.25  # s after which the transmitter reads the orders again


def _ignore(reason: str) -> None:
    pass


class Transmitter:
    """Sends the spokes of one radar to its sinks. Orders go to `pacer` and `switch_to`, from any thread.

    The transmitter's thread alone writes epoch, fault, sent and simulated; others only read them.

    epoch: the running one.
    fault: why the radar has failed, None while it runs.
    sent: spokes since the start.
    simulated: time of the next spoke [s].
    commands: those that wait to be carried out.
    engines: the running engine and its replacements.
    """

    def __init__(
        self, engine: SpokeSource, settings: Settings, sinks: Sequence[SpokeSink], clock: Callable[[], float],
        make_engine: MakeSource, *, restarts: int = RESTARTS, world: WorldClock | None = None,
        on_restart: Callable[[str], None] = _ignore, on_failure: Callable[[str], None] = _ignore, held: bool = False,
        sources: Callable[[], SourceRequest] = SourceRequest,
    ) -> None:  # fmt: skip
        """make_engine: makes another engine by the order of a failed one, at most `restarts` times within RESTART_WINDOW.

        world: its clock, which other radars may share; on_restart, on_failure: called with the reason, from the transmitter's
        thread; held: until `pacer.release`; sources: what the sinks need of the sources of the next spokes.
        """
        self.pacer = Pacer(settings, clock, world, held)
        self.engines = EngineSupervisor(engine, make_engine, RestartLimiter(restarts, clock))
        self.epoch = Epoch(new_epoch_name(), engine, settings.range)
        self.fault: str | None = None
        self.sent = 0
        self.simulated = 0.0
        self.commands = CommandQueue(self.pacer.interrupt)
        self._may_command = True  # whether a spoke was sent since the last commands, which would otherwise stop the feed
        self.handover = Handover()
        self._sinks = tuple(sinks)
        self._on_restart, self._on_failure, self._sources = on_restart, on_failure, sources
        self._spokes_done = 0  # of the running engine's scene, sent or not, from t = 0
        self._number = 0  # of the next spoke in this epoch
        self._last: tuple[int, Singles] | None = None  # number from t = 0 and power of the newest spoke, sent or not
        self._thread = threading.Thread(target=self._run, name="radar transmitter", daemon=True)

    def start(self) -> None:
        """Opens the first epoch on every sink and starts both threads."""
        self._open(self.epoch)
        self.engines.start()
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """Ends both threads and waits for each at most `timeout` [s]."""
        self.pacer.stop()
        self.commands.close("the server is stopping")
        self.engines.stop()
        if self._thread.ident is not None:
            self._thread.join(timeout)
        self.engines.stop(timeout)

    def agree(self, lead: float) -> Origin:
        """Returns where an engine of the running scene begins that is ready in some `lead` [s of simulation]; then `settle`."""
        idle = self.pacer.idle or self.fault is not None
        origin = self.handover.agree(self.epoch.engine.scene.radar, self._spokes_done, idle, lead)
        self.pacer.interrupt()
        return origin

    def settle(self) -> None:
        """Ends a request that has agreed, after `switch_to` or without."""
        self.handover.settle()
        self.pacer.interrupt()

    def switch_to(self, worker: EngineWorker) -> str:
        """Lets a prepared engine take over; returns the name of its epoch. Of several calls the last one wins."""
        name = self.engines.switch_to(worker)
        self.pacer.interrupt()
        return name

    def _run(self) -> None:
        while not self.pacer.stopping:
            try:
                self._transmit()
            except Exception as error:  # of any kind: the clients must be notified
                if not self.pacer.stopping:
                    reason = str(error) if isinstance(error, EngineFault) else f"{type(error).__name__}: {error}"
                    if not self._restart(reason):
                        self._fail(reason)

    def _transmit(self) -> None:
        while not self.pacer.stopping:
            self._apply_pending()
            block = self.engines.worker.take(BLOCK_TIMEOUT)
            if block is None:
                if self._may_command:
                    self._obey()
                continue
            self._send_block(block)
            ends_scan = block.index + len(block) == self.epoch.engine.scene.radar.azimuths
            if self.engines.has_pending and ends_scan and self.handover.at is None:
                self._take_over()

    def _send_block(self, block: SpokeBlock) -> None:
        at = 0
        while at < len(block) and not self.pacer.stopping:
            if self._apply_pending():
                return
            orders = self.pacer.orders()
            size = batch_spokes(orders.settings.pace.factor, self.epoch.engine.scene.radar.spoke_period)
            part = block.part(at, at + orders.spokes(block, at, min(size, len(block) - at)))
            if self._request_sources(part):
                return
            if (self._may_command or not self.pacer.is_due(part, orders)) and self._obey():
                return
            end = part.first + len(part)
            if self.pacer.wait_until_due(part, orders) and self.handover.claim(part.first, end):
                self._send(part, orders.settings)
                at += len(part)

    def _request_sources(self, part: SpokeBlock) -> bool:
        """Has the engine tell what the sinks need of the sources; returns whether these spokes come again with it."""
        worker = self.engines.worker
        request = worker.engine.sources.to_request(self._sources())
        if request == worker.requested:
            return False
        return worker.request_sources(request, part.first)

    def _obey(self) -> bool:
        """Carries out the commands that wait, from the next spoke on; returns whether any was accepted."""
        spoke, worker = self._spokes_done, self.engines.worker
        time = self.epoch.engine.scene.radar.time_of_spokes(float(spoke))
        command = partial(worker.command, spoke)
        accepted = [waiting.carry_out(time, command) for waiting in self.commands.take()]
        self._may_command &= not any(accepted)
        return any(accepted)

    def _send(self, part: SpokeBlock, settings: Settings) -> None:
        if settings.transmit:
            batch = SpokeBatch(self.epoch, self._number, part, settings.video, self._before(part))
            for sink in self._sinks:
                sink.send(batch)
            self._number += len(part)
            self.sent += len(part)
        self._spokes_done = part.first + len(part)
        self._may_command = True
        self._last = self._spokes_done - 1, part.power[-1].copy()
        self.pacer.sent(float(part.time[-1]))
        self.simulated = float(part.time[-1]) + self.epoch.engine.scene.radar.spoke_period

    def _before(self, part: SpokeBlock) -> Singles | None:
        """The power of the spoke before a part; None where it is the first one or follows a gap."""
        return self._last[1] if self._last and self._last[0] == part.first - 1 else None

    def _apply_pending(self) -> bool:
        """Applies what does not wait for the end of the scan; returns whether the present block is obsolete."""
        if self.handover.is_due(self._spokes_done):
            self.pacer.wait_for(lambda: not self.handover.is_open)
            self.handover.end(self._spokes_done)
            if self.engines.has_pending:
                self._take_over()
                return True
        if self.engines.has_pending and (self.pacer.is_outdated or (self.pacer.idle and self.handover.at is None)):
            self._take_over()
            return True
        if self.pacer.settings.range != self.epoch.range:
            self._open(replace(self.epoch, name=new_epoch_name(), range=self.pacer.settings.range))
        return False

    def _take_over(self) -> None:
        name, engine = self.engines.take_over()
        radar, self._last = engine.scene.radar, None
        self.pacer.begin(radar.origin.time)
        self.simulated, self._spokes_done = radar.origin.time, radar.origin.scan * radar.azimuths
        self.handover.end(self._spokes_done)
        self._open(Epoch(name, engine, self.pacer.settings.range))
        self.fault = None
        self.commands.close(None)

    def _open(self, epoch: Epoch) -> None:
        self.epoch, self._number = epoch, 0
        for sink in self._sinks:
            sink.open_epoch(epoch)

    def _restart(self, reason: str) -> bool:
        """Continues with the next scan and another engine of the same scene; returns whether that has worked."""
        azimuths = self.epoch.engine.scene.radar.azimuths
        scan = self._spokes_done // azimuths + 1  # the present scan would make the next engine fail too
        cause = self.engines.restart(reason, scan, self._on_restart)
        if cause is None:
            return False
        missed = scan * azimuths - self._spokes_done if self.pacer.settings.transmit else 0
        self.epoch = replace(self.epoch, engine=self.engines.worker.engine)
        self.pacer.restart_schedule()
        for sink in self._sinks if missed else ():
            sink.skip(self.epoch.name, missed, f"the radar was started again after: {cause}")
        self._number += missed
        self._spokes_done = scan * azimuths
        return True

    def _fail(self, reason: str) -> None:
        self.fault = reason
        self.pacer.fail()
        self.commands.close(f"the radar has stopped: {reason}; give it another scene")
        self.engines.worker.stop()
        for sink in self._sinks:
            sink.close(reason)
        self._on_failure(reason)
        self.pacer.wait_for(lambda: self.engines.has_pending)
        if self.engines.has_pending:
            self._take_over()
