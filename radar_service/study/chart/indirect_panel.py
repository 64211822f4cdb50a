"""The seventh panel: indirect echoes of a rolling ship by a funnel of own ship, with one aspect a scan or with many."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.beam_paths import IndirectPaths
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.held_passages import CELL_PHASE, HeldPassages
from radar_service.echo.indirect import SPAN
from radar_service.echo.moving import MovingEchoes
from radar_service.echo.moving_beam import BeamTable
from radar_service.echo.second_time_around import max_echo_range
from radar_service.echo.visibility import Visibility
from radar_service.numerics.frames import effective_earth_radius
from radar_service.numerics.types import Floats, Indices
from radar_service.radar.structure_shadow import structure_reflectors
from radar_service.radar.structures import Structure
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import ScatteringContext
from radar_service.scattering.scatterer_set import build_scatterers
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.ships_panel import power_errors
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.scene import Scene

BALANCED = PRESETS["balanced"]
FUNNEL = 10.0, 3.0  # m: distance and width
FUNNEL_ASIDE = 0.5 * math.pi  # rad from the ship's bearing to the funnel's
CELLS = (0.25, 0.5, 1.0, 2.0)  # times as many cells as the engine has
BLOCK = 16  # azimuths computed together
COMPARED = 3  # azimuths of a scan
HELD, EACH = "one aspect a scan", "aspects as on boresight"
METHODS = len(CELLS) + 1


class EveryAspect(BeamPassages):
    """Bodies evaluated anew at each azimuth, which is computed alone."""

    def echoes(self, azimuths: AzimuthTimes, middle: float, half: float) -> list[ObservedEchoes]:
        (number,) = azimuths.number.tolist()
        return [self.evaluated(n, number, azimuths.middle) for n, _ in self.passing(azimuths.middle, middle, half)]


class FalseShip:
    """The indirect echoes of a ship alone on the sea, by a funnel abeam of her, by any method."""

    def __init__(self, scene: Scene) -> None:
        self.scene, radar, earth_radius = scene, scene.radar, effective_earth_radius(scene.environment.earth_factor)
        antenna = scene.antenna(0.0)[0]
        context = ScatteringContext(radar, BALANCED, 0, antenna, scene.environment, scene.bodies, earth_radius)
        scatterers, occlusion = build_scatterers(scene.bodies, [0], context), OcclusionScene(scene.bodies, earth_radius)
        self.visibility = Visibility(scene, scatterers, occlusion, max_echo_range(radar), BALANCED.visibility_step)
        self._extent = min(math.pi, BALANCED.beam_extent * radar.beamwidth)
        self._seen = scatterers, occlusion, max_echo_range(radar)
        self._direct = BeamPassages(scene, *self._seen, self._extent)

    def held(self, finer: float) -> HeldPassages:
        """One aspect a scan; finer: as of `HeldPassages`."""
        return HeldPassages(self.scene, self.visibility, self._direct, finer)

    def as_on_boresight(self) -> BeamPassages:
        """As many aspects as on boresight."""
        return BeamPassages(self.scene, *self._seen, math.pi)

    def every_aspect(self) -> EveryAspect:
        """An aspect at each azimuth."""
        return EveryAspect(self.scene, *self._seen, math.pi)

    def powers(self, passages: BeamPassages, numbers: Indices, block: int) -> Floats:
        """Powers (K,) of her indirect echoes at azimuths by number, a block of them together: fields in cells of range, squared
        and summed."""
        radar = self.scene.radar
        beam, paths = BeamTable(np.ones_like, radar.beamwidth, math.pi, SPAN), [IndirectPaths(radar, self._extent)]
        moving, result = MovingEchoes(self.scene, self.visibility, beam, 0, paths=paths, passages=passages), []
        for first in range(0, len(numbers), block):
            part = numbers[first : first + block]
            echoes = moving.echoes(AzimuthTimes(part, *radar.schedule(part)))
            cell = ((echoes.range[:, None] + echoes.range_migration) / radar.range_resolution).astype(np.int64)
            field = np.zeros((int(cell.max(initial=0)) + 1, len(part)), dtype=np.complex128)
            np.add.at(field, (cell, np.arange(len(part))[None]), echoes.amplitude)
            result.append((np.abs(field) ** 2).sum(axis=0))
        return np.concatenate(result)


def with_funnel(ship: Scene) -> Scene | None:
    """The ship's scene with a funnel abeam of the line of sight to her; None where the antenna's pattern allows no structures."""
    offset = ship.bodies[0].middle_at(0.0) - ship.antenna(0.0)[0]
    heading = float(ship.platform.heading(np.zeros(1))[0])
    bearing = math.atan2(offset[0], offset[1]) - heading + FUNNEL_ASIDE
    funnel = Structure("funnel", math.remainder(bearing, 2.0 * math.pi), FUNNEL[0], FUNNEL[1] / 2.0)
    changed = replace(ship, radar=replace(ship.radar, structures=(funnel,)))
    return changed if structure_reflectors(changed.radar) else None


def indirect_points(ship: Scene, scans: int, done: Callable[[], object]) -> list[Point]:
    """One point for each method of indirect echoes of a ship, by a funnel, from scans that follow one another; none where there
    are none. Powers are compared at COMPARED azimuths of each, at which she is evaluated anew. `done`: as of `dents_points`."""
    scene = with_funnel(ship)
    if scene is None:
        return []
    false, lit = FalseShip(scene), [_about_funnel(scene, scan, None) for scan in range(scans + 1)]
    compared = [_about_funnel(scene, scan, COMPARED) for scan in range(scans + 1)]
    exact = false.every_aspect()
    truth = [[false.powers(exact, numbers, 1)] for numbers in compared[1:]]
    if not any(powers.any() for (powers,) in truth):
        return []
    aspects = false.held(1.0)
    for numbers in compared:
        false.powers(aspects, numbers, BLOCK)  # what direct echoes have evaluated by then is not timed
    held = [false.held(finer) for finer in CELLS]
    results: list[list[list[Floats]]] = [[] for _ in range(len(held) + 1)]

    def run_held(passages: BeamPassages, result: list[list[Floats]]) -> None:
        scan = len(result) + 1
        powers = false.powers(passages, lit[scan], BLOCK)
        result.append([powers[np.searchsorted(lit[scan], compared[scan])]])

    def run_each(passages: BeamPassages, result: list[list[Floats]]) -> None:
        result.append([false.powers(passages, compared[len(result) + 1], BLOCK)])

    tasks = [partial(run_held, *each) for each in zip(held, results, strict=False)]
    tasks.append(partial(run_each, false.as_on_boresight(), results[-1]))
    times = time_interleaved(tasks, [scans] * len(tasks), done)
    times[-1] = tuple(t * len(lit[0]) / len(compared[0]) for t in times[-1])
    settings = [(HELD, f"cells of {CELL_PHASE / finer:g} rad", BALANCED.name if finer == 1.0 else None) for finer in CELLS]
    settings.append((EACH, "all centres", "reference"))
    return [
        Point(
            "indirect",
            family,
            setting,
            tuple(t / scene.radar.azimuths for t in taken),
            False,
            power_errors(powers, truth)[0],
            preset=preset,
        )
        for (family, setting, preset), taken, powers in zip(settings, times, results, strict=True)
    ]


def _about_funnel(scene: Scene, scan: int, count: int | None) -> Indices:
    """Numbers of azimuths of a scan that light the funnel; count: so many in their middle, None: all."""
    radar, (reflector,) = scene.radar, structure_reflectors(scene.radar)
    heading = float(scene.platform.heading(np.zeros(1))[0])
    middle = round((reflector.structure.bearing + heading) % (2.0 * math.pi) / radar.azimuth_step)
    half = int(reflector.lit_within / radar.azimuth_step) if count is None else count // 2
    return scan * radar.azimuths + middle + np.arange(-half, half + 1)
