"""The thread that sends: takes blocks from the engine's worker, waits until they are due, hands them to the sinks.

When an order acts:
- gain, sea, rain, transmit, pace: from the next batch on. Standby sends no spokes and uses no numbers; time goes on.
- range: a new epoch at once. Another scene: a new epoch when the running scan ends; at once while paused or failed,
  and where the world has several radars, which all begin it together.
- commands: another thread (`command_worker`) carries them out. Spokes that a command changes are dropped, and come anew.
- labels and powers of sources: from the next spoke on, when the first client asks; the blocks beyond it come again with them.
- rpm: a new epoch at the end of a scan that is agreed when its engine is prepared (`handover`).
- the engine fails: another one continues the same epoch with the next scan, and the spokes between become a gap. If that
  happens too often the radar fails and the sinks are closed; the next scene restarts it. An engine that is ready takes over.
"""

import math
import threading
from collections.abc import Callable, Sequence
from functools import partial

from radar_service.numerics.types import Singles
from radar_service.radar.parameters import Origin
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.spokes import SpokeBlock
from radar_service.scene.commands import Command
from radar_service.stream.radio.command_pace import CommandPace
from radar_service.stream.radio.command_worker import CommandQueue, CommandWorker, Steered
from radar_service.stream.radio.engine_supervisor import RESTARTS, EngineSupervisor, RestartLimiter
from radar_service.stream.radio.handover import Handover, SceneChanged, wait_for_engine
from radar_service.stream.radio.pacer import Pacer
from radar_service.stream.radio.pacing import batch_spokes
from radar_service.stream.radio.prefetch import EngineFault, EngineWorker
from radar_service.stream.radio.world_clock import WorldClock
from radar_service.stream.settings import Settings
from radar_service.stream.source import MakeSource, OrderedSource, SceneOrder
from radar_service.stream.spokes import Epoch, RadarInfo, SinkGroup, SpokeBatch, SpokeSink, new_epoch_name

BLOCK_TIMEOUT = 0.25  # s after which the transmitter reads the orders again
Report = Callable[[str], None]


