"""The engine, stage by stage: scatterers, line of sight, range histories, grid, beam, compression, noise and clutter.

`prepare` does all that a scene needs once. `profiles` computes a few azimuths of any scan from it. What rests relative to the
antenna is spread on the grid once for the full circle, and kept as finished profiles. What moves, what fluctuates, and what a
moving body shadows, is computed azimuth by azimuth with its exact range, phase and beam weight (docs/engine.md).

Arithmetic runs in tiles that are the same however spokes are grouped afterwards, so bytes do not depend on the grouping.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from radar_service.clutter.clutter import Clutter, prepare_clutter
from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes, Echoes, concatenated
from radar_service.echo.moving import MovingEchoes
from radar_service.echo.moving_beam import BeamTable
from radar_service.echo.resting import PassingShadows, RestingEchoes, resting_echoes
from radar_service.echo.second_time_around import fold_ranges, max_echo_range
from radar_service.echo.visibility import Visibility
from radar_service.fidelity import Fidelity
from radar_service.frames import effective_earth_radius, wrap_angle
from radar_service.parallel import in_order
from radar_service.radar.antenna import grid_rows
from radar_service.radar.parameters import Radar
from radar_service.random import NOISE, generator
from radar_service.receive.beam import azimuth_kernel, beam_filter
from radar_service.receive.compression import Compression, compression_for
from radar_service.receive.detection import square_law
from radar_service.receive.gridding import spread
from radar_service.receive.interference import Interference
from radar_service.scattering.model import ScatteringContext
from radar_service.scattering.scatterer_set import ScattererSet, build_scatterers
from radar_service.scene.body import Body
from radar_service.scene.world import Scene
from radar_service.trace.embree import RayCount
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Flags, Floats, Indices, Profiles, Singles

MAX_TILE = 32  # azimuths
TILE_BYTES = 2**20  # of rows in a tile, which the L2 cache holds; MAX_TILE / 2 azimuths at least


@dataclass(frozen=True)
class Prepared:
    """One scene, ready for any azimuth. It can be pickled: caches stay behind, and Embree trees are built again.

    scene, fidelity, seed: what it was prepared from.
    tile: azimuths computed together.
    line_of_sight: all that may occlude.
    resting_set, resting: bodies at rest relative to the antenna, and their visible echoes.
    resting_profiles: (A, bins) compressed profiles of these for a scan [sqrt(W)]; None where nothing rests.
    moving: echoes of all other bodies.
    shadows: resting echoes that moving bodies occlude.
    compression: matched filter, window and receiver noise.
    clutter: of sea and rain; None where the scene has neither.
    interference: of each other radar.
    """

    scene: Scene
    fidelity: Fidelity
    seed: int
    tile: int
    line_of_sight: OcclusionScene
    resting_set: ScattererSet
    resting: RestingEchoes
    resting_profiles: Profiles | None
    moving: MovingEchoes
    shadows: PassingShadows
    compression: Compression
    clutter: Clutter | None
    interference: tuple[Interference, ...]


def prepare(
    scene: Scene,
    fidelity: Fidelity,
    seed: int,
    silent: Collection[int] = (),
    transparent: Collection[int] = (),
    rays: RayCount | None = None,
) -> Prepared:
    """All that is computed once for a scene.

    silent: indices of bodies without echoes; transparent: indices of bodies that occlude nothing; rays: counts the rays cast.
    """
    radar, earth_radius = scene.radar, effective_earth_radius(scene.environment.earth_factor)
    line_of_sight = OcclusionScene(scene.bodies, earth_radius, transparent, rays)
    resting_set, moving_set = _scatterers(scene, fidelity, seed, silent, rays)
    max_range = max_echo_range(radar)
    resting = resting_echoes(scene, resting_set, line_of_sight, max_range)
    visibility = Visibility(scene, moving_set, line_of_sight, max_range, fidelity.visibility_step)
    compression = compression_for(radar, fidelity.kernel_width)
    max_tile = int(np.clip(TILE_BYTES // compression.row_bytes, MAX_TILE // 2, MAX_TILE))
    return Prepared(
        scene,
        fidelity,
        seed,
        int(np.clip(visibility.interval / radar.spoke_period, 1, max_tile)),  # within one visibility step
        line_of_sight,
        resting_set,
        resting,
        _resting_profiles(radar, fidelity, resting.echoes, compression),
        MovingEchoes(scene, visibility, _beam_table(radar, fidelity, max_tile), seed),
        PassingShadows(resting, line_of_sight, visibility.interval),
        compression,
        prepare_clutter(scene, line_of_sight, compression, seed),
        tuple(Interference(scene, i, seed) for i in range(len(scene.interference))),
    )


def profiles(prepared: Prepared, azimuths: AzimuthTimes) -> Profiles:
    """Compressed range profiles (K, bins) [sqrt(W)] of the azimuths (K,) of one tile."""
    blind = prepared.scene.blind(azimuths.time, azimuths.boresight)
    rows = moving_rows(prepared, azimuths)
    field = receive(prepared, azimuths, rows, blind)
    add_resting(prepared, field, azimuths, blind)
    add_clutter(prepared, field, azimuths, blind)
    add_interference(prepared, field, azimuths)
    return field


def moving_rows(prepared: Prepared, azimuths: AzimuthTimes) -> Profiles | None:
    """Moving echoes spread on grid rows (K, size), before compression; None where there are none."""
    rows: Profiles | None = None
    if not len(prepared.moving) and not prepared.shadows.possible:
        return rows
    compression = prepared.compression
    for first, stop in blocks(prepared, azimuths):
        echoes = moving_echoes(prepared, azimuths.part(first, stop))
        if not len(echoes.range):
            continue
        if rows is None:
            rows = np.zeros((len(azimuths.time), compression.size), dtype=np.complex64)
        step = prepared.scene.radar.range_step
        migration = echoes.range_migration * np.float32(1.0 / step)
        compression.spread(rows[first:stop], _column(echoes.range, step), migration, echoes.amplitude)
    return rows


def visibility_steps(prepared: Prepared, azimuths: AzimuthTimes) -> Indices:
    """The number (K,) of the visibility step of each azimuth."""
    return np.asarray(azimuths.time // prepared.moving.visibility.interval, dtype=np.int64)


def blocks(prepared: Prepared, azimuths: AzimuthTimes) -> Iterator[tuple[int, int]]:
    """First and end of the blocks of a tile, each within one visibility step, so that no azimuth has the shadows of another."""
    steps, size = visibility_steps(prepared, azimuths), prepared.fidelity.azimuths_per_block
    edges = [0, len(steps)]
    if steps[0] != steps[-1]:
        edges[1:1] = (np.flatnonzero(np.diff(steps)) + 1).tolist()
    for start, end in pairwise(edges):
        for first in range(start, end, size):
            yield first, min(first + size, end)


def moving_echoes(prepared: Prepared, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
    """All moving echoes, and the resting ones that they shadow, with range, phase and beam weight at each azimuth."""
    parts: list[BeamWeightedEchoes] = []
    if len(prepared.moving):
        parts += fold_ranges(prepared.moving.echoes, azimuths, prepared.scene.radar)
    if prepared.shadows.possible:
        shadows = prepared.shadows.at(int(azimuths.middle // prepared.moving.visibility.interval))
        if len(shadows.range):
            parts.append(_beam_weighted(shadows, azimuths.boresight, prepared.scene.radar))
    return concatenated(parts, len(azimuths.time))


def receive(prepared: Prepared, azimuths: AzimuthTimes, rows: Profiles | None, blind: Flags) -> Profiles:
    """Compresses grid rows (K, size) and adds receiver noise: profiles (K, bins) [sqrt(W)]. Nothing is received where blind."""
    compression = prepared.compression
    spectrum = None
    if rows is not None:
        rows[blind] = 0.0
        spectrum = compression.spectrum(rows)
    if prepared.scene.environment.noise:
        scan, index = divmod(int(azimuths.number[0]), prepared.scene.radar.azimuths)
        rng = generator(prepared.seed, NOISE, scan, index // prepared.tile)
        if spectrum is None:
            spectrum = compression.noise.draw(len(azimuths.time), rng)
        else:
            compression.noise.add(spectrum, rng)
    if spectrum is None:
        return np.zeros((len(azimuths.time), compression.bins), dtype=np.complex64)
    return compression.from_spectrum(spectrum)


def add_resting(prepared: Prepared, field: Profiles, azimuths: AzimuthTimes, blind: Flags) -> None:
    """Adds the finished profiles of all that rests."""
    if prepared.resting_profiles is not None:
        start = int(azimuths.number[0]) % prepared.scene.radar.azimuths
        resting = prepared.resting_profiles[start : start + len(field)]
        field += np.where(~blind[:, None], resting, 0) if blind.any() else resting


def add_clutter(prepared: Prepared, field: Profiles, azimuths: AzimuthTimes, blind: Flags) -> None:
    """Adds sea and rain clutter."""
    if prepared.clutter is not None:
        prepared.clutter.add(field, azimuths.number, ~blind[:, None])


def add_interference(prepared: Prepared, field: Profiles, azimuths: AzimuthTimes) -> None:
    """Adds the pulses of other radars, which a blind sector does not stop."""
    for other in prepared.interference:
        other.add(field, azimuths.boresight, azimuths.time)


def tile_azimuths(prepared: Prepared, scan: int, start: int) -> AzimuthTimes:
    """The azimuths of the tile of a scan that begins at azimuth `start`, a multiple of `Prepared.tile`."""
    radar = prepared.scene.radar
    number = scan * radar.azimuths + np.arange(start, min(start + prepared.tile, radar.azimuths))
    return AzimuthTimes(number, *radar.schedule(number))


class Engine:
    """Computes scans of a prepared scene tile by tile, on one or more threads, which changes no byte."""

    def __init__(self, prepared: Prepared, threads: int = 1) -> None:
        self.prepared, self._threads = prepared, threads
        radar = prepared.scene.radar
        self.range: Floats = (np.arange(radar.bins, dtype=np.float64) + 0.5) * radar.range_step

    def tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles]]:
        """One scan: index of each tile's first azimuth, field (K, bins) [sqrt(W)] and power (K, bins) [W]; only tiles that
        hold any of the requested azimuths, where there are flags (A,) of these."""
        azimuths, tile = self.prepared.scene.radar.azimuths, self.prepared.tile
        starts = [n for n in range(0, azimuths, tile) if requested is None or requested[n : n + tile].any()]
        fields = in_order(partial(self._tile, scan), starts, self._threads)
        for start, field in zip(starts, fields, strict=True):
            yield start, field, square_law(field)

    def _tile(self, scan: int, start: int) -> Profiles:
        return profiles(self.prepared, tile_azimuths(self.prepared, scan, start))


def _scatterers(
    scene: Scene, fidelity: Fidelity, seed: int, silent: Collection[int], rays: RayCount | None
) -> tuple[ScattererSet, ScattererSet]:
    """The scatterers of all that rests relative to the antenna and does not fluctuate, and those of everything else."""
    resting = [_rests(body, scene) for body in scene.bodies]

    def build(rests: bool) -> ScattererSet:
        keys = [i for i, one in enumerate(resting) if one == rests and i not in silent]
        context = ScatteringContext(
            scene.radar,
            fidelity,
            seed,
            scene.antenna(0.0)[0],
            scene.environment,
            scene.bodies,
            effective_earth_radius(scene.environment.earth_factor),
            rays,
            scene.name,
        )
        return build_scatterers([scene.bodies[i] for i in keys], keys, context)

    return build(True), build(False)


def _rests(body: Body, scene: Scene) -> bool:
    return scene.own_ship.at_rest and body.motion.at_rest and body.swerling == 0


def _beam_table(radar: Radar, fidelity: Fidelity, max_tile: int) -> BeamTable:
    """The azimuth gain for moving echoes, as far off boresight as the fidelity says."""
    extent = min(np.pi, fidelity.beam_extent * radar.beamwidth)
    span = max_tile * radar.azimuth_step
    return BeamTable(radar.azimuth_gain, radar.beamwidth, extent, span, fidelity.beam_table_oversampling)


def _resting_profiles(radar: Radar, fidelity: Fidelity, echoes: Echoes, compression: Compression) -> Profiles | None:
    """Profiles (A, bins) of resting echoes: spread on the azimuth-range grid, filtered by the beam, compressed."""
    if not len(echoes.range):
        return None
    beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
    rows = grid_rows(radar.azimuths, beamwidth)
    kernel = azimuth_kernel(beamwidth, rows, fidelity.beam_kernel_width)
    row = echoes.azimuth % (2.0 * np.pi) * (rows / (2.0 * np.pi))
    column = _column(echoes.range, radar.range_step)
    grid = spread((rows, compression.size), row, column, echoes.amplitude, kernel, compression.kernel)
    filtered = beam_filter(grid, radar.azimuth_gain, kernel, radar.azimuths)
    finished = np.empty((radar.azimuths, radar.bins), dtype=np.complex64)
    for start in range(0, radar.azimuths, MAX_TILE):
        finished[start : start + MAX_TILE] = compression.profiles(filtered[start : start + MAX_TILE])
    return finished


def _column(distance: Floats, range_step: float) -> Floats:
    """Grid column of a range: sample n stands at (n + 1/2) step."""
    return distance / range_step - 0.5


def _beam_weighted(echoes: Echoes, boresight: Floats, radar: Radar) -> BeamWeightedEchoes:
    """Resting echoes (E,) at single azimuths, for boresights (K,) [rad]."""
    weight = radar.azimuth_gain(wrap_angle(boresight - echoes.azimuth[:, None]))
    amplitude = (weight * echoes.amplitude[:, None]).astype(np.complex64)
    return BeamWeightedEchoes(echoes.range, np.zeros(amplitude.shape, dtype=np.float32), amplitude)
