"""The corrected engine: scatterers, visible echoes, azimuth/range grid, beam, compression (DESIGN section 4).

What rests relative to the antenna is laid once for the whole turn and kept as finished profiles. What moves, what
fluctuates, and what a mover shadows, is laid azimuth by azimuth with its exact range, phase and beam weight. Arithmetic
runs in tiles of at most TILE azimuths that are the same however spokes are grouped afterwards, so bytes do not depend on it.
"""

from collections.abc import Collection, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.block_cache import BlockCache
from radar_service.clutter.clutter import clutter_of
from radar_service.echo.moving import AzimuthTimes, MovingEchoes
from radar_service.echo.range_history import TABLE_STEPS, BeamTable, BeamWeightedEchoes, joined
from radar_service.echo.resting import resting_echoes
from radar_service.echo.second_time_around import echo_reach, fold_ranges
from radar_service.fidelity import Fidelity
from radar_service.frames import wrap_angle
from radar_service.parallel import in_order
from radar_service.propagation.radar_equation import Echoes
from radar_service.radar.antenna import grid_rows, quick_gain
from radar_service.random import NOISE, generator
from radar_service.receive.beam import Pattern, azimuth_kernel, sweep
from radar_service.receive.compression import compression_for
from radar_service.receive.gridding import spread
from radar_service.receive.interference import Interference
from radar_service.scattering.physical_optics.beam_crossing import BeamCrossing
from radar_service.scattering.rays import RayCaster, RaySampledSet, is_cast
from radar_service.scattering.scatterer_set import BodyEchoes, ScattererSource, build_scatterers
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene

Floats = NDArray[np.float64]
Profiles = NDArray[np.complex64]

TILE = 32  # azimuths per arithmetic tile at most
TILE_BYTES = (
    2**20
)  # of rows in a tile, which the L2 cache holds; 16 azimuths at least, fewer where things move far meanwhile


