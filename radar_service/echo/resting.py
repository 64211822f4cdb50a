"""Echoes of all that rests relative to the antenna: the same in every scan, except for passing shadows."""

from dataclasses import dataclass

import numpy as np

from radar_service.echo.echoes import SECOND_TIME, Echoes
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.echo.second_time_around import apparent_range, max_apparent_range
from radar_service.numerics import Flags, Floats, Indices, Polar, ResultCache, polar_from_map
from radar_service.propagation import LandBefore, received_amplitude, two_way_phase
from radar_service.scattering import Instant, ScattererSet
from radar_service.trace import OcclusionScene, ShadowSectors
from radar_service.world import BodyPoses, Scene, map_from_ordered_bodies

ROUNDING = 1e-9  # rad, by which azimuths may differ that are computed in two ways
STEPS = 4  # kept: threads may be this many visibility steps apart before one is computed again


@dataclass(frozen=True)
class RestingEchoes:
    """Echoes (E,) visible past all that rests, by rising azimuth.

    echoes: range, azimuth and amplitude on boresight.
    position: (E, 3) on the map [m].
    body: (E,) index in the set they come from.
    scene_body: (E,) index in the scene; SECOND_TIME for echoes of an earlier pulse.
    polar: the positions relative to the antenna.
    antenna: (3,) on the map [m].
    """

    echoes: Echoes
    position: Floats
    body: Indices
    scene_body: Indices
    polar: Polar
    antenna: Floats

    def __len__(self) -> int:
        return len(self.position)

    def within(self, max_range: float) -> "RestingEchoes":
        """The echoes that appear nearer than `max_range` [m]."""
        kept = np.flatnonzero(self.echoes.range < max_range)
        echoes = Echoes(self.echoes.range[kept], self.echoes.azimuth[kept], self.echoes.amplitude[kept])
        polar = Polar(*(part[kept] for part in self.polar))
        return RestingEchoes(echoes, self.position[kept], self.body[kept], self.scene_body[kept], polar, self.antenna)


@dataclass(frozen=True)
class OccludedEchoes(Echoes):
    """Resting echoes that moving bodies occlude. body: (E,) as `RestingEchoes.scene_body`."""

    body: Indices


class PassingShadows:
    """Resting echoes that moving bodies occlude, renewed once per visibility step. Safe to call from several threads.

    Bodies by aspect are not among them: `beam_passage` computes what shadows change of these.
    """

    def __init__(self, resting: RestingEchoes, line_of_sight: OcclusionScene, interval: float, steady: Flags) -> None:
        """interval: length of a visibility step [s]; steady: which bodies (B,) of the resting set do not depend on aspect."""
        self._resting, self._line_of_sight, self._interval = resting, line_of_sight, interval
        east, north, _ = (resting.position - resting.antenna).T
        self._steady = steady[resting.body]
        self._azimuth = np.arctan2(east, north)  # rising
        movers = line_of_sight.moving_shadow_sectors(resting.antenna, 0.0).middle
        self.possible = len(resting) > 0 and len(movers) > 0  # else no echo is ever occluded
        self._steps: ResultCache[tuple[int, bytes], OccludedEchoes] = ResultCache(STEPS, line_of_sight.revision)

    def at(self, step: int, time: float | None = None) -> OccludedEchoes:
        """Echoes occluded during a visibility step, with opposite sign: added, they cancel the resting ones.

        time: when those bodies are present that occlude [s]; None: the middle of the step.
        """
        time = (step + 0.5) * self._interval if time is None else time
        return self._steps.get((step, self._line_of_sight.presences.state(time)), lambda: self.computed(step, time))

    def computed(self, step: int, presence_time: float) -> OccludedEchoes:
        """Computes anew what `at` returns."""
        resting, echoes, line_of_sight = self._resting, self._resting.echoes, self._line_of_sight.as_of(presence_time)
        time = (step + 0.5) * self._interval
        behind = self._behind(line_of_sight.moving_shadow_sectors(resting.antenna, time))
        which = behind[line_of_sight.occluded_by_moving(resting.position[behind], resting.antenna, time)]
        return OccludedEchoes(
            echoes.range[which], echoes.azimuth[which], -echoes.amplitude[which], resting.scene_body[which]
        )

    def _behind(self, sectors: ShadowSectors) -> Indices:
        """Indices of the echoes in any of the sectors, rising: a few of all, found by their order."""
        behind = np.zeros(len(self._azimuth), dtype=np.bool_)
        for middle, half, begin in zip(*sectors, strict=True):
            for turn in (-2.0 * np.pi, 0.0, 2.0 * np.pi):
                first, last = np.searchsorted(
                    self._azimuth, [middle - half + turn - ROUNDING, middle + half + turn + ROUNDING]
                )
                behind[first:last] |= self._resting.polar.distance[first:last] >= begin
        return np.flatnonzero(behind & self._steady)


def resting_echoes(scene: Scene, scatterers: ScattererSet, line_of_sight: OcclusionScene, max_range: float) -> RestingEchoes:
    """Echoes of a set at rest for an antenna at rest, out to `max_range` [m]."""
    antenna = scene.antenna(0.0)[0]
    visible = scatterers.echoes(antenna, Instant(0.0, line_of_sight, max_range, movers=False))
    position = map_from_ordered_bodies(visible.position, visible.body, BodyPoses(scatterers.bodies).each_at(0.0))
    order = np.argsort(np.arctan2(*(position[:, :2] - antenna[:2]).T), kind="stable")
    position, visible, radar = position[order], visible.chosen(order), scene.radar
    polar = polar_from_map(position, antenna, line_of_sight.earth_radius)
    paths = Paths(visible.path, visible.height_span)
    land = LandBefore(line_of_sight, antenna, position - antenna, scatterers.key[visible.body])
    distance, factor = range_and_factor(radar, scene.environment, polar, position[:, 2], antenna[2], paths, land=land)
    amplitude = (
        visible.amplitude * factor * received_amplitude(radar, polar.range) * two_way_phase(distance, radar.wavelength)
    )
    echoes = Echoes(apparent_range(radar, distance), polar.azimuth, amplitude)
    scene_body = np.where(echoes.range < distance, SECOND_TIME, scatterers.key[visible.body])
    return RestingEchoes(echoes, position, visible.body, scene_body, polar, antenna).within(max_apparent_range(radar))
