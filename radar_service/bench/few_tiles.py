"""Plots from the few tiles of a scan that may hold a detection, with the bytes of the whole scan.

A tile without a body in the beam is left out unless its noise exceeds the threshold.
"""

import numpy as np

from radar_service.bench.trackers.tracker import TrackerInput
from radar_service.engine.pipeline import noise_power, profiles, tile_azimuths
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.numerics.types import Flags, Floats
from radar_service.plots.detections import Detections
from radar_service.plots.extractor import PlotExtractor, ScanPlots
from radar_service.plots.thresholds import KnownThreshold, Threshold
from radar_service.receive.detection import square_law
from radar_service.records.reports import Readings
from radar_service.scans.scan import Scan
from radar_service.simulator import Simulator
from radar_service.stages.registry import effects_in

MARGIN = 0.02  # rad beyond the beam in which a body counts as within


def has_few(simulator: Simulator, threshold: Threshold) -> bool:
    """Returns whether tiles without a body in the beam have noise alone, under a known threshold."""
    scene, radar, pulses = simulator.scene, simulator.scene.radar, simulator.pulses
    if len(pulses) != 1 or not isinstance(threshold, KnownThreshold) or pulses[0].stages:
        return False
    rests = pulses[0].resting_profiles is not None or pulses[0].land is not None or pulses[0].shadows.possible
    special = any(effect.has_paths for effect in effects_in(scene)) or radar.second_time_around
    special = special or radar.pulses_integrated > 1 or scene.own_ship.sway is not None
    return scene.environment.noise and not rests and not special


class FewTiles:
    """The plots of the scans of a simulator."""

    def __init__(self, simulator: Simulator, threshold: Threshold, scans: int) -> None:
        self._simulator, self._radar, (self._prepared,) = simulator, simulator.scene.radar, simulator.pulses
        self._level = threshold.of(np.empty((1, 1), dtype=np.float32))[0, 0]
        self._near = self._passed(scans)

    def _passed(self, scans: int) -> Flags:
        """In which tiles (scans, T) the beam may pass a body."""
        radar, scene, tile = self._radar, self._simulator.scene, self._prepared.tile
        starts = np.arange(0, radar.azimuths, tile)
        ends = np.minimum(starts + tile, radar.azimuths) - 1
        number = np.arange(scans)[:, None, None] * radar.azimuths + np.stack([starts, ends], axis=1)
        boresight, time = radar.schedule(number.ravel())
        antenna, near = scene.antenna(time), np.zeros(number.shape[:2], dtype=np.bool_)
        reach = 2.0 * (self._simulator.fidelity.beam_extent * radar.beamwidth + MARGIN) + (tile + 2) * radar.azimuth_step
        for body in scene.bodies:
            offset = body.motion.pose(time).position - antenna
            bearing, distance = np.arctan2(offset[:, 0], offset[:, 1]), np.hypot(offset[:, 0], offset[:, 1])
            width = np.where(distance > 2.0 * body.arm, 2.0 * body.arm / np.maximum(distance, 1.0), np.pi)
            turned = np.abs(wrap_angle(np.diff(bearing.reshape(number.shape), axis=2)))[..., 0]
            away = (np.abs(wrap_angle(boresight - bearing)) - width).reshape(number.shape).sum(axis=2)
            near |= away <= reach + 2.0 * turned
        return near

    @BLAS_LIMIT.held()
    def plots(self, number: int, extractor: PlotExtractor) -> tuple[ScanPlots, TrackerInput]:
        """Returns the plots of a scan, and own ship at its last spoke. extractor: has the scans before."""
        radar, parts = self._radar, [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0))]
        for start in range(0, radar.azimuths, self._prepared.tile):
            azimuths = tile_azimuths(self._prepared, number, start)
            if self._near[number, start // self._prepared.tile] or noise_power(self._prepared, azimuths).max() > self._level:
                power = square_law(profiles(self._prepared, azimuths))
                row, cell = np.nonzero(power > self._level)
                parts.append((azimuths.number[row], cell, power[row, cell].astype(np.float64)))
        spoke, cell, powers = (np.concatenate(column) for column in zip(*parts, strict=True))
        spokes = np.append(spoke, (number + 1) * radar.azimuths - 1)
        time, own = radar.schedule(spokes)[1], self._simulator.reported(spokes)
        azimuth = own.azimuth if self._simulator.errors else spokes % radar.azimuths * (2.0 * np.pi / radar.azimuths)
        columns = time[:-1], azimuth[:-1], own.position[:-1, 0], own.position[:-1, 1]
        fresh = Detections(spoke, cell, powers, np.full(len(spoke), self._level), *columns)
        size = radar.azimuths * len(self._simulator.range)
        return extractor.add_detections(number, fresh, size, self._simulator.range[0]), _at_last(number, time, own)


def last_spoke(scan: Scan) -> TrackerInput:
    """Returns own ship at the last spoke of a scan, without plots."""
    return _at_last(scan.number, scan.time, Readings(scan.azimuth, scan.heading, scan.position, scan.course, scan.speed))


def _at_last(number: int, time: Floats, own: Readings) -> TrackerInput:
    """Own ship (K,) at the last of times (K,) [s] of a scan of that number."""
    east, north = own.position[-1].tolist()
    return TrackerInput(
        scan=number, time=float(time[-1]), east=east, north=north, heading=float(own.heading[-1]), course=float(own.course[-1]),
        speed=float(own.speed[-1]), plots=(),
    )  # fmt: skip
