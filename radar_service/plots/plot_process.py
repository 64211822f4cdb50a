"""A plot extractor in a process of its own, for services."""

import contextlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radar_service.plots.detections import no_detections
from radar_service.plots.extractor import PlotExtractor, ScanPlots
from radar_service.plots.marine import MarineThreshold
from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.limits import lower_priority
from radar_service.radar.parameters import Radar
from radar_service.scans.scan import Scan


class PlotProcess:
    """A plot extractor in a process of its own: in the service, a third of a second of work a scan would delay the feed."""

    def __init__(self, server: ForkServer, tell: Callable[[str], None]) -> None:
        """tell: gets the first flood in words. Raises OSError where no process can be started."""
        self._child = server.child(extract_plots)
        self._tell, self.close = tell, self._child.close

    def begin(self, radar: Radar) -> "PlotProcess":
        """Begins anew, with a radar. Raises OSError where the process has ended."""
        self._child.data.send(radar)
        return self

    def add(self, scan: Scan) -> ScanPlots:
        """Returns the plots that end in a scan, without cells. Raises OSError and EOFError where the process has ended."""
        self._child.data.send(replace(scan, field=scan.field[:0]))
        plots: ScanPlots
        plots, floods = self._child.data.receive()
        for flood in floods:
            self._tell(flood)
        return plots


def extract_plots(_: Channel, data: Channel) -> None:
    """Runs the process. data: brings radars and their scans, and takes plots and first floods."""
    lower_priority()
    floods = list[str]()
    with contextlib.suppress(EOFError, OSError):  # the service ends it
        while True:
            message = data.receive()
            if isinstance(message, Radar):
                extractor = ready_extractor(message, floods.append)
                continue
            ended = extractor.add(message)
            data.send((replace(ended, cells=no_detections(), detections=no_detections()), floods.copy()))
            floods.clear()


def ready_extractor(radar: Radar, tell: Callable[[str], None]) -> PlotExtractor:
    """Returns an extractor for sea, rain and land that has its tables. tell: as of a PlotExtractor."""
    threshold = MarineThreshold(radar)
    threshold.of(np.ones((radar.azimuths, 64), dtype=np.float32))
    return PlotExtractor(radar, threshold, tell=tell)
