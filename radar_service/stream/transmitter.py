"""The thread that sends: takes blocks from the engine ahead, waits until they are due, encodes them, hands them out.

What happens when:
- gain, sea, rain, transmit, pace: from the next batch on. Standby sends no spokes and uses no numbers; time goes on.
- range: a new epoch at once. Another scene: a new epoch when the running scan ends; at once while paused or failed.
- the engine dies: another one takes over in the same epoch from the next scan on, and what lies between is a gap. If that
  happens too often, the outlet is told the reason once; the next scene revives the radar.
"""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from radar_service.display.video import Controls
from radar_service.records import SpokeBlock
from radar_service.scene.world import Scene
from radar_service.stream import messages, wire
from radar_service.stream.ahead import RESTARTS, Ahead, Deaths, EngineFault, prepared
from radar_service.stream.hub import Batch
from radar_service.stream.messages import Engine
from radar_service.stream.outlet import Epoch, Outlet, new_epoch_name
from radar_service.stream.pace import Pace, Schedule, batch_spokes
from radar_service.stream.shape import shaped

TRUTHS_PER_SCAN = 8  # enough to draw a track; their cost stays unseen
WAIT_FOR_BLOCK = 0.25  # s between looks at whether there is something else to do
LONGEST_WAIT = 3600.0  # s before another look at the schedule: a pace of 1e-300 is due in more seconds than can be waited

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Settings:
    """What REST sets on a radar. range [m]: of the display, None as far as it goes."""

    transmit: bool = True
    range: float | None = None
    video: Controls = field(default_factory=Controls)
    pace: Pace = field(default_factory=Pace)


