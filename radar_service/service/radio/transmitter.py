"""The thread that sends: takes blocks from the spoke source's worker, waits until they are due, hands them to the sinks.

What leads from one of its states to the next is in `transmitter_state`; each state has a method here, which returns the event.

When a change acts:
- gain, sea, rain, transmit, pace: from the next batch on. Standby sends no spokes and uses no numbers; time goes on.
- range: a new epoch at once; with a set that is sold it acts as rpm does. Another scene: a new epoch when the running scan ends;
  at once while paused or failed, and where the group has several radars, which all begin it together.
- commands: another thread (`command_worker`) carries them out. Spokes that a command changes are dropped, and come anew.
- labels and powers of sources: from the next spoke on, when the first client asks; the blocks beyond it come again with them.
- rpm: a new epoch when the scan of a spoke source begins that is prepared meanwhile; the running scan ends there.
- the spoke source fails: another one continues the same epoch with the next scan, and the spokes between become a gap. If that
  happens too often the radar fails and the sinks are closed; the next scene restarts it. A spoke source that is ready takes over.
"""

import math
import threading
from collections.abc import Callable, Sequence
from datetime import datetime
from functools import partial

import numpy as np

from radar_service.numerics.types import Singles
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio.command_worker import CommandWorker
from radar_service.service.radio.commanded_transmitter import CommandedTransmitter
from radar_service.service.radio.group_clock import GroupClock
from radar_service.service.radio.pacer import Pacer
from radar_service.service.radio.pacing import batch_spokes
from radar_service.service.radio.prefetch import SpokeSourceFault, SpokeWorker
from radar_service.service.radio.transmitter_state import Event, State, TransmitterState
from radar_service.service.radio.worker_supervisor import RESTARTS, RestartLimiter, WorkerSupervisor
from radar_service.service.scene_request import MakeSpokeSource, SceneSpokeSource
from radar_service.service.settings import Settings
from radar_service.service.spokes import Epoch, RadarInfo, SinkGroup, SpokeBatch, SpokeSink, new_epoch_name, whole_second
from radar_service.world.commands import Command

STOPPING = "the server is stopping"
LEAD = 1.0  # s from the choice of the scan that another rate of rotation begins with; some ten times what first spokes take
BLOCK_TIMEOUT = 0.25  # s after which the transmitter reads the run control again
Report = Callable[[str], None]


class SceneChanged(Exception):
    """The scene that a spoke source was to go on with does not run any more."""


