"""A plot extractor in a process of its own, for services."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import replace
from threading import Thread

from radar_service.plots.extractor import Extract, PlotExtractor
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.plot import Plot
from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.limits import lower_priority
from radar_service.radar import Radar
from radar_service.scans import Scan


class PlotProcess:
    """A plot extractor in a process of its own: in the service, a fifth of a second of work a scan would delay the feed.

    The process has one scan, and another one waits for it; of more, all spokes are lost. A scan is sent when the process has
    answered the one before, by a thread that alone waits for it.
    """

    def __init__(
        self, server: ForkServer, radar: Radar, tell: Callable[[str], None], note_lost: Callable[[int], None]
    ) -> None:
        """tell: gets the first flood in words; note_lost: counts spokes. Raises OSError where no process can be started."""
        self._child = server.child(extract_plots)
        self._radar, self._tell, self._note_lost = radar, tell, note_lost
        self._begins, self._works = True, False
        self._waiting: tuple[Radar | None, Scan] | None = None  # the radar where a scan is the first one

    def begun(self) -> Extract:
        """Returns what takes scans, of which the next one follows none."""
        self._begins = True
        return self.add

    def add(self, scan: Scan) -> list[Plot]:
        """Takes a scan; returns the plots that have come. Raises OSError and EOFError where the process has ended."""
        plots = self.ended()
        if self._waiting is None:
            self._waiting = self._radar if self._begins else None, replace(scan, field=scan.field[:0])
            self._begins = False
        else:
            self._note_lost(self._radar.azimuths)
            self._begins = True
        return plots + self.ended()

    def ended(self, patience: float = 0.0) -> list[Plot]:
        """Returns the plots that have come, at most `patience` [s] later those of all scans. Raises OSError and EOFError."""
        plots, until = list[Plot](), time.monotonic() + patience
        while self._works or self._waiting:
            if self._works:
                if not self._child.data.wait(max(until - time.monotonic(), 0.0)):
                    break
                fresh, floods = self._child.data.receive()
                self._works = False
                plots += fresh
                for flood in floods:
                    self._tell(flood)
            if self._waiting:
                Thread(target=self._hand_over, args=(self._waiting,), name="a scan for plots", daemon=True).start()
                self._works, self._waiting = True, None
        return plots

    def _hand_over(self, scan: tuple[Radar | None, Scan]) -> None:
        """Sends a scan, from a thread of its own: a process that has been stopped reads nothing."""
        with contextlib.suppress(OSError):  # it has ended, as the next look for plots finds
            self._child.data.send(scan)

    def close(self) -> None:
        """Ends the process. Spokes of scans that it has not done are lost."""
        self._note_lost(self._radar.azimuths * (self._works + (self._waiting is not None)))
        self._child.close()


def extract_plots(_: Channel, data: Channel) -> None:
    """Runs the process. data: brings scans, the first one with its radar, and takes plots and first floods."""
    lower_priority()
    floods = list[str]()
    with contextlib.suppress(EOFError, OSError):  # the service ends it
        while True:
            radar, scan = data.receive()
            if radar is not None:
                extract = extraction(radar, floods.append)
            data.send((extract(scan), floods.copy()))
            floods.clear()


def extraction(radar: Radar, tell: Callable[[str], None]) -> Extract:
    """Returns what extracts plots from scans of a radar in sea, rain and land. tell: as of a PlotExtractor."""
    extractor = PlotExtractor(radar, MarineThreshold(radar), tell=tell)
    return lambda scan: extractor.add(scan).plots
