"""Bodies by aspect as indirect echoes have them: one aspect a scan, that of the beam's crossing, summed in cells.

Indirect echoes are weak, and stand elsewhere than their targets. A structure is some metres off the antenna, so it has another
aspect of a target than the antenna anyway. They take the aspect that the direct echo has at its crossing, which is there already.
Its centres, by the sea too, are summed with their phases in cells of range and bearing. Cells have exact ranges at each azimuth.
"""

from dataclasses import replace

import numpy as np

from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.visibility import Visibility
from radar_service.numerics.frames import effective_earth_radius, polar_from_map, wrap_angle
from radar_service.numerics.result_cache import ResultCache
from radar_service.numerics.types import Floats
from radar_service.propagation.land_reflection import LandBefore
from radar_service.propagation.radar_equation import radar_two_rays, two_way_phase
from radar_service.scattering.model import DIRECT, BodyEchoes
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.scene import Scene

CELLS_PER_RANGE = 2.0  # in a range resolution: centres move by a quarter of one at most
CELLS_PER_BEAM = 4.0  # in a beamwidth, at least: sidelobes, half as wide as the main lobe, are followed
CELL_PHASE = 1.0  # rad at most by which the way by the farthest structure differs in a cell
PASSAGES_PER_BODY = 4  # kept: those in use, and those of threads that are ahead
TINY = 1e-30  # m^2


class HeldPassages(BeamPassages):
    """All bodies of a set, each with one aspect for all azimuths about a crossing. Safe to call from several threads."""

    def __init__(self, scene: Scene, visibility: Visibility, direct: BeamPassages) -> None:
        """direct: passages of the same bodies, but for those at rest, as their direct echoes have them."""
        super().__init__(scene, visibility.scatterers, visibility.line_of_sight, visibility.max_range, np.pi)
        self._direct = direct
        self._in_direct = {int(key): number for number, key in enumerate(direct.key.tolist())}
        count = PASSAGES_PER_BODY * max(1, len(self))
        self._held: ResultCache[tuple[int, int, bytes], ObservedEchoes] = ResultCache(count, scene.revision)
        self._resting: ResultCache[int, ObservedEchoes] = ResultCache(max(1, len(self)))

    def echoes(self, azimuths: AzimuthTimes, middle: float, half: float) -> list[ObservedEchoes]:
        time = azimuths.middle
        present = self._line_of_sight.present(time)[self.key]
        parts = [self.held(n, crossing, time) for n, crossing in self.passing(time, middle, half) if present[n]]
        return ObservedEchoes.joined(parts)

    def held(self, n: int, crossing: int, time: float) -> ObservedEchoes:
        """The echoes of body n for all azimuths about a crossing; those bodies occlude that are present at `time` [s]."""
        key, time = self._passage(n, crossing, time)
        return self._held.get(key, lambda: self._computed(n, crossing, time))

    def _computed(self, n: int, crossing: int, time: float) -> ObservedEchoes:
        """Computes `held` anew."""
        number = self._in_direct.get(int(self.key[n]))
        if number is None and self._casters(n, crossing, self._half_angle(n, crossing), resting=True):
            return self._cells(n, self.evaluated(n, crossing, time), crossing)
        if number is None:
            return self._resting.get(n, lambda: self._cells(n, self._unshaded(n, crossing, time), crossing))
        nodes = self._direct.nodes(number, crossing, time)
        node = int(nodes[np.abs(nodes - crossing).argmin()])
        return self._cells(n, self._direct.node(number, node, time), node)

    def _unshaded(self, n: int, crossing: int, time: float) -> ObservedEchoes:
        """The echoes of body n, which rests as the antenna does, without shadows of moving bodies."""
        model, local, body = self._aspects[n]
        antenna, instant = self._observed(crossing, time)
        echoes = model.body_echoes(local, antenna, replace(instant, movers=False))
        (position,) = self._placed(n, [echoes], instant.time)
        return ObservedEchoes(replace(echoes, body=np.full(len(echoes), body)), position)

    def _cells(self, n: int, observed: ObservedEchoes, node: int) -> ObservedEchoes:
        """Echoes of body n as it is at a node, summed in cells."""
        antenna = self._scene.antenna(self._scene.radar.time_of_spokes(float(node)))[0]
        return in_cells(observed, self._aspects[n].body, antenna, self._scene, self._line_of_sight)


def in_cells(
    observed: ObservedEchoes, body: int, antenna: Floats, scene: Scene, line_of_sight: OcclusionScene
) -> ObservedEchoes:
    """Echoes of one body, with its index, summed in cells of range and bearing: each at the middle of their power, with the field
    of all together for the antenna (3,) [m], by the sea too. line_of_sight: past all bodies."""
    echoes, radar, earth_radius = observed.echoes, scene.radar, effective_earth_radius(scene.environment.earth_factor)
    if not len(echoes):
        return replace(observed, echoes=replace(echoes, body=np.full(0, body)))
    polar = polar_from_map(observed.position, antenna, earth_radius)
    farthest = max(structure.distance for structure in radar.effects["structures"])
    widest = min(radar.beamwidth / CELLS_PER_BEAM, CELL_PHASE * radar.wavelength / (2.0 * np.pi * farthest))
    steps = radar.range_resolution / CELLS_PER_RANGE, widest
    aside, path = wrap_angle(polar.azimuth - polar.azimuth[0]), np.minimum(echoes.path, DIRECT)
    cells = np.stack([np.floor(polar.range / steps[0]), np.floor(aside / steps[1]), path.astype(np.float64)])
    _, first, cell = np.unique(cells, axis=1, return_index=True, return_inverse=True)
    cell = cell.ravel()
    power = np.abs(echoes.amplitude) ** 2 + TINY
    total = np.bincount(cell, power)

    def middle(values: Floats) -> Floats:
        return np.stack([np.bincount(cell, power * column) / total for column in values.T], axis=-1)

    position = middle(observed.position)
    farther = polar.range - polar_from_map(position, antenna, earth_radius).range[cell]
    amplitude = echoes.amplitude
    by_sea = np.flatnonzero(echoes.path > DIRECT)
    if len(by_sea):
        place, way = observed.position[by_sea, 2], echoes.path[by_sea]
        land = LandBefore(line_of_sight, antenna, observed.position[by_sea] - antenna)
        rays = radar_two_rays(radar, scene.environment, polar.distance[by_sea], place, float(antenna[2]), land=land)
        amplitude = amplitude.copy()
        amplitude[by_sea] *= rays.ratio**way
        farther[by_sea] += way / 2.0 * rays.geometry.excess
    turned = amplitude * two_way_phase(farther, radar.wavelength)
    summed = np.bincount(cell, turned.real) + 1j * np.bincount(cell, turned.imag)
    which, height = np.full(len(first), body), middle(echoes.height_span[:, None])[:, 0]
    return ObservedEchoes(BodyEchoes(middle(echoes.position), summed, which, path[first], height), position)