class Transmitter:
    """Sends the spokes of one radar to its sinks. Orders go to `pacer` and `switch_to`, from any thread.

    The transmitter's thread alone writes epoch, fault, sent and simulated; others only read them.

    epoch: the running one.
    fault: why the radar has failed, None while it runs.
    sent: spokes since the start; simulated: time of the next spoke [s].
    commands: those that wait for the command worker.
    engines: the running engine and its replacements.
    """

    def __init__(
        self, engine: OrderedSource, settings: Settings, sinks: Sequence[SpokeSink], clock: Callable[[], float],
        make_engine: MakeSource, *, restarts: int = RESTARTS, command_worker: CommandWorker | None = None,
        on_restart: Report = lambda reason: None, on_failure: Report = lambda reason: None, held: bool = False,
        sources: Callable[[], SourceRequest] = SourceRequest, describe: Callable[[Epoch], RadarInfo] = RadarInfo.unnamed,
    ) -> None:  # fmt: skip
        """make_engine: makes another engine by the order of a failed one, at most `restarts` times within RESTART_WINDOW.

        command_worker: of its world, whose clock other radars may share; on_restart, on_failure: called with the reason, from the
        transmitter's thread; held: until `pacer.release`; sources: what the sinks need of the sources of the next spokes;
        describe: the radar in an epoch that opens.
        """
        self._command_worker = command_worker or CommandWorker(WorldClock())
        self._world = self._command_worker.clock
        self.pacer = Pacer(settings, clock, self._world, held)
        self.engines = EngineSupervisor(engine, make_engine, RestartLimiter(restarts, clock), self._world.changed)
        self.epoch = self._epoch(new_epoch_name(), settings.range)
        self.fault: str | None = None
        self.sent, self.simulated = 0, 0.0
        self.commands = CommandQueue(self._world.let_command)
        self._unsent = 0  # number of the first spoke that was not given to the sinks, from t = 0
        self._newest = -math.inf  # time of the last one that was [s]
        self._command_pace = CommandPace(clock)
        self.handover = Handover()
        self._sinks = SinkGroup(sinks)
        self._on_restart, self._on_failure, self._sources, self._describe = on_restart, on_failure, sources, describe
        self._spokes_done = 0  # of the running engine's scene, sent or not, from t = 0
        self._number = 0  # of the next spoke in this epoch
        self._last: tuple[int, Singles] | None = None  # number from t = 0 and power of the newest spoke, sent or not
        self._thread = threading.Thread(target=self._run, name="radar transmitter", daemon=True)
        self._command_worker.join(self)

    def start(self) -> None:
        """Opens the first epoch on every sink and starts both threads."""
        self._open(self.epoch)
        self.engines.start()
        self._command_worker.start()
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """Ends both threads and waits for each at most `timeout` [s]."""
        self.pacer.stop()
        self.commands.close("the server is stopping")
        self.engines.stop()
        if self._thread.ident is not None:
            self._thread.join(timeout)
            self._command_worker.stop(timeout)
        self.engines.stop(timeout)

    @property
    def is_commanded(self) -> bool:
        """As CommandedRadar."""
        return self.fault is None and not self.pacer.stopping

    @property
    def takes_commands(self) -> bool:
        """As CommandedRadar: enough was sent since the last ones, or nothing can be sent now."""
        cannot_send = self.engines.restarting or self.handover.is_due(self._unsent)
        return cannot_send or self._command_pace.allows(self.pacer.waiting)

    @property
    def steered(self) -> Steered | None:
        """As CommandedRadar."""
        if not self.pacer.is_outdated:
            return Steered(self.engines.worker, self._unsent, self._newest)
        pending = self.engines.pending
        return None if pending is None else Steered(pending, 0, -math.inf)

    def commanded(self) -> None:
        """As CommandedRadar."""
        self._command_pace.commanded()
        self.pacer.waiting = False

    def agree(self, request: int, order: SceneOrder, lead: float) -> tuple[Origin, Sequence[Command]]:
        """Returns where the engine of an order of the running scene begins that is ready in `lead` [s], and the commands so far.

        request: its number, for `hand_over`. Raises SceneChanged where another scene runs or is about to, and Overtaken.
        """
        with self._world.changed:  # while no engine takes over
            running = self.engines.worker
            if self.pacer.is_outdated or not self.engines.keep_scene_of(order):
                raise SceneChanged
            idle = self.pacer.idle or self.fault is not None
            origin = self.handover.agree(request, running.engine.info.radar, self._unsent, idle, lead * self.pacer.speed)
            self.engines.drop_pending()  # of a request that this one has overtaken
            self.pacer.interrupt()
            return origin, tuple(running.commands)

    def hand_over(self, request: int, worker: EngineWorker) -> bool:
        """Lets the engine of a request take over where that has agreed; returns False where it is late."""
        with self._world.changed:
            if is_agreed := self.handover.is_agreed(request):
                self.engines.switch_to(worker)
                self.pacer.interrupt()
        return is_agreed

    def switch_to(self, worker: EngineWorker) -> str:
        """Lets the prepared engine of another scene take over; returns the name of its epoch. The last call wins."""
        self.handover.cancel()
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
                    if not (self._restart(reason) or self._take_over()):
                        self._fail(reason)

    def _transmit(self) -> None:
        while not self.pacer.stopping:
            self._apply_pending()
            block = self.engines.worker.take(BLOCK_TIMEOUT)
            if block is None:
                continue
            self._send_block(block)
            sent_all = self._spokes_done == block.first + len(block)
            ends_scan = sent_all and block.index + len(block) == self.epoch.info.radar.azimuths
            if self.engines.has_pending and ends_scan and self.handover.at is None:
                self._take_over()

    def _send_block(self, block: SpokeBlock) -> None:
        at = 0
        while at < len(block) and not self.pacer.stopping:
            if self._apply_pending():
                return
            known = self.engines.worker.known_part(block)
            if known is None or len(known) <= at:
                return  # the rest comes again, as commanded
            block, orders = known, self.pacer.orders()
            size = batch_spokes(orders.settings.pace.factor, self.epoch.info.radar.spoke_period)
            part = block.part(at, at + orders.spokes(block.time[at:], min(size, len(block) - at)))
            if self._request_sources(part):
                return
            self._command_pace.computed()
            if self.pacer.wait_until_due(part.time, orders, partial(self._claim, part)):
                self._send(part, orders.settings)
                self._command_pace.given()
                at += len(part)

    def _request_sources(self, part: SpokeBlock) -> bool:
        """Has the engine tell what the sinks need of the sources; returns whether these spokes come again with it."""
        worker = self.engines.worker
        request = worker.engine.info.sources.to_request(self._sources())
        if request == worker.requested:
            return False
        return worker.request_sources(request, part.first)

    def _claim(self, part: SpokeBlock) -> bool:
        """Whether a part is to be sent now, as far as commands and handovers go; then commands act after it."""
        end = part.first + len(part)
        if self.engines.worker.known_part(part) is not part or not self.handover.claim(part.first, end):
            return False
        self._unsent, self._newest = end, self.epoch.info.radar.time_of_spokes(float(end - 1))
        self._command_pace.give(len(part))
        self._world.let_command()
        return True

    def _send(self, part: SpokeBlock, settings: Settings) -> None:
        if settings.transmit:
            batch = SpokeBatch(self.epoch, self._number, part, settings.video, self._before(part))
            self._number, self._spokes_done = self._number + len(part), part.first + len(part)  # where a sink fails, too
            self._sinks.send(batch)
            self.sent += len(part)
        self._spokes_done = part.first + len(part)
        self._last = self._spokes_done - 1, part.power[-1].copy()
        self.pacer.sent(float(part.time[-1]))
        self.simulated = float(part.time[-1]) + self.epoch.info.radar.spoke_period

    def _before(self, part: SpokeBlock) -> Singles | None:
        """The power of the spoke before a part; None where it is the first one or follows a gap."""
        return self._last[1] if self._last and self._last[0] == part.first - 1 else None

    def _apply_pending(self) -> bool:
        """Applies what does not wait for the end of the scan; returns whether the present block is obsolete."""
        if self.handover.is_due(self._spokes_done):
            wait_for_engine(self.handover, self.pacer, self.engines)
            if self._take_over():
                return True
        if self.engines.has_pending and (self.pacer.is_outdated or (self.pacer.idle and self.handover.at is None)):
            return self._take_over()
        if self.pacer.settings.range != self.epoch.range:
            self._open(self._epoch(new_epoch_name(), self.pacer.settings.range))
        return False

    def _take_over(self) -> bool:
        """Lets the pending engine take over, where there is one; returns whether it has."""
        taken = self.engines.take_over(self._begin)
        if taken is None:
            return False
        self._open(self._epoch(taken, self.pacer.settings.range))
        self.fault = None
        self.commands.close(None)
        return True

    def _begin(self, engine: OrderedSource) -> None:
        """Takes up the time and the spokes of an engine that has taken over. The clock's lock is held."""
        radar, self._last = engine.info.radar, None
        self.pacer.begin(radar.origin.time)
        self.simulated, self._spokes_done = radar.origin.time, radar.origin.scan * radar.azimuths
        self.handover.end(self._spokes_done)
        self._newest = self._newest if engine.order.goes_on else -math.inf
        self._go_on_from(self._spokes_done)

    def _go_on_from(self, spoke: int) -> None:
        """Lets commands act from a spoke on."""
        with self._world.changed:
            self._unsent = spoke
            self._command_pace.begin()
            self._world.let_command()

    def _epoch(self, name: str, range_max: float | None) -> Epoch:
        """An epoch of the running engine, with a display range [m]."""
        worker = self.engines.worker
        return Epoch(name, worker.engine, range_max, worker.commands, worker.engine.order)

    def _open(self, epoch: Epoch) -> None:
        self.epoch, self._number = epoch, 0
        self._sinks.open_epoch(self._describe(epoch))

    def _restart(self, reason: str) -> bool:
        """Continues with the next scan and another engine of the same scene; returns whether that has worked."""
        azimuths = self.epoch.info.radar.azimuths
        scan = self._spokes_done // azimuths + 1  # the present scan would make the next engine fail too
        self._go_on_from(scan * azimuths)
        cause = self.engines.restart(reason, scan, self._on_restart)
        if cause is None:
            return False
        missed = scan * azimuths - self._spokes_done if self.pacer.settings.transmit else 0
        self.epoch = self._epoch(self.epoch.name, self.epoch.range)
        self.pacer.restart_schedule()
        if missed:
            self._sinks.skip(self.epoch.name, self._number, missed, f"the radar was started again after: {cause}")
        self._number += missed
        self._spokes_done = scan * azimuths
        return True

    def _fail(self, reason: str) -> None:
        self.fault = reason
        self.pacer.fail()
        self.commands.close(f"the radar has stopped: {reason}; give it another scene")
        self.engines.worker.stop()
        self._sinks.close(reason)
        self._on_failure(reason)
        self.pacer.wait_for(lambda: self.engines.has_pending)
        if self.engines.has_pending:
            self._take_over()