class Transmitter:
    """Sends the spokes of one radar to its sinks. Changes of pace go to `pacer`, other scenes to `switch_to`, from any thread.

    The transmitter's thread alone writes epoch, state, sent and simulated; others only read them.

    epoch: the running one.
    state: what it does.
    sent: spokes since the start; simulated: time of the next spoke [s].
    commands: those that wait for the command worker.
    supervisor: the running spoke source and its replacements.
    """

    def __init__(
        self, source: SceneSpokeSource | SpokeWorker, settings: Settings, sinks: Sequence[SpokeSink], clock: Callable[[], float],
        make_spoke_source: MakeSpokeSource, *, restarts: int = RESTARTS, command_worker: CommandWorker | None = None,
        on_restart: Report = lambda reason: None, on_failure: Report = lambda reason: None, held: bool = False,
        sources: Callable[[], SourceRequest] = SourceRequest, describe: Callable[[Epoch], RadarInfo] = RadarInfo.unnamed,
        start_utc: datetime | None = None,
    ) -> None:  # fmt: skip
        """source: of spokes, or its worker where that computes already; make_spoke_source: makes another one by the scene
        request of a failed one, at most `restarts` times within RESTART_WINDOW.

        command_worker: of its group, whose clock other radars may share; on_restart, on_failure: called with the reason, from the
        transmitter's thread; held: until `pacer.release`; sources: what the sinks need of the sources of the next spokes;
        describe: the radar in an epoch that opens; start_utc: at simulated time 0, by default the present second.
        """
        self._start_utc = start_utc or whole_second()
        self._command_worker = command_worker or CommandWorker(GroupClock())
        self._group_clock = self._command_worker.clock
        self.pacer = Pacer(settings, clock, self._group_clock, held)
        self.supervisor = WorkerSupervisor(
            source, make_spoke_source, RestartLimiter(restarts, clock), self._group_clock.changed
        )
        self.epoch = self._epoch(new_epoch_name(), settings.range)
        self.state = TransmitterState()
        self.sent, self.simulated = 0, 0.0
        self._commanded = CommandedTransmitter(self.state, self.pacer, self.supervisor, clock)
        self.commands = self._commanded.commands
        self._sinks = SinkGroup(sinks)
        self._on_restart, self._on_failure, self._sources, self._describe = on_restart, on_failure, sources, describe
        self._block: SpokeBlock | None = None  # what is still to be sent of the one that was taken last
        self._spokes_done = 0  # of the running spoke source's scene, sent or not, from t = 0
        self._number = 0  # of the next spoke in this epoch
        self._last: tuple[int, Singles] | None = None  # number from t = 0 and power of the newest spoke, sent or not
        self._thread = threading.Thread(target=self._run, name="radar transmitter", daemon=True)
        self._command_worker.join(self._commanded)

    def start(self) -> None:
        """Opens the first epoch on every sink and starts both threads."""
        self._open(self.epoch)
        self.supervisor.start()
        self._command_worker.start()
        self.state.on(Event.START)
        self._thread.start()

    def leave(self) -> None:
        """Leaves the group, and sends nothing more; `stop` comes next."""
        self._group_clock.leave(self.pacer)
        self._command_worker.leave(self._commanded)
        self.pacer.stop()

    def stop(self, timeout: float, reason: str = STOPPING) -> None:
        """Ends both threads and waits for each at most `timeout` [s]. reason: for those whose commands wait."""
        self.pacer.stop()
        self.commands.close(reason)
        self.supervisor.stop()
        if self._thread.ident is not None:
            self._thread.join(timeout)
            self._command_worker.stop(timeout)
        self.supervisor.stop(timeout)

    @property
    def fault(self) -> str | None:
        """Why the transmitter has failed; None while it has not."""
        return self.state.fault

    def going_on(self, leads: float, spoke_source: SceneSpokeSource) -> tuple[int, Sequence[Command]]:
        """Returns the first scan of a spoke source that goes on with the running scene and computes its first spokes within
        `leads` times LEAD, and the commands so far. Raises SceneChanged where another scene runs or is about to."""
        with self._group_clock.changed:  # while no spoke source takes over
            self._check_scene(spoke_source)
            idle = self.pacer.idle or self.fault is not None
            time = self._unsent_time + (0.0 if idle else leads * LEAD * self.pacer.speed)
            scene = spoke_source.info.scene
            commands = [scene.steerable.seen(each, each.body) for each in self.supervisor.worker.commands]
            return scene.radar.first_scan(time), commands

    def go_on_with(self, worker: SpokeWorker) -> bool:
        """Lets a spoke source take over that goes on with the running scene; returns False where it is late. Raises
        SceneChanged."""
        with self._group_clock.changed:
            self._check_scene(worker.spoke_source)
            if is_early := worker.begins >= self._unsent_time:
                self.supervisor.switch_to(worker)
                self.pacer.interrupt()
        return is_early

    @property
    def _unsent_time(self) -> float:
        """Time of the first spoke that was not given to the sinks [s]; with the clock's lock held."""
        return self.supervisor.worker.spoke_source.info.radar.time_of_spokes(float(self._commanded.unsent))

    def _check_scene(self, spoke_source: SceneSpokeSource) -> None:
        if self.pacer.is_outdated or not self.supervisor.keep_scene_of(spoke_source.scene_request):
            raise SceneChanged

    def switch_to(self, worker: SpokeWorker) -> str:
        """Lets the prepared spoke source of another scene take over; returns the name of its epoch. The last call wins."""
        name = self.supervisor.switch_to(worker)
        self.pacer.interrupt()
        return name

    def _run(self) -> None:
        act = {
            State.SENDING: self._while_sending,
            State.RESTARTING: self._while_restarting,
            State.FAILED: self._while_failed,
        }
        while self.state.now is not State.STOPPED:
            try:
                event = act[self.state.now]()
            except Exception as error:  # of any kind: the clients must be notified
                if not self.state.allows(Event.FAILURE):
                    raise
                reason = str(error) if isinstance(error, SpokeSourceFault) else f"{type(error).__name__}: {error}"
                event = Event.STOP if self.pacer.stopping else self.state.fail(reason)
            self.state.on(event)

    def _while_sending(self) -> Event:
        """Takes blocks and sends them, part by part."""
        self._group_clock.let_command()  # a fault may have ended
        while not self.pacer.stopping:
            if event := self._obey_run_control():
                return event
            if self._block is None:
                self._block = self.supervisor.worker.take(BLOCK_TIMEOUT)
            elif self._send_part(self._block) and self.supervisor.due == math.inf and self._take_over():
                return Event.TAKEN_OVER
        return Event.STOP

    def _while_restarting(self) -> Event:
        """Continues with the next scan and another spoke source of the same scene, or with one that is ready."""
        azimuths, self._block = self.epoch.info.radar.azimuths, None
        scan = self._spokes_done // azimuths + 1  # the present scan would make the next spoke source fail too
        self._commanded.go_on_from(scan * azimuths)
        cause = self.supervisor.restart(self.state.reason, scan, self._on_restart)
        if cause is None:
            return Event.TAKEN_OVER if self._take_over() else Event.GIVEN_UP
        missed = scan * azimuths - self._spokes_done if self.pacer.settings.transmit else 0
        self.epoch = self._epoch(self.epoch.name, self.epoch.range)
        self.pacer.restart_schedule()
        if missed:
            self._sinks.skip(self.epoch.name, self._number, missed, f"the radar was started again after: {cause}")
        self._number, self._spokes_done = self._number + missed, scan * azimuths
        return Event.RESTARTED

    def _while_failed(self) -> Event:
        """Ends the feed and waits for a spoke source."""
        reason = self.state.reason
        self.pacer.fail()
        self.commands.close(f"the radar has stopped: {reason}; give it another scene")
        self.supervisor.worker.stop()
        self._sinks.close(reason)
        self._on_failure(reason)
        while not self.pacer.stopping:
            self.pacer.wait_for(lambda: self.supervisor.has_pending)
            if self._take_over():
                self.commands.close(None)
                return Event.TAKEN_OVER
        return Event.STOP

    def _obey_run_control(self) -> Event | None:
        """Applies what does not wait for the end of the scan; returns what ends the present block, None where it goes on."""
        is_due = self._block is not None and self._block.time[0] >= self.supervisor.due
        if is_due or (self.supervisor.has_pending and (self.pacer.is_outdated or self.pacer.idle)):
            return Event.TAKEN_OVER if self._take_over() else None
        if self.pacer.settings.range != self.epoch.range:
            self._open(self._epoch(new_epoch_name(), self.pacer.settings.range))
        return None

    def _send_part(self, block: SpokeBlock) -> bool:
        """Sends the first spokes of a block when they are due; returns whether they were the last ones of a scan."""
        self._block = rest = self.supervisor.worker.known_part(block)
        if rest is None:
            return False  # it comes again, as commanded
        run_control = self.pacer.run_control()
        size = batch_spokes(run_control.settings.pace.factor, self.epoch.info.radar.spoke_period)
        before = int(np.searchsorted(rest.time, self.supervisor.due))  # a spoke source that waits has the others
        part = rest.part(0, run_control.spokes(rest.time, min(size, max(1, before))))
        if self._request_sources(part):
            self._block = None
            return False
        self._commanded.pace.computed()
        claim = partial(self._commanded.claim, part.first, len(part), part.commands)
        if not self.pacer.wait_until_due(part.time, run_control, claim):
            return False
        self._send(part, run_control.settings)
        self._commanded.pace.given()
        self._block = rest.part(len(part), len(rest)) if len(part) < len(rest) else None
        return part.index + len(part) == self.epoch.info.radar.azimuths

    def _request_sources(self, part: SpokeBlock) -> bool:
        """Requests the labels and powers that sinks need; returns whether these spokes come again with it."""
        worker = self.supervisor.worker
        request = worker.spoke_source.info.sources.to_request(self._sources())
        if request == worker.requested:
            return False
        return worker.request_sources(request, part.first)

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

    def _take_over(self) -> bool:
        """Lets the pending spoke source take over, where there is one; returns whether it has."""
        taken = self.supervisor.take_over(self._begin)
        if taken is None:
            return False
        self._open(self._epoch(taken, self.pacer.settings.range))
        return True

    def _begin(self, worker: SpokeWorker) -> None:
        """Takes up the time and the spokes of a spoke source that has taken over. The clock's lock is held."""
        self._last = self._block = None
        self.pacer.begin(worker.begins)
        self.simulated, self._spokes_done = worker.begins, worker.first
        self._commanded.go_on_from(worker.first, worker.spoke_source.scene_request.goes_on)

    def _epoch(self, name: str, range_max: float | None) -> Epoch:
        """An epoch of the running spoke source, with a display range [m]."""
        worker = self.supervisor.worker
        scene_request = worker.spoke_source.scene_request
        return Epoch(name, worker.spoke_source, range_max, worker.commands, scene_request, self._start_utc)

    def _open(self, epoch: Epoch) -> None:
        self.epoch, self._number = epoch, 0
        self._sinks.open_epoch(self._describe(epoch))
