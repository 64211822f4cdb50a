"""What the engine computes once for a scene: scatterers, line of sight, resting profiles, receiver, stages."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from radar_service.echo import (
    Beam,
    BeamPath,
    BeamTable,
    DirectPath,
    Echoes,
    LandPassages,
    MovingEchoes,
    PassingShadows,
    RestingEchoes,
    Visibility,
    max_echo_range,
    resting_echoes,
)
from radar_service.engine.land_rows import LandRows, follows_own_ship, is_diffuse_land, saves_time
from radar_service.numerics import BLAS_LIMIT, Floats, Profiles, effective_earth_radius, wrap_angle
from radar_service.radar import ChangedPattern, Radar, grid_rows
from radar_service.receive import Compression, azimuth_kernel, beam_filter, compression_for, spread
from radar_service.records import Fidelity
from radar_service.scattering import RestingModel, ScattererSet, ScatteringContext, build_scatterers
from radar_service.stages.registry import changed_pattern, effects_in, has_paths, numbers_of
from radar_service.stages.stage import Context, Stage
from radar_service.trace import OcclusionScene, RayCount
from radar_service.world import Body, Scene, is_land

MAX_TILE = 32  # azimuths
ECHOES_PER_PART = 8192  # resting echoes in a changed beam that are computed together
TILE_BYTES = 2**20  # of rows in a tile, which the L2 cache holds; MAX_TILE / 2 azimuths at least


@dataclass(frozen=True)
class Prepared:
    """One scene, ready for any azimuth. It can be pickled: caches stay behind, and Embree trees are built again.

    scene, fidelity: what it was prepared from. seed: of receiver noise.
    tile: azimuths computed together.
    line_of_sight: all that may occlude.
    resting_set, resting: bodies at rest relative to the antenna, and their visible echoes.
    resting_profiles: (A, bins) compressed profiles of these for a scan [sqrt(W)]; None where nothing rests.
    moving: echoes of all other bodies.
    land: rows of those bodies of the others that are land under way (`land_rows`); None where there is little of it.
    shadows: resting echoes that moving bodies occlude.
    shadowed: what their shadows change of bodies at rest by aspect.
    compression: matched filter, window and receiver noise.
    stages: of effects, by their names, in the order in which they add.
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
    land: LandRows | None
    shadows: PassingShadows
    shadowed: MovingEchoes
    compression: Compression
    stages: Mapping[str, Stage]


