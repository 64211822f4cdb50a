"""Rays as a second estimator of what diffuse surfaces send back, independent of the scatterers (DESIGN section 4).

Rays spread evenly round the antenna find the surfaces, and each hit carries the area that its ray sees. It answers the same
question as the scatterers in its own way: no points on surfaces, no densities, no tests of visibility. Bodies with a
declared cross-section, points and optics have no such integral: they stay with the ensemble, and only stop rays.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import body_rotation, direction, map_from_body
from radar_service.radar.parameters import Radar
from radar_service.random import CAST, generator
from radar_service.scattering.scatterer_set import BodyEchoes, ScattererSet, Sector
from radar_service.scene.poses import pose_at
from radar_service.scene.world import Body, Mesh
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.trace.occluder import BodyPose
from radar_service.trace.ray_sampling import rays_round
from radar_service.trace.ray_target import RayTarget, sea_range

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
STILL = BodyPose(np.zeros(3), 0.0)


def is_cast(body: Body) -> bool:
    """Whether rays estimate what a body sends back: it has a diffuse surface (none is declared)."""
    return body.mesh is not None and body.scattering == "diffuse"


@dataclass(frozen=True)
class Hits:
    """Where rays met bodies (H,): the body's index in the scene, the place (H, 3) [m] in its own frame, slant range [m], the
    solid angle [sr] of the ray, and its random phasor."""

    body: Indices
    position: Floats
    range: Floats
    solid_angle: Floats
    phasor: NDArray[np.complex128]

    def __len__(self) -> int:
        return len(self.body)


def hit_amplitude(hits: Hits, gamma: Floats) -> NDArray[np.complex128]:
    """Root of the cross-section [m] with its phase (H,) that each hit stands for; gamma (B,) of the bodies of the scene.

    The ray sees the area R^2 dOmega / cos i, of sigma0 = gamma cos i: the cosines cancel, and a hit needs no normal.
    """
    return np.asarray(np.sqrt(gamma[hits.body] * hits.range**2 * hits.solid_angle) * hits.phasor)


class RayCaster:
    """All triangles of a scene, ready for rays: what a ray meets first is a hit, and hides what is behind."""

    def __init__(self, bodies: Sequence[Body], radar: Radar, earth_radius: float, sampler: str, seed: int) -> None:
        self.bodies, self.radar, self.earth_radius = tuple(bodies), radar, earth_radius
        self.sampler, self.seed = sampler, seed
        self.cast = 0  # rays so far
        self.gamma: Floats = np.array([body.material.gamma for body in bodies], dtype=np.float64)
        still = [key for key, body in enumerate(bodies) if body.mesh is not None and body.motion.at_rest]
        self._still = np.array(still, dtype=np.int64)
        self._still_last = np.cumsum([_triangles(bodies[key]) for key in still])
        self._landscape = RayTarget(_on_map([bodies[key] for key in still]), earth_radius) if still else None
        self._movers = {
            key: RayTarget(body.mesh, earth_radius)
            for key, body in enumerate(bodies)
            if body.mesh is not None and not body.motion.at_rest
        }

    def hits(self, antenna: Floats, time: float, reach: float, movers: bool = True) -> Hits:
        """What a turn of rays from the antenna (3,) meets at `time` [s] within `reach` [m]; movers: whether what moves is
        there at all. Each instant has rays and phases of its own, the same for the same seed."""
        radar = self.radar
        random = generator(self.seed, CAST, int(np.float64(time).view(np.int64)))
        rays = rays_round(self.sampler, random, radar.rays, radar.beamwidth, radar.beamwidth_el, radar.tilt)
        self.cast += len(rays)
        sight = direction(rays.azimuth, rays.elevation)
        nearest = np.minimum(sea_range(rays.elevation, float(antenna[2]), self.earth_radius), reach)
        body, position = np.full(len(rays), -1, dtype=np.int64), np.zeros((len(rays), 3))
        if self._landscape is not None:
            which, triangle = _closer(self._landscape, STILL, antenna, sight, nearest)
            body[which] = self._still[np.searchsorted(self._still_last, triangle, side="right")]
            position[which] = self._landscape.place(STILL, antenna, sight[which], nearest[which])
        for key, target in self._movers.items() if movers else ():
            stand = pose_at(self.bodies[key], time)
            which, _ = _closer(target, stand, antenna, sight, nearest)
            body[which] = key
            position[which] = target.place(stand, antenna, sight[which], nearest[which])
        phasor = np.exp(2j * np.pi * random.random(len(rays)))
        met = np.flatnonzero(body >= 0)
        places = self._own_frames(body[met], position[met])
        return Hits(body[met], places, nearest[met], rays.solid_angle[met], phasor[met])

    def _own_frames(self, body: Indices, position: Floats) -> Floats:
        """Hits on bodies at rest were met on the map: their places (H, 3) in the frames of their bodies."""
        for key in np.intersect1d(body, self._still):
            mine, stand = body == key, pose_at(self.bodies[key], 0.0)
            position[mine] = (position[mine] - stand.position) @ body_rotation(stand.heading)
        return position


@dataclass(frozen=True)
class RaySampledSet:
    """B bodies, of which rays see the diffuse ones, and an ensemble of scatterers the others."""

    bodies: tuple[Body, ...]
    key: Indices  # (B,) index of each body in the scene
    others: ScattererSet
    caster: RayCaster

    def __len__(self) -> int:
        return len(self.bodies)

    @property
    def rays(self) -> int:
        """Rays cast so far: those of the sampler, each whole, and from bounce to bounce."""
        return self.caster.cast + self.others.rays

    def forget(self) -> None:
        """Have physical optics evaluated anew next time: so that it can be timed."""
        self.others.forget()

    def reflections(
        self,
        occlusion: OcclusionScene,
        antenna: Floats,
        time: float,
        reach: float,
        movers: bool = True,
        sector: Sector | None = None,
    ) -> BodyEchoes:
        """What the antenna (3,) sees of bodies as they stand at `time` [s]; arguments as in `ScattererSet.reflections`. Rays are
        always cast all round."""
        declared = self.others.reflections(occlusion, antenna, time, reach, movers, sector)
        hits = self.caster.hits(antenna, time, reach, movers)
        index = np.full(len(self.caster.bodies), -1, dtype=np.int64)  # of each body of the scene, in this ensemble
        index[self.key[[is_cast(body) for body in self.bodies]]] = np.flatnonzero([is_cast(b) for b in self.bodies])
        mine = np.flatnonzero(index[hits.body] >= 0)
        place = np.searchsorted(self.key, self.others.key)  # of each body of the others, in this ensemble
        body = np.concatenate([index[hits.body[mine]], place[declared.body]])
        order = np.argsort(body, kind="stable")
        position = np.concatenate([hits.position[mine], declared.position])
        amplitude = np.concatenate([hit_amplitude(hits, self.caster.gamma)[mine], declared.amplitude])
        return BodyEchoes(position[order], amplitude[order], body[order])


def _closer(target: RayTarget, stand: BodyPose, antenna: Floats, sight: Floats, nearest: Floats) -> tuple[Indices, Indices]:
    """Which rays meet this target before `nearest` (M,) [m], which is lowered for them, and in which of its triangles."""
    triangle, distance = target.first_hit(stand, antenna, sight)
    which = np.flatnonzero(distance < nearest)
    nearest[which] = distance[which]
    return which, triangle[which]


def _triangles(body: Body) -> int:
    return 0 if body.mesh is None else len(body.mesh.faces)


def _on_map(bodies: Sequence[Body]) -> Mesh:
    """The meshes of bodies at rest as one, on the map."""
    vertices: list[Floats] = []
    faces: list[Indices] = []
    count = 0
    for body in bodies:
        if body.mesh is not None:
            stand = pose_at(body, 0.0)
            faces.append(body.mesh.faces + count)
            vertices.append(map_from_body(body.mesh.vertices, stand.position, stand.heading))
            count += len(body.mesh.vertices)
    return Mesh(np.concatenate(vertices), np.concatenate(faces))