class CorrectedChain:
    """The engine for one scene: `tile` gives the profiles of consecutive azimuths of any scan."""

    def __init__(
        self,
        scene: Scene,
        fidelity: Fidelity,
        seed: int,
        occlusion: OcclusionScene,
        threads: int = 1,
        culled_bodies: Collection[int] = (),
    ) -> None:
        """left_out: indices of bodies that send nothing back; the landscape decides whether they hide anything."""
        self.threads, self._left_out = threads, culled_bodies
        self.scene, self.radar, self.fidelity, self.seed = scene, scene.radar, fidelity, seed
        self.range: Floats = (np.arange(scene.radar.bins, dtype=np.float64) + 0.5) * scene.radar.range_step
        self.compression = compression_for(scene.radar, fidelity.kernel_width)
        reach = echo_reach(scene.radar)
        self.occlusion = occlusion
        self.still, moving = self._ensembles()
        extent = min(np.pi, fidelity.beam_extent * scene.radar.beamwidth)
        most = int(np.clip(TILE_BYTES // (self.compression.size * np.dtype(np.complex64).itemsize), TILE // 2, TILE))
        span, steps = most * scene.radar.azimuth_step, fidelity.beam_table_oversampling * TABLE_STEPS
        beam = BeamTable(self._pattern, scene.radar.beamwidth, extent, span, steps)
        self.moving = MovingEchoes(scene, moving, self.occlusion, reach, beam, fidelity.visibility_step, seed)
        self.rows = int(np.clip(self.moving.interval / scene.radar.spoke_period, 1, most))  # a tile is one glance at most
        self.resting = resting_echoes(scene, self.still, self.occlusion, reach)
        self._profiles = self._resting_profiles()
        self._clutter = clutter_of(scene, occlusion, self.compression, self._pattern, seed)
        self._interference = [Interference(scene, i, self._pattern, seed) for i in range(len(scene.interference))]
        self._shadows = BlockCache(self._shadowed)

    def _ensembles(self) -> tuple[ScattererSource, ScattererSource]:
        """What rests relative to the antenna and does not fluctuate, and everything else, to be asked for reflections."""
        bodies, antenna = self.scene.bodies, self.scene.antenna(0.0)[0]
        sampler, earth_radius = self.fidelity.sampler, self.occlusion.earth_radius
        caster = None if sampler == "scatterers" else RayCaster(bodies, self.radar, earth_radius, sampler, self.seed)
        anchored = self.scene.own_ship.at_rest
        still = [anchored and body.motion.at_rest and body.swerling == 0 for body in bodies]
        per_cell, bounces = self.fidelity.scatterers_per_cell, self.fidelity.bounces

        def gathered(flag: bool) -> ScattererSource:
            keys = [i for i, rests in enumerate(still) if rests == flag and i not in self._left_out]
            gridded = [i for i in keys if caster is None or not is_cast(bodies[i])]
            passing = None if flag else BeamCrossing(self.scene)
            scatterers = build_scatterers(
                [bodies[i] for i in gridded],
                self.radar,
                antenna,
                per_cell,
                self.seed,
                gridded,
                bounces,
                passing,
                self.fidelity.min_scatterers,
            )
            if caster is None:
                return scatterers
            return RaySampledSet(tuple(bodies[i] for i in keys), np.array(keys, dtype=np.int64), scatterers, caster)

        return gathered(True), gathered(False)

    def _resting_profiles(self) -> Profiles | None:
        """Profiles (A, bins) of everything at rest, None where nothing is."""
        if not len(self.resting):
            return None
        echoes, radar = self.resting.echoes, self.radar
        beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
        rows = grid_rows(radar.azimuths, beamwidth)
        kernel = azimuth_kernel(beamwidth, rows, self.fidelity.beam_kernel_width)
        row = echoes.azimuth % (2.0 * np.pi) * (rows / (2.0 * np.pi))
        grid = spread(
            (rows, self.compression.size), row, self._column(echoes.range), echoes.amplitude, kernel, self.compression.kernel
        )
        swept = sweep(grid, self._pattern, kernel, radar.azimuths)
        profiles = np.empty((radar.azimuths, radar.bins), dtype=np.complex64)
        for start in range(0, radar.azimuths, TILE):
            profiles[start : start + TILE] = self.compression.profiles(swept[start : start + TILE])
        return profiles

    @property
    def rays(self) -> int:
        """Rays cast so far."""
        return self.occlusion.rays + self.still.rays + self.moving.ensemble.rays

    def look(self, number: int) -> tuple[BodyEchoes, Echoes]:
        """What is seen of all that moves during the glance of that number, and the echoes at rest that it hides."""
        shadows = self._shadows(number)
        return self.moving.seen(number), shadows

    def parts(self, scan: int) -> Iterator[tuple[int, Profiles, NDArray[np.float32]]]:
        """One revolution piece by piece: index of the first azimuth, field (K, bins) [sqrt(W)], power (K, bins) [W]."""
        starts = range(0, self.radar.azimuths, self.rows)
        for start, field in zip(starts, in_order(partial(self.tile, scan), starts, self.threads), strict=True):
            yield start, field, field.real**2 + field.imag**2

    def tile(self, scan: int, start: int) -> Profiles:
        """Profiles (K, bins) [sqrt(W)] of azimuths `start` to `start` + K of a scan; start is a multiple of `rows`."""
        at = self.instants(scan, start)
        index, number = at.number - scan * self.radar.azimuths, at.number
        blind = self.scene.blind(at.time, at.boresight)
        transmitting = ~blind[:, None]
        field = self._received(at, blind, scan, start)
        if self._profiles is not None:
            rest = self._profiles[start : start + len(index)]
            field += np.where(transmitting, rest, 0) if blind.any() else rest
        if self._clutter is not None:
            self._clutter.add(field, number, transmitting)
        for other in self._interference:
            other.add(field, at.boresight, at.time)
        return field

    def instants(self, scan: int, start: int) -> AzimuthTimes:
        """The azimuths of a tile."""
        number = scan * self.radar.azimuths + np.arange(start, min(start + self.rows, self.radar.azimuths))
        return AzimuthTimes(number, *self.radar.schedule(number))

    def _received(self, at: AzimuthTimes, blind: NDArray[np.bool_], scan: int, start: int) -> Profiles:
        """Profiles (K, bins) of all that moves and of the receiver's noise."""
        spectrum = None
        gridded = self._laid_moving(at)
        if gridded is not None:
            gridded[blind] = 0.0
            spectrum = self.compression.spectrum(gridded)
        if self.scene.environment.noise:
            rng = generator(self.seed, NOISE, scan, start // self.rows)
            if spectrum is None:
                spectrum = self.compression.noise.drawn(len(at.time), rng)
            else:
                self.compression.noise.add(spectrum, rng)
        if spectrum is None:
            return np.zeros((len(at.time), self.radar.bins), dtype=np.complex64)
        return self.compression.from_spectrum(spectrum)

    def _laid_moving(self, at: AzimuthTimes) -> Profiles | None:
        """Rows (K, size) of all that moves and passes, as many azimuths swept together as the fidelity says."""
        step = self.fidelity.azimuths_per_block
        rows: Profiles | None = None
        for first in range(0, len(at.time), step):
            part = at.part(first, first + step)
            echoes = self._swept_together(part)
            if not len(echoes.range):
                continue
            if rows is None:
                rows = np.zeros((len(at.time), self.compression.size), dtype=np.complex64)
            range_migration = echoes.range_migration * np.float32(1.0 / self.radar.range_step)
            self.compression.spread(
                rows[first : first + step], self._column(echoes.range), range_migration, echoes.amplitude
            )
        return rows

    def _swept_together(self, at: AzimuthTimes) -> BeamWeightedEchoes:
        """Every moving echo, and every passing shadow, where it is at its instant."""
        parts = []
        if len(self.moving):
            parts += fold_ranges(self.moving.swept, at, self.radar)
        shadows = self._shadows(int(at.middle // self.moving.interval))
        if len(shadows.range):
            parts.append(_swept_at_rest(shadows, at.boresight, self._pattern))
        return joined(parts, len(at.time))

    def _shadowed(self, visibility_step: int) -> Echoes:
        return self.resting.shadows(self.occlusion, (visibility_step + 0.5) * self.moving.interval)

    def _column(self, distance: Floats) -> Floats:
        return distance / self.radar.range_step - 0.5

    def _pattern(self, offset: Floats) -> Floats:
        return quick_gain(offset, self.radar.beamwidth, self.radar.pattern)


def _swept_at_rest(echoes: Echoes, boresight: Floats, pattern: Pattern) -> BeamWeightedEchoes:
    """Echoes at rest (E,) as single azimuths see them, for boresights (K,) [rad]."""
    weight = pattern(wrap_angle(boresight - echoes.azimuth[:, None]))
    amplitude = (weight * echoes.amplitude[:, None]).astype(np.complex64)
    return BeamWeightedEchoes(echoes.range, np.zeros(amplitude.shape, dtype=np.float32), amplitude)