@BLAS_LIMIT.held()
def prepare(
    scene: Scene,
    fidelity: Fidelity,
    seed: int,
    silent: Collection[int] = (),
    transparent: Collection[int] = (),
    rays: RayCount | None = None,
    noise_seed: int | None = None,
) -> Prepared:
    """All that is computed once for a scene.

    silent: indices of bodies without echoes; transparent: indices of bodies that occlude nothing; rays: counts the rays cast;
    noise_seed: of what a near pulse has of its own.
    """
    radar, earth_radius = scene.radar, effective_earth_radius(scene.environment.earth_factor)
    line_of_sight = OcclusionScene(scene.bodies, earth_radius, transparent, rays, scene.revision)
    _ = line_of_sight.land if scene.environment.multipath else None  # made now, and not under the first beam
    context = scattering_context(scene, fidelity, seed, rays)
    resting_set, land_set, moving_set = _scatterers(scene, fidelity, silent, context)
    max_range = max_echo_range(radar)
    resting = resting_echoes(scene, resting_set, line_of_sight, max_range)
    visibility = Visibility(scene, moving_set, line_of_sight, max_range, fidelity.visibility_step)
    compression, metal = compression_for(radar, fidelity.kernel_width), resting_set.by_aspect
    max_tile = int(np.clip(TILE_BYTES // (8 * compression.size), MAX_TILE // 2, MAX_TILE))
    extent = min(np.pi, fidelity.beam_extent * radar.beamwidth)  # off boresight, of moving echoes
    oversampling = fidelity.beam_table_oversampling
    beam = BeamTable(radar.azimuth_gain, radar.beamwidth, extent, max_tile * radar.azimuth_step, oversampling)
    paths = _paths(scene, Beam(radar, beam_pattern(radar, fidelity)))
    unit = BeamTable(np.ones_like, radar.beamwidth, beam.extent, beam.span) if paths else beam  # paths have the gain
    moving = MovingEchoes(scene, visibility, unit, seed, paths=paths)
    noise_seed = seed if noise_seed is None else noise_seed
    return Prepared(
        scene,
        fidelity,
        noise_seed,
        int(np.clip(visibility.interval / radar.spoke_period, 1, max_tile)),  # within one visibility step
        line_of_sight,
        resting_set,
        resting,
        _resting_profiles(scene, fidelity, resting.echoes, compression),
        moving,
        _land_rows(scene, land_set, line_of_sight, max_range, fidelity, compression, beam, seed),
        PassingShadows(resting, line_of_sight, visibility.interval, ~np.isin(resting_set.key, metal.key)),
        MovingEchoes(
            scene, Visibility(scene, metal, line_of_sight, max_range, fidelity.visibility_step), unit, seed, True, paths
        ),
        compression,
        _stages(context, scene, noise_seed, line_of_sight, compression, moving, silent),
    )


def _stages(
    scattering: ScatteringContext, scene: Scene, noise_seed: int, line_of_sight: OcclusionScene, compression: Compression,
    moving: MovingEchoes, silent: Collection[int],
) -> dict[str, Stage]:  # fmt: skip
    """The stages of the effects of a scene of which the plan models something."""
    stages, fidelity, seed = dict[str, Stage](), scattering.fidelity, scattering.seed
    for effect in effects_in(scene):
        kind, of_effect = effect.stage(), (effect.name, scene, fidelity, seed, line_of_sight, compression)
        if any(item.modelled for item in kind.plan(scene, fidelity, None)):
            made_from = *of_effect, *numbers_of(scene, effect.name), noise_seed, scattering, moving, frozenset(silent)
            stages[effect.name] = kind.of(Context(*made_from))
    return stages


def _scatterers(
    scene: Scene, fidelity: Fidelity, silent: Collection[int], context: ScatteringContext
) -> tuple[ScattererSet, ScattererSet, ScattererSet]:
    """The scatterers of all that rests relative to the antenna and does not fluctuate, of land under way, and of all else."""
    resting = [rests(body, scene, fidelity) for body in scene.bodies]
    on_grid = [follows_own_ship(scene, fidelity) and is_diffuse_land(body, fidelity) for body in scene.bodies]

    def build(rests: bool, land: bool) -> ScattererSet:
        kinds = zip(resting, on_grid, strict=True)
        keys = [i for i, kind in enumerate(kinds) if kind == (rests, land) and i not in silent]
        return build_scatterers([scene.bodies[i] for i in keys], keys, context)

    land, others = build(False, True), build(False, False)
    if not saves_time(int(land.scatterers.sum()), scene.radar, fidelity):
        land, others = build_scatterers([], [], context), others.joined(land)
    return build(True, False), land, others


def scattering_context(scene: Scene, fidelity: Fidelity, seed: int, rays: RayCount | None = None) -> ScatteringContext:
    """What scatterers of bodies are built from; rays: counts the rays cast."""
    earth_radius = effective_earth_radius(scene.environment.earth_factor)
    where = scene.antenna(0.0)[0], scene.environment, scene.bodies, earth_radius
    return ScatteringContext(scene.radar, fidelity, seed, *where, rays, scene.name)


def rests(body: Body, scene: Scene, fidelity: Fidelity) -> bool:
    """Whether a body is the same in every scan, but for a loss on boresight; not where its echoes' paths differ by azimuth, or
    each is to have its own loss."""
    each = fidelity.azimuths_per_block <= 1 or scene.radar.second_time_around
    plain = (is_land(body) or not has_paths(scene.radar)) and not (each and scene.environment.attenuators)
    return scene.own_ship.at_rest and body.at_rest and body.swerling == 0 and plain


def _paths(scene: Scene, beam: Beam) -> list[BeamPath]:
    """The paths of moving echoes where there are others than the direct one, or something changes the beam on that."""
    effects = [effect for effect in effects_in(scene) if effect.has_paths]
    others = [path for effect in effects for path in effect.stage().paths(scene, beam, numbers_of(scene, effect.name)[1])]
    return [DirectPath(beam), *others] if effects or beam.pattern is not None else []


def _land_rows(
    scene: Scene, land: ScattererSet, line_of_sight: OcclusionScene, max_range: float, fidelity: Fidelity,
    compression: Compression, beam: BeamTable, seed: int,
) -> LandRows | None:  # fmt: skip
    """The rows of land under way; None without any."""
    if not len(land):
        return None
    points = cast(RestingModel, land.models[0]).resting_points()
    passages = LandPassages(scene, land.key, line_of_sight, max_range, points)
    visibility = Visibility(scene, land, line_of_sight, max_range, fidelity.visibility_step)
    return LandRows(scene, passages, MovingEchoes(scene, visibility, beam, seed), fidelity, compression)


def beam_pattern(radar: Radar, fidelity: Fidelity) -> ChangedPattern | None:
    """The antenna's pattern as effects change it, as far off boresight as the fidelity says; None where none does."""
    return changed_pattern(radar, min(np.pi, fidelity.beam_extent * radar.beamwidth))


def _resting_profiles(scene: Scene, fidelity: Fidelity, echoes: Echoes, compression: Compression) -> Profiles | None:
    """Profiles (A, bins) of resting echoes: spread on the azimuth-range grid, filtered by the beam, compressed."""
    if not len(echoes.range):
        return None
    radar = scene.radar
    filtered = beam_rows(scene, fidelity, echoes, compression, 0, compression.size)
    finished = np.empty((radar.azimuths, radar.bins), dtype=np.complex64)
    for start in range(0, radar.azimuths, MAX_TILE):
        finished[start : start + MAX_TILE] = compression.profiles(filtered[start : start + MAX_TILE])
    return finished


def beam_rows(
    scene: Scene, fidelity: Fidelity, echoes: Echoes, compression: Compression, first: int, columns: int
) -> Profiles:
    """Resting echoes in the beam at each azimuth (A, columns), before compression, from grid column `first` on.

    Grid columns are circular, so all that the echoes' kernels cover must lie within these columns.
    """
    radar = scene.radar
    beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
    rows = grid_rows(radar.azimuths, beamwidth)
    kernel = azimuth_kernel(beamwidth, rows, fidelity.beam_kernel_width)
    row = echoes.azimuth % (2.0 * np.pi) * (rows / (2.0 * np.pi))
    where = column(echoes.range, radar.range_step) - first
    grid = spread((rows, columns), row, where, echoes.amplitude, kernel, compression.kernel)
    filtered = beam_filter(grid, radar.azimuth_gain, kernel, radar.azimuths)
    _add_changes(filtered, scene, fidelity, echoes, compression, first)
    return filtered


def _add_changes(
    rows: Profiles, scene: Scene, fidelity: Fidelity, echoes: Echoes, compression: Compression, first: int
) -> None:
    """Adds to rows (A, columns) of resting echoes what effects change of the beam, by azimuths and directions."""
    radar, pattern = scene.radar, beam_pattern(scene.radar, fidelity)
    if pattern is None:
        return
    heading = float(scene.platform.heading(np.zeros(1))[0])
    behind = np.flatnonzero(pattern.reaches(echoes.azimuth - heading))
    for start in range(0, radar.azimuths, MAX_TILE):
        boresight = np.arange(start, min(start + MAX_TILE, radar.azimuths)) * radar.azimuth_step
        off = wrap_angle(echoes.azimuth[behind] - boresight[len(boresight) // 2])
        which = behind[np.abs(off) <= pattern.extent + MAX_TILE * radar.azimuth_step]
        for part in range(0, len(which), ECHOES_PER_PART):
            some = which[part : part + ECHOES_PER_PART]
            offset = echoes.azimuth[some, None] - boresight
            change = pattern.two_way_change(echoes.azimuth[some, None] - heading, offset)
            amplitude = (echoes.amplitude[some, None] * change).astype(np.complex64)
            still = np.zeros(amplitude.shape, dtype=np.float32)
            where = column(echoes.range[some], radar.range_step) - first
            compression.spread(rows[start : start + len(boresight)], where, still, amplitude)


def column(distance: Floats, range_step: float) -> Floats:
    """Grid column of a range: sample n stands at (n + 1/2) step."""
    return distance / range_step - 0.5
