"""Plots from the few tiles of a scan that may hold a detection, with the bytes of the whole scan.

A tile is left out where its noise and a bound of its echoes do not reach the threshold together.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from radar_service.echo import AzimuthTimes, BeamWeightedEchoes, MovingEchoes
from radar_service.engine.pipeline import noise_amplitude, profiles, tile_azimuths
from radar_service.engine.preparation import Prepared
from radar_service.numerics import BLAS_LIMIT, Floats, Indices, wrap_angle
from radar_service.plots import Detections, KnownThreshold, PlotExtractor, ScanPlots, Threshold
from radar_service.propagation import received_amplitude
from radar_service.records import Readings, square_law
from radar_service.simulation.engine_set_up import pipeline_set_up
from radar_service.simulator import Simulator
from radar_service.stages.registry import effects_in

MARGIN = 0.02  # rad beyond the beam in which a body counts as within
ECHO_BOUND = 2.0  # times the amplitude of a point in free space
ROUNDING = 1e-4  # of an amplitude: far more than single precision has
BEARINGS = 2**14  # of the table of gains, on half a circle
TOGETHER = 50  # scans that are computed at once, as far as numpy gains by it


def has_few(simulator: Simulator, threshold: Threshold) -> bool:
    """Returns whether plots may come from few tiles: without a body in the beam these have noise alone, and a known threshold."""
    scene, radar, pulses = simulator.scene, simulator.scene.radar, simulator.pulses
    if len(pulses) != 1 or not isinstance(threshold, KnownThreshold) or pulses[0].stages:
        return False
    rests = pulses[0].resting_profiles is not None or pulses[0].land is not None or pulses[0].shadows.possible
    special = any(effect.has_paths for effect in effects_in(scene)) or radar.second_time_around
    special = special or radar.pulses_integrated > 1 or scene.own_ship.sway is not None
    return scene.environment.noise and not rests and not special


class FewTiles:
    """The plots of the scans of a simulator."""

    def __init__(self, simulator: Simulator, threshold: Threshold, prepared: Prepared | None = None) -> None:
        """prepared: by `prepared_together`."""
        self._simulator, self._radar, self._prepared = simulator, simulator.scene.radar, prepared or simulator.pulses[0]
        self._level = threshold.of(np.empty((1, 1), dtype=np.float32))[0, 0]

    def _bounds(self, scans: range) -> Floats:
        """Bounds (scans, T) [sqrt(W)] of echoes; inf: the beam may pass a body of unknown power."""
        radar, scene, tile, fidelity = self._radar, self._simulator.scene, self._prepared.tile, self._simulator.fidelity
        starts = np.arange(0, radar.azimuths, tile)
        ends = np.minimum(starts + tile, radar.azimuths) - 1
        number = np.array(scans)[:, None, None] * radar.azimuths + np.stack([starts, ends], axis=1)
        boresight, time = radar.schedule(number.ravel())
        antenna, bound = scene.antenna(time), np.zeros(number.shape[:2])
        every = radar.time_of_spokes(np.array(scans)[:, None] * radar.azimuths + np.arange(float(radar.azimuths)))
        gain = np.abs(radar.azimuth_gain(np.linspace(0.0, np.pi, BEARINGS + 1)))
        gain = np.maximum.accumulate(gain[::-1])[::-1]
        for body in scene.bodies:
            offset = body.motion.pose(time).position - antenna
            bearing, distance = np.arctan2(offset[:, 0], offset[:, 1]), np.hypot(offset[:, 0], offset[:, 1])
            width = np.where(distance > 2.0 * body.arm, 2.0 * body.arm / np.maximum(distance, 1.0), np.pi)
            turned = np.abs(wrap_angle(np.diff(bearing.reshape(number.shape), axis=2)))[..., 0]
            away = (np.abs(wrap_angle(boresight - bearing)) - width).reshape(number.shape).sum(axis=2)
            away = away / 2.0 - MARGIN - (tile + 2) / 2.0 * radar.azimuth_step - turned
            near = away <= fidelity.beam_extent * radar.beamwidth
            if not body.presence.constant:
                near &= np.logical_or.reduceat(body.presence.at(every), starts, axis=1)
            if body.mesh or body.reflector or body.swerling or body.rcs is None or scene.environment.multipath:
                bound[near] = np.inf
                continue
            nearest = distance.reshape(number.shape).min(axis=2) - 2.0 * fidelity.visibility_step
            amplitude = ECHO_BOUND * np.sqrt(body.rcs) * received_amplitude(radar, np.maximum(nearest, 0.0))
            bound[near] += (amplitude * gain[(np.clip(away, 0.0, np.pi) * (BEARINGS / np.pi)).astype(np.int64)])[near]
        return bound

    def plots(self, scans: range, extractor: PlotExtractor) -> Iterator[tuple[ScanPlots, Floats, Readings]]:
        """Yields the plots of some scans, each with time (1,) [s] and own ship (1,) at its last spoke. extractor: has the scans
        before."""
        azimuths, end = self._radar.azimuths, 0
        crossings = [self._cells(*each) for each in zip(scans, self._bounds(scans), strict=True)]
        last_spokes = [(scan + 1) * azimuths - 1 for scan in scans]
        number = np.concatenate([np.append(crossings[n][0], last) for n, last in enumerate(last_spokes)])
        spokes, of_spoke = np.unique(number, return_inverse=True)
        time, own = self._radar.schedule(number)[1], self._simulator.reported(spokes).part(of_spoke)
        azimuth = own.azimuth if self._simulator.errors else number % azimuths * (2.0 * np.pi / azimuths)
        for scan, (spoke, cell, power) in zip(scans, crossings, strict=True):
            first, end = end, end + len(spoke) + 1
            of, last = slice(first, end - 1), slice(end - 1, end)
            columns = time[of], azimuth[of], own.position[of, 0], own.position[of, 1]
            fresh = Detections(spoke, cell, power, np.full(len(spoke), self._level), *columns)
            size = azimuths * len(self._simulator.range)
            yield extractor.add_detections(scan, fresh, size, self._simulator.range[0]), time[last], own.part(last)

    @BLAS_LIMIT.held()
    def _cells(self, scan: int, bounds: Floats) -> list[Any]:
        """Spokes, cells and powers [W] of detections (C,). bounds: (T,) [sqrt(W)] of echoes."""
        parts = [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0))]
        needed = np.sqrt(self._level) * (1.0 - ROUNDING)
        for start, bound in zip(range(0, self._radar.azimuths, self._prepared.tile), bounds.tolist(), strict=True):
            first = scan * self._radar.azimuths + start
            if bound < needed and bound + noise_amplitude(self._prepared, first) < needed:
                continue
            azimuths = tile_azimuths(self._prepared, scan, start)
            power = square_law(profiles(self._prepared, azimuths))
            row, cell = np.nonzero(power > self._level)
            parts.append((azimuths.number[row], cell, power[row, cell].astype(np.float64)))
        return [np.concatenate(column) for column in zip(*parts, strict=True)]


def prepared_together(simulators: Sequence[Simulator]) -> list[Prepared]:
    """Returns scenes of steady points that `has_few`, prepared to compute the echoes of all at once, with the same bytes."""
    first, bodies = simulators[0], [each.scene.bodies for each in simulators]
    scene = first.scene.with_world(bodies=tuple(body for some in bodies for body in some))
    moving = pipeline_set_up(scene, first.fidelity, first.seed).prepared.moving
    moving.separate = True
    owner, kept = np.repeat(np.arange(len(bodies)), [*map(len, bodies)]), dict[Any, Any]()
    every = enumerate(each.pulses[0] for each in simulators)
    return [replace(alone, moving=cast(MovingEchoes, _OneSeed(moving, owner, kept, k, alone.moving))) for k, alone in every]


class _OneSeed:
    """The `MovingEchoes` of one seed. Sums of several echoes have the bytes of their number, and are computed alone."""

    def __init__(self, every: MovingEchoes, owner: Indices, kept: dict[Any, Any], seed: int, alone: MovingEchoes) -> None:
        """every: the bodies of all seeds; owner: (B,) seed of each body; kept: what all share; seed: by its place."""
        self._every, self._owner, self._kept, self._seed = every, owner, kept, seed
        self._alone, self.visibility = alone, alone.visibility

    def __len__(self) -> int:
        return len(self._alone)

    def block_size(self, azimuths: AzimuthTimes, usual: int) -> int:
        """Returns the length of blocks: where all seeds have long ones, so has each."""
        size = int(self._shared(azimuths, "size", lambda: self._every.block_size(azimuths, usual)))
        return size if size == len(azimuths.time) else self._alone.block_size(azimuths, usual)

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        """Returns the echoes in the beam."""
        echoes: BeamWeightedEchoes = self._shared(azimuths, "echoes", lambda: self._every.echoes(azimuths))
        own = np.flatnonzero(self._owner[echoes.body] == self._seed)
        return self._alone.echoes(azimuths) if len(own) > 1 else echoes.chosen(own)

    def _shared(self, azimuths: AzimuthTimes, name: str, compute: Callable[[], Any]) -> Any:
        key = name, int(azimuths.number[0]), len(azimuths.number)
        if key not in self._kept:
            self._kept[key] = compute()
        return self._kept[key]
