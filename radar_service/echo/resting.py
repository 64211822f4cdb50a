"""Echoes of what rests relative to the antenna: the same from every azimuth of every scan, but for passing shadows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.second_time_around import apparent_range, heard_reach
from radar_service.frames import Polar, polar_from_map
from radar_service.propagation.radar_equation import Echoes, path_factor, received_amplitude, two_way_phase
from radar_service.scattering.scatterer_set import ScattererSource, placed
from radar_service.scene.poses import BodyPoses
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class RestingEchoes:
    """Echoes (E,) of the scatterers seen past all that rests, by rising azimuth, their places (E, 3) on the map [m] and the
    bodies (E,) of the ensemble that they come from."""

    echoes: Echoes
    place: Floats
    body: Indices
    polar: Polar
    antenna: Floats  # (3,)

    def __len__(self) -> int:
        return len(self.place)

    def shadows(self, occlusion: OcclusionScene, time: float) -> Echoes:
        """The echoes that movers hide at `time` [s], with their sign turned: added, they take the hidden ones away."""
        hidden = occlusion.shadowed(self.place, self.polar, self.antenna, time)
        echoes = self.echoes
        return Echoes(echoes.range[hidden], echoes.azimuth[hidden], -echoes.amplitude[hidden])


def resting_echoes(scene: Scene, ensemble: ScattererSource, occlusion: OcclusionScene, reach: float) -> RestingEchoes:
    """The echoes of an ensemble at rest, as an antenna at rest sees it out to `reach` [m]."""
    antenna = scene.antenna(0.0)[0]
    seen = ensemble.reflections(occlusion, antenna, 0.0, reach, movers=False)
    place = placed(seen.position, seen.body, BodyPoses(ensemble.bodies).poses_at(0.0))
    order = np.argsort(np.arctan2(*(place[:, :2] - antenna[:2]).T), kind="stable")
    place, scattering, body = place[order], seen.amplitude[order], seen.body[order]
    polar = polar_from_map(place, antenna, occlusion.earth_radius)
    heard = apparent_range(scene.radar, polar.range) < heard_reach(scene.radar)
    place, scattering, body, polar = place[heard], scattering[heard], body[heard], Polar(*(part[heard] for part in polar))
    path = path_factor(scene.radar, scene.environment, polar, place[:, 2])
    level = received_amplitude(scene.radar, polar.range)
    amplitude = scattering * path * level * two_way_phase(polar.range, scene.radar.wavelength)
    apparent = apparent_range(scene.radar, polar.range)
    return RestingEchoes(Echoes(apparent, polar.azimuth, amplitude), place, body, polar, antenna)
