"""The thread that sends: it carries out what `RadioState` decides. It takes blocks, waits until their spokes are due, and hands
them to the sinks."""

import math
import threading
from collections.abc import Callable, Sequence
from datetime import datetime

from radar_service.records import SourceRequest
from radar_service.service.radio import radio_state as radio
from radar_service.service.radio.command_worker import CommandQueue, CommandWorker, Steered
from radar_service.service.radio.pacer import GroupClock, Pacer
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.worker_supervisor import WorkerSupervisor
from radar_service.service.scene_request import MakeSpokeSource, SceneSpokeSource
from radar_service.service.settings import Settings
from radar_service.service.spokes import Epoch, RadarInfo, SinkGroup, SpokeBatch, SpokeSink, new_epoch_name, whole_second
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world import Command

STOPPING = "the server is stopping"
LEAD = 1.0  # s from the choice of the scan that another rate of rotation begins with; some ten times what first spokes take
BLOCK_TIMEOUT = 0.25  # s after which the transmitter reads the run control again
Report = Callable[[str], None]


class SceneChanged(Exception):
    """The scene that a spoke source was to go on with does not run any more."""


class Transmitter:
    """Sends the spokes of one radar to its sinks. Changes of pace go to `pacer`, other scenes to `switch_to`, from any thread.

    A CommandedRadar.

    epoch: the running one, which its thread alone writes.
    state: what it does.
    commands: those that wait for the command worker.
    supervisor: the running spoke source and its replacements.
    """

    def __init__(
        self, source: SceneSpokeSource | SpokeWorker, settings: Settings, sinks: Sequence[SpokeSink], clock: Callable[[], float],
        make_spoke_source: MakeSpokeSource, *, restarts: int = radio.RESTARTS, command_worker: CommandWorker | None = None,
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
        self.supervisor = WorkerSupervisor(source, make_spoke_source, self._group_clock.changed)
        self.epoch = self._epoch(new_epoch_name(), settings.range)
        self.state = radio.RadioState(self.epoch.info.radar, settings.range, restarts, self.supervisor.worker.begins)
        self.commands = CommandQueue(self._group_clock.let_command)
        self._sinks, self._clock = SinkGroup(sinks), clock
        self._on_restart, self._on_failure, self._sources, self._describe = on_restart, on_failure, sources, describe
        self._thread = threading.Thread(target=self._run, name="radar transmitter", daemon=True)
        self._command_worker.join(self)

    def start(self) -> None:
        """Opens the first epoch on every sink and starts both threads."""
        self._open(self.epoch)
        self.supervisor.start()
        self._command_worker.start()
        self._thread.start()

    def leave(self) -> None:
        """Leaves the group, and sends nothing more; `stop` comes next."""
        self._group_clock.leave(self.pacer)
        self._command_worker.leave(self)
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
    def is_commanded(self) -> bool:
        """Whether it has not failed, and does not stop."""
        return self.state.fault is None and not self.pacer.stopping

    @property
    def takes_commands(self) -> bool:
        """Whether commands may come: enough was sent since the last ones, or nothing can be sent now."""
        return self.state.takes_commands(self._clock(), self.pacer.waiting)

    @property
    def steered(self) -> Steered | None:
        """What commands act on; None while another scene is about to begin."""
        if not self.pacer.is_outdated:
            return Steered(self.supervisor.worker, self.state.unsent, self.state.newest)
        pending = self.supervisor.pending
        return None if pending is None else Steered(pending, 0, -math.inf)

    def commanded(self) -> None:
        """Counts the commands that came, and lets the pacer go on."""
        self._tell(radio.CommandsDone(self._clock()))
        self.pacer.waiting = False

    def going_on(self, leads: float, spoke_source: SceneSpokeSource) -> tuple[int, Sequence[Command]]:
        """Returns the first scan of a spoke source that goes on with the running scene and is ready within `leads` times LEAD,
        and the commands so far. Raises SceneChanged where another scene runs or is about to."""
        with self._group_clock.changed:  # while no spoke source takes over
            self._check_scene(spoke_source)
            idle = self.pacer.idle or self.state.fault is not None
            time = self._unsent_time + (0.0 if idle else leads * LEAD * self.pacer.speed)
            scene = spoke_source.info.scene
            commands = [scene.steerable.seen(each, each.body) for each in self.supervisor.worker.commands]
            return scene.radar.first_scan(time), commands

    def go_on_with(self, worker: SpokeWorker) -> bool:
        """Lets a spoke source take over that goes on with the running scene; returns False where it is late, or another one is
        about to. Raises SceneChanged."""
        with self._group_clock.changed:
            self._check_scene(worker.spoke_source)
            if is_early := worker.begins >= self._unsent_time < self.supervisor.due:
                self.supervisor.switch_to(worker)
                self.pacer.interrupt()
        return is_early

    @property
    def _unsent_time(self) -> float:
        """Time of the first spoke that was not given to the sinks [s]; with the clock's lock held."""
        return self.supervisor.worker.spoke_source.info.radar.time_of_spokes(float(self.state.unsent))

    def _check_scene(self, spoke_source: SceneSpokeSource) -> None:
        if self.pacer.is_outdated or not self.supervisor.keep_scene_of(spoke_source.scene_request):
            raise SceneChanged

    def switch_to(self, worker: SpokeWorker) -> str:
        """Lets the prepared spoke source of another scene take over; returns the name of its epoch. The last call wins."""
        name = self.supervisor.switch_to(worker)
        self.pacer.interrupt()
        return name

    def _run(self) -> None:
        instructions: Sequence[radio.Instruction] = ()
        while self.state.now is not radio.State.STOPPED:
            try:
                if instructions:
                    instructions = (*self._carry_out(instructions[0]), *instructions[1:])
                else:
                    instructions = self._look()
            except Exception as error:  # of any kind: the clients must be notified
                reason = str(error) if isinstance(error, SpokeSourceFault) else f"{type(error).__name__}: {error}"
                instructions = self._tell(radio.Failed(reason, self._clock()))
        self.supervisor.stop()  # one that was made meanwhile ends, too

    def _tell(self, event: radio.Event) -> Sequence[radio.Instruction]:
        """Tells the state an event; lets the command worker look again where it may go on."""
        with self._group_clock.changed:
            instructions = self.state.handle(event)
            if isinstance(event, radio.Due | radio.Failed | radio.Restarted | radio.TakenOver | radio.Opened):
                self._group_clock.let_command()
        return instructions

    def _look(self) -> Sequence[radio.Instruction]:
        with self._group_clock.changed:
            pacer, due, pending = self.pacer, self.supervisor.due, self.supervisor.pending is not None
            at_once = pending and (pacer.is_outdated or pacer.idle)
            run = pacer.run_control()
            look = radio.Looked(self._clock(), run, pacer.stopping, pending, at_once, due, self._unknown)
            return self._tell(look)

    @property
    def _unknown(self) -> float:
        block = self.state.block
        return self.supervisor.worker.commands.first_unknown(block.commands) if block else math.inf

    def _carry_out(self, instruction: radio.Instruction) -> Sequence[radio.Instruction]:
        """Carries out an instruction; returns what follows from it."""
        match instruction:
            case radio.Take():
                self._tell(radio.Taken(self.supervisor.worker.take(BLOCK_TIMEOUT)))
            case radio.Send():
                self._send(instruction)
            case radio.Open():
                self._open(self._epoch(new_epoch_name(), instruction.range))
            case radio.TakeOver():
                self._take_over(instruction)
            case radio.Restart():
                return self._restart(instruction)
            case radio.Skip():
                self._sinks.skip(self.epoch.name, *instruction)
            case radio.GiveUp():
                self._give_up(instruction.reason)
            case radio.Wait():
                self.pacer.wait_for(lambda: self.supervisor.pending is not None)
        return ()

    def _send(self, send: radio.Send) -> None:
        """Sends spokes when due, unless their labels and powers are requested first: then they come again."""
        part, worker = send.part, self.supervisor.worker
        request = worker.spoke_source.info.sources.to_request(self._sources())
        if request != worker.requested and worker.request_sources(request, part.first):
            self._tell(radio.Taken(None))
        elif self.pacer.wait_until_due(part.time, send.run, self._is_due):
            settings = send.run.settings
            if settings.transmit:
                self._sinks.send(SpokeBatch(self.epoch, send.number, part, settings.video, send.before))
            self.pacer.sent(float(part.time[-1]))
            self._tell(radio.Sent())

    def _is_due(self) -> bool:
        return bool(self._tell(radio.Due(self._clock(), self.supervisor.due, self._unknown)))

    def _take_over(self, order: radio.TakeOver) -> None:
        name = self.supervisor.take_over(self._begin)
        self._open(self._epoch(name, order.range))
        self._tell(radio.Opened())  # who joins from now on is told of this epoch

    def _begin(self, worker: SpokeWorker) -> None:
        """Takes up the time and spokes of the new spoke source. The clock's lock is held."""
        if self.state.fault and not self.pacer.stopping:
            self.commands.close(None)
        self.pacer.begin(worker.begins)
        source = worker.spoke_source
        self._tell(radio.TakenOver(source.info.radar, worker.first, source.scene_request.goes_on))

    def _restart(self, order: radio.Restart) -> Sequence[radio.Instruction]:
        self._on_restart(order.reason)
        self.supervisor.restart(order.scan)
        self.epoch = self._epoch(self.epoch.name, self.epoch.range)
        self.pacer.restart_schedule()
        return self._tell(radio.Restarted(self.pacer.settings.transmit))

    def _give_up(self, reason: str) -> None:
        self.pacer.fail()
        self.commands.close(f"the radar has stopped: {reason}; give it another scene")
        self.supervisor.worker.stop()
        self._sinks.close(reason)
        self._on_failure(reason)

    def _epoch(self, name: str, range_max: float | None) -> Epoch:
        """An epoch of the running spoke source, with a display range [m]."""
        worker = self.supervisor.worker
        scene_request = worker.spoke_source.scene_request
        return Epoch(name, worker.spoke_source, range_max, worker.commands, scene_request, self._start_utc)

    def _open(self, epoch: Epoch) -> None:
        self.epoch = epoch
        self._sinks.open_epoch(self._describe(epoch))