class Transmitter:
    """The sending half of a radar. Commands may come from any thread."""

    def __init__(
        self, engine: Engine, settings: Settings, outlet: Outlet, clock: Callable[[], float],
        again: Callable[[Scene], Engine], restarts: int = RESTARTS,
    ) -> None:  # fmt: skip
        """again: makes another engine for the scene of one that died; restarts: how often within RESTART_WINDOW."""
        self.settings = settings
        self.epoch = Epoch(new_epoch_name(), engine, settings.range)
        self.fault: str | None = None
        self.reviving = False  # an engine has died and another is on its way
        self.sent = 0  # spokes since the start
        self.simulated = 0.0  # time of the next spoke, s
        self.schedule = Schedule()
        self.restarts = 0  # times the engine died and was started again
        self.encoding: dict[str, tuple[int, float]] = {}  # batches encoded, and the time that took [s], by encoding
        self._outlet, self._clock, self._again = outlet, clock, again
        self._deaths = Deaths(restarts, clock)
        self._made = 0  # spokes of the running engine's scene that have been dealt with, from t = 0
        self._ahead = Ahead(engine)
        self._next: tuple[str, Ahead] | None = None  # epoch to come
        self._steps = 0  # spokes still to send while paused
        self._number = 0  # of the next spoke in this epoch
        self._sweep: deque[tuple[Rows, NDArray[np.float32]]] = deque()
        self._changed = threading.Condition()
        self._version = 0  # of settings, steps and the epoch to come
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="radar transmitter", daemon=True)

    def start(self) -> None:
        """Begin to compute and to send."""
        self._ahead.start()
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """End both threads and wait that long for each [s]."""
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        self._ahead.stop()
        if self._next:
            self._next[1].stop()
        if self._thread.ident is not None:
            self._thread.join(timeout)
        self._ahead.stop(timeout)

    def set(self, settings: Settings) -> None:
        """Replace the settings; see the top of this file for when they take hold."""
        with self._changed:
            if settings.pace != self.settings.pace:
                self._steps = 0
                self.schedule.restart()
            self.settings = settings
            self._touch()

    def step(self, spokes: int) -> None:
        """Pause, having sent that many spokes more."""
        with self._changed:
            self.settings = replace(self.settings, pace=replace(self.settings.pace, state="pause"))
            self.schedule.restart()
            self._steps = spokes
            self._touch()

    def follow_with(self, ahead: Ahead) -> str:
        """Let a prepared engine take over; gives the name of its epoch. Of several the last one wins."""
        with self._changed:
            replaced, self._next = self._next, (new_epoch_name(), ahead)
            self._touch()
            name = self._next[0]
        if replaced:
            replaced[1].stop()
        return name

    @property
    def coming(self) -> Engine:
        """The engine that will run next, or runs."""
        following = self._next
        return following[1].engine if following else self.epoch.engine

    def reached(self) -> float | None:
        """Simulated seconds per second, measured; None before there is enough to measure."""
        with self._changed:
            return self.schedule.reached(self._clock())

    def sweep(self) -> tuple[Engine, list[tuple[Rows, NDArray[np.float32]]]]:
        """The engine, and rows and power [W] of the spokes of its last revolution, oldest first."""
        with self._changed:
            return self.epoch.engine, list(self._sweep)

    def _touch(self) -> None:
        self._version += 1
        self._changed.notify_all()

    @property
    def _idle(self) -> bool:
        return self.settings.pace.state == "pause" and not self._steps

    def _run(self) -> None:
        while not self._stopping:
            try:
                self._transmit()
            except Exception as fault:  # whatever it is, the listeners must be told
                if not self._stopping:
                    reason = str(fault) if isinstance(fault, EngineFault) else f"{type(fault).__name__}: {fault}"
                    if not self._revive(reason):
                        self._die(reason)

    def _transmit(self) -> None:
        while not self._stopping:
            self._attend()
            block = self._ahead.take(WAIT_FOR_BLOCK)
            if block is None:
                continue
            self._send(block)
            if self._next and block.index + len(block) == self.epoch.engine.scene.radar.azimuths:
                self._take_over()

    def _revive(self, reason: str) -> bool:
        """Go on in the next scan with another engine of the same scene; whether that has worked."""
        self._ahead.stop()
        self.reviving = True
        try:
            while self._deaths.bearable() and not self._stopping and not self._next:
                self._outlet.restarting(reason)
                self.restarts += 1
                try:
                    self._resume(reason)
                    return True
                except Exception as fault:  # an engine that cannot even be made counts as another one that died
                    reason = str(fault)
            return False
        finally:
            self.reviving = False

    def _resume(self, reason: str) -> None:
        azimuths = self.epoch.engine.scene.radar.azimuths
        scan = self._made // azimuths + 1  # the one at hand would kill the next engine too
        ahead = prepared(self._again(self.epoch.engine.scene), scan)
        missed = scan * azimuths - self._made if self.settings.transmit else 0
        with self._changed:
            self._ahead, self.epoch = ahead, replace(self.epoch, engine=ahead.engine)
            self.schedule.restart()
        self._outlet.missed(self.epoch.name, missed, f"the radar was started again after: {reason}")
        self._number += missed
        self._made = scan * azimuths

    def _die(self, reason: str) -> None:
        self.fault = reason
        self._ahead.stop()
        self._outlet.died(reason)
        with self._changed:
            self._changed.wait_for(lambda: self._next or self._stopping)
        if self._next:
            self._take_over()

    def _attend(self) -> bool:
        """Do what cannot wait for the end of the scan; whether that has made the block at hand obsolete."""
        if self._next and self._idle:
            self._take_over()
            return True
        if self.settings.range != self.epoch.range:
            self._open(replace(self.epoch, name=new_epoch_name(), range=self.settings.range))
        return False

    def _take_over(self) -> None:
        with self._changed:
            assert self._next is not None
            (name, ahead), self._next = self._next, None
            old, self._ahead = self._ahead, ahead
            self._sweep.clear()
            self.schedule.restart()
            self.simulated = 0.0
            self._made = 0
        old.stop()
        self._open(Epoch(name, ahead.engine, self.settings.range))
        self.fault = None

    def _open(self, epoch: Epoch) -> None:
        self.epoch, self._number = epoch, 0
        self._outlet.open_epoch(epoch)

    def _send(self, block: SpokeBlock) -> None:
        at = 0
        while at < len(block) and not self._stopping:
            if self._attend():
                return
            with self._changed:
                version, settings, steps = self._version, self.settings, self._steps
            size = batch_spokes(settings.pace.factor, self.epoch.engine.scene.radar.spoke_period)
            part = block.part(at, min(len(block), at + min(size, steps or size)))
            if self._wait(part, settings, version):
                self._emit(part, settings)
                at += len(part)

    def _wait(self, part: SpokeBlock, settings: Settings, version: int) -> bool:
        """Wait until the batch is due: True; or until something has changed: False."""
        with self._changed:
            while version == self._version and not self._stopping:
                if self._steps:
                    self._steps -= len(part)  # before they go out: who has received them may order more at once
                    return True
                if settings.pace.state == "pause":
                    self._changed.wait()
                    continue
                delay = self.schedule.delay(self._clock(), float(part.time[-1]), settings.pace.factor)
                if delay <= 0:
                    return True
                self._changed.wait(min(delay, LONGEST_WAIT))
        return False

    def _emit(self, part: SpokeBlock, settings: Settings) -> None:
        if settings.transmit:
            self._outlet.publish(self._batch(part, settings.video))
            self._number += len(part)
            self.sent += len(part)
        self._made = part.first + len(part)
        with self._changed:
            self.simulated = float(part.time[-1]) + self.epoch.engine.scene.radar.spoke_period
            self.schedule.sent(self._clock(), float(part.time[-1]))
            if settings.transmit:
                self._remember(part)

    def _batch(self, part: SpokeBlock, controls: Controls) -> Batch:
        epoch, data = self.epoch, {}
        for view in self._outlet.views():
            began = self._clock()
            message = messages.spokes(
                epoch.name, self._number, part, view.encoding, epoch.layout(view.bins), controls, epoch.engine
            )
            data[view] = wire.pack(shaped(message, view))
            count, seconds = self.encoding.get(view.encoding, (0, 0.0))
            self.encoding[view.encoding] = count + 1, seconds + self._clock() - began
        return Batch(epoch.name, self._number, len(part), data, self._truths(part))

    def _truths(self, part: SpokeBlock) -> tuple[bytes, ...]:
        if not self._outlet.wants_truth():
            return ()
        every = max(1, self.epoch.engine.scene.radar.azimuths // TRUTHS_PER_SCAN)
        due = [float(t) for k, t in enumerate(part.time) if (part.index + k) % every == 0]
        return tuple(wire.pack(messages.truth(self.epoch.name, self.epoch.engine.truth(t))) for t in due)

    def _remember(self, part: SpokeBlock) -> None:
        self._sweep.append((np.arange(part.index, part.index + len(part)), part.power))
        held = sum(len(rows) for rows, _ in self._sweep)
        while held - len(self._sweep[0][0]) >= self.epoch.engine.scene.radar.azimuths:
            held -= len(self._sweep.popleft()[0])
