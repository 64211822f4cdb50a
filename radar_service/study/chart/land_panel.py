"""The fifth panel: land as a ship under way observes it, on the grid that follows her and by range histories."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

import numpy as np

from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.land import PIECE, LandPassages
from radar_service.echo.moving import MovingEchoes
from radar_service.echo.second_time_around import max_echo_range
from radar_service.echo.visibility import Visibility
from radar_service.engine.land_rows import RINGS, LandRows, follows_own_ship, is_diffuse_land, saves_time
from radar_service.engine.pipeline import profiles
from radar_service.engine.preparation import MAX_TILE, Prepared, beam_table, prepare
from radar_service.numerics.constants import KNOT
from radar_service.numerics.types import Profiles
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.resting_points import RestingModel
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.study.chart.field_panel import relative_db
from radar_service.study.chart.frozen_scene import all_scatterers, frozen
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.world.motion import Motion
from radar_service.world.scene import Scene

SPEED = 8.0 * KNOT  # of own ship, straight ahead
BALANCED = PRESETS["balanced"]
TILE = MAX_TILE // 2  # azimuths computed together, which any range allows
NUMBERS_OF_RINGS = (1, 2, 4, 8, 16)
PIECES = (16, 32, 128)  # azimuths, beside those of the engine
STEPS = (0.5, 1.0, 2.0, 5.0, 20.0)  # m of own ship's way, after which visibility is computed again
FINEST, FINEST_BLOCK = 0.1, 4  # m and azimuths: such steps, and blocks of histories, in what all are compared with
SLOWEST = PRESETS["reference"]
METHODS = len(NUMBERS_OF_RINGS) + len(PIECES) + len(STEPS) + 2  # at most, with the finest one


@dataclass(frozen=True)
class Method:
    """One way to compute land. family, setting: as of `Point`; prepared: with land alone; preset: that does so, if any."""

    family: str
    setting: str
    prepared: Prepared
    preset: str | None = None

    def fields(self, first: int, stop: int) -> Profiles:
        """Profiles (stop - first, bins) of azimuths by number, which are computed in tiles."""
        return np.concatenate(
            [profiles(self.prepared, self._azimuths(n, min(n + TILE, stop))) for n in range(first, stop, TILE)]
        )

    def _azimuths(self, first: int, stop: int) -> AzimuthTimes:
        number = np.arange(first, stop)
        return AzimuthTimes(number, *self.prepared.scene.radar.schedule(number))


def land_under_way(scene: Scene) -> Scene | None:
    """The land of a scene alone, which own ship passes at SPEED, straight ahead, without clutter, noise and other radars; None
    where there is none, or its pulse or beam does not allow the grid."""
    stopped = frozen(scene)
    pose = stopped.own_ship.pose(0.0)
    velocity = SPEED * np.array([np.sin(pose.heading[0]), np.cos(pose.heading[0]), 0.0])
    environment = replace(scene.environment, noise=False, sea_state=0, rain_mm_h=0.0)
    bodies = tuple(body for body in scene.bodies if body.at_rest and is_diffuse_land(body, BALANCED))
    own_ship = Motion(np.zeros(1), pose.position, pose.heading, velocity)
    land_scene = replace(
        stopped.with_world(environment=environment, bodies=bodies),
        radar=replace(stopped.radar, second_time_around=False),
        platform=replace(stopped.platform, motion=own_ship),
        interference=(),
    )
    return land_scene if bodies and follows_own_ship(land_scene, BALANCED) else None


def land_points(land_scene: Scene, azimuths: int, repeats: int, seed: int, done: Callable[[], object]) -> list[Point]:
    """One point for each method, from runs of `azimuths` that follow one another, from where most of the land is; none where no
    land is in sight.

    `done` is called for each run of a method. The slowest has one run.
    """
    methods = _methods(land_scene, seed)
    first = _first(methods[0], land_scene, azimuths)
    grids = [method for method in methods if method.prepared.land is not None]
    for method in grids:
        method.fields(first - TILE, first)  # pieces that the beam meets already are there as the clock starts
    results: list[list[Profiles]] = [[] for _ in methods]

    def run(method: Method, fields: list[Profiles]) -> None:
        start = first + len(fields) * azimuths
        fields.append(method.fields(start, start + azimuths))

    runs = [1 if method.preset == SLOWEST.name else repeats for method in methods]
    times = time_interleaved([partial(run, *each) for each in zip(methods, results, strict=True)], runs, done)
    exact = np.concatenate(results[-1]).astype(np.complex128)
    if not exact[:azimuths].any():
        return []
    return [
        Point(
            "land",
            method.family,
            method.setting,
            tuple(t / azimuths for t in taken),
            False,
            relative_db(np.concatenate(fields), exact[: len(fields) * azimuths]),
            preset=method.preset,
        )
        for method, taken, fields in zip(methods[:-1], times, results, strict=False)
    ]


def _first(grid: Method, land_scene: Scene, azimuths: int) -> int:
    """The azimuth number, in the second scan, from which boresight passes most points of land within range in `azimuths`."""
    assert grid.prepared.land is not None
    east, north = (grid.prepared.land.passages.points.position - land_scene.antenna(0.0)[0])[:, :2].T
    within = np.hypot(east, north) < land_scene.radar.range_max
    azimuth = np.arctan2(east[within], north[within]) % (2.0 * np.pi) / land_scene.radar.azimuth_step
    counts = np.bincount(azimuth.astype(np.int64) // azimuths, minlength=1)
    return land_scene.radar.azimuths + int(np.argmax(counts)) * azimuths


def _methods(land_scene: Scene, seed: int) -> list[Method]:
    """All methods on the same points of land; the last is what the others are compared with."""
    empty = prepare(land_scene, BALANCED, seed, silent=range(len(land_scene.bodies)))
    points = all_scatterers(land_scene, BALANCED, seed)
    gridded = saves_time(int(points.scatterers.sum()), land_scene.radar, BALANCED)
    way = land_scene.radar.spoke_period * SPEED
    methods = []
    for rings in NUMBERS_OF_RINGS:
        preset = BALANCED.name if gridded and rings == RINGS else None
        setting = f"{rings} ring{'s' * (rings > 1)}"
        methods.append(Method("grid, rings", setting, _on_grid(empty, points, rings), preset))
    for piece in PIECES:
        if follows_own_ship(land_scene, BALANCED, piece):
            methods.append(Method("grid, visibility", f"each {way * piece:.2g} m", _on_grid(empty, points, RINGS, piece)))
    for step in STEPS:
        prepared = _by_histories(empty, points, BALANCED.azimuths_per_block, step)
        preset = BALANCED.name if not gridded and step == BALANCED.visibility_step else None
        methods.append(Method("range histories", f"each {step:g} m", prepared, preset))
    finest = _by_histories(empty, points, FINEST_BLOCK, FINEST)
    single = _by_histories(empty, points, SLOWEST.azimuths_per_block, SLOWEST.visibility_step)
    methods.append(Method("azimuth by azimuth", f"each {SLOWEST.visibility_step:g} m", single, SLOWEST.name))
    return [*methods, Method("finest", f"each {FINEST:g} m", finest)]


def _on_grid(empty: Prepared, points: ScattererSet, rings: int = RINGS, per_piece: int = PIECE) -> Prepared:
    """A scene prepared without echoes, with its land on a grid; per_piece: azimuths between two computations of visibility."""
    scene, fidelity, max_range = empty.scene, empty.fidelity, max_echo_range(empty.scene.radar)
    resting = cast(RestingModel, points.models[0]).resting_points()
    passages = LandPassages(scene, points.key, empty.line_of_sight, max_range, resting, per_piece)
    return replace(empty, land=LandRows(scene, passages, _echoes(empty, points), fidelity, empty.compression, rings))


def _by_histories(empty: Prepared, points: ScattererSet, per_block: int, step: float) -> Prepared:
    """A scene prepared without echoes, whose points of land have a range history each.

    per_block: azimuths over which they are interpolated; step: of visibility [m].
    """
    fidelity = replace(empty.fidelity, azimuths_per_block=per_block, visibility_step=step)
    changed = replace(empty, fidelity=fidelity)
    return replace(changed, moving=_echoes(changed, points))


def _echoes(prepared: Prepared, points: ScattererSet) -> MovingEchoes:
    """The points of land by range histories, at the fidelity of a prepared scene."""
    scene, fidelity, max_range = prepared.scene, prepared.fidelity, max_echo_range(prepared.scene.radar)
    visibility = Visibility(scene, points, prepared.line_of_sight, max_range, fidelity.visibility_step)
    return MovingEchoes(scene, visibility, beam_table(scene.radar, fidelity, MAX_TILE), prepared.seed)
