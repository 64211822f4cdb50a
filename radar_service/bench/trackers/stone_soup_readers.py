"""Readers for trackers and metrics of Stone Soup: plots and truth of a radar, in process or over the websocket.

They need the extra `tracking`. Scans may come from a Simulator, a file, or a radar_feed.RadarFeed of a service.
"""

from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta
from typing import Any

from stonesoup.base import Property
from stonesoup.buffered_generator import BufferedGenerator
from stonesoup.reader.base import DetectionReader, GroundTruthReader
from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
from typing_extensions import override

from radar_service.bench.trackers.gating import EPOCH, Tuning
from radar_service.bench.trackers.stone_soup import detection
from radar_service.plots.extractor import PlotExtractor
from radar_service.radar.parameters import Radar
from radar_service.records.truth import Snapshot
from radar_service.scans.scan import Scan


class PlotReader(DetectionReader):  # type: ignore[misc]  # Stone Soup has no types
    """Yields the end of each scan and the detections of its plots. Each detection has the time of its plot and its own
    measurement model, with range, the bearing of mathematics, and own ship's position."""

    scans: Iterable[Scan] = Property(doc="Consecutive scans of one radar.")
    radar: Radar = Property(doc="Of the scans.")
    tuning: Tuning = Property(default=Tuning(), doc="Errors of plots.")
    extractor: PlotExtractor | None = Property(default=None, doc="A new one for the radar by default.")

    @BufferedGenerator.generator_method  # type: ignore[untyped-decorator]
    @override
    def detections_gen(self) -> Iterator[tuple[datetime, set[Any]]]:
        extractor = self.extractor or PlotExtractor(self.radar)
        for scan in self.scans:
            plots = extractor.add(scan).plots
            yield scan_end(scan.number, self.radar), {detection(plot, self.tuning) for plot in plots}


class TruthReader(GroundTruthReader):  # type: ignore[misc]
    """Yields the end of each scan and the paths of all bodies up to it, with states (east, velocity, north, velocity)."""

    snapshots: Iterable[Snapshot] = Property(doc="Of consecutive scans, as RadarFeed.snapshots.")

    @BufferedGenerator.generator_method  # type: ignore[untyped-decorator]
    @override
    def groundtruth_paths_gen(self) -> Iterator[tuple[datetime, set[Any]]]:
        paths: dict[str, Any] = {}
        for snapshot in self.snapshots:
            time = EPOCH + timedelta(seconds=snapshot.time)
            for body in snapshot.bodies:
                (east, north), (east_speed, north_speed) = body.position[:2], body.velocity[:2]
                state = GroundTruthState(
                    [east, east_speed, north, north_speed], timestamp=time, metadata={"body": body.body}
                )
                paths.setdefault(body.body, GroundTruthPath(id=body.body)).append(state)
            yield time, {*paths.values()}


def scan_end(scan: int, radar: Radar) -> datetime:
    """Returns the time at which a scan ends, as TrackerInput.time has it."""
    return EPOCH + timedelta(seconds=(scan + 1) * radar.rotation_period)
