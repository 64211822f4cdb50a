"""Rays as a second estimator of diffuse surfaces, independent of fixed scatterers.

Rays leave the antenna evenly in all directions. Each hit on a surface stands for the area that its ray covers. There are no
points on surfaces, no densities and no visibility tests. Bodies with a declared cross-section, points and physical optics have
no such integral: they keep their own models and only occlude.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from typing_extensions import override

from radar_service.numerics import CAST, Complexes, Flags, Floats, Indices, body_rotation, direction, generator
from radar_service.radar import Radar
from radar_service.scattering.fixed_scatterers import DiffuseScattering
from radar_service.scattering.model import BodyEchoes, Conditions, Instant, ScatteringContext, ScatteringModel
from radar_service.trace import RayCount, RayTarget, full_circle_rays, missed_area_range, sea_range
from radar_service.world import MAP_POSE, Body, BodyPose, merged_mesh, pose_at

SAMPLER_NAMES = {"rays": "uniform random", "stratified": "stratified", "sobol": "Sobol'"}


@dataclass(frozen=True)
class RayHits:
    """Hits of rays on bodies (H,).

    body: (H,) index in the scene.
    position: (H, 3) in the body's own frame [m].
    range: (H,) slant range [m].
    solid_angle: (H,) of the ray [sr].
    phasor: (H,) of unit length: the random phase.
    """

    body: Indices
    position: Floats
    range: Floats
    solid_angle: Floats
    phasor: Complexes

    def __len__(self) -> int:
        return len(self.body)


class RayCaster:
    """All triangles of a scene. A ray's first hit counts; what lies behind it is occluded."""

    def __init__(
        self,
        bodies: Sequence[Body],
        radar: Radar,
        earth_radius: float,
        sampler: str,
        seed: int,
        rays: RayCount | None = None,
    ) -> None:
        """sampler: how rays are distributed, as in `trace.ray_sampling`; rays: counts the rays cast, where given."""
        self.bodies, self.radar, self.earth_radius = tuple(bodies), radar, earth_radius
        self.sampler, self.seed = sampler, seed
        self._count = rays or RayCount()
        self.gamma: Floats = np.array([body.material.gamma for body in bodies], dtype=np.float64)
        self._one_sided: Flags = np.array([body.one_sided for body in bodies], dtype=np.bool_)  # height maps, at rest
        meshes = {key: body.mesh for key, body in enumerate(bodies) if body.mesh is not None}
        resting = [key for key in meshes if bodies[key].at_rest]
        self._resting = np.array(resting, dtype=np.int64)
        self._last_face = np.cumsum([len(meshes[key].faces) for key in resting])
        merged = merged_mesh([bodies[key] for key in resting])
        self._resting_target = None if merged is None else RayTarget(merged, earth_radius)
        self._movers = {key: RayTarget(mesh, earth_radius) for key, mesh in meshes.items() if not bodies[key].at_rest}

    def hits(
        self, antenna: Floats, time: float, max_range: float, movers: bool = True, present: Flags | None = None
    ) -> RayHits:
        """Hits of a full circle of rays from the antenna (3,) at `time` [s] within `max_range` [m].

        movers: whether bodies that move are present; present: which of all bodies (B,) are, None: all. Each instant has rays
        and phases of its own, the same for the same seed.
        """
        radar = self.radar
        random = generator(self.seed, CAST, int(np.float64(time).view(np.int64)))
        rays = full_circle_rays(self.sampler, random, radar.rays, radar.beamwidth, radar.beamwidth_el, radar.tilt)
        self._count.rays += len(rays)
        directions = direction(rays.azimuth, rays.elevation)
        nearest = np.minimum(sea_range(rays.elevation, float(antenna[2]), self.earth_radius), max_range)
        body, position = np.full(len(rays), -1, dtype=np.int64), np.zeros((len(rays), 3))
        if self._resting_target is not None:
            which, triangle = _closer_hits(self._resting_target, MAP_POSE, antenna, directions, nearest)
            body[which] = self._resting[np.searchsorted(self._last_face, triangle, side="right")]
            behind = ~self._resting_target.front(MAP_POSE, antenna, directions[which], triangle)
            body[which[behind & self._one_sided[body[which]]]] = -1  # they occlude, and reflect nothing
            position[which] = self._resting_target.point(MAP_POSE, antenna, directions[which], nearest[which])
        for key, target in self._movers.items() if movers else ():
            if present is not None and not present[key]:
                continue
            pose = pose_at(self.bodies[key], time)
            which, _ = _closer_hits(target, pose, antenna, directions, nearest)
            body[which] = key
            position[which] = target.point(pose, antenna, directions[which], nearest[which])
        phasor = np.exp(2j * np.pi * random.random(len(rays)))
        met = np.flatnonzero(body >= 0)
        own_frame = self._in_own_frames(body[met], position[met])
        return RayHits(body[met], own_frame, nearest[met], rays.solid_angle[met], phasor[met])

    def _in_own_frames(self, body: Indices, position: Floats) -> Floats:
        """Positions (H, 3) in the frames of their bodies. Hits on bodies at rest were found in map coordinates."""
        for key in np.intersect1d(body, self._resting):
            own, pose = body == key, pose_at(self.bodies[key], 0.0)
            position[own] = (position[own] - pose.position) @ body_rotation(pose.heading)
        return position


class RaySampledSurfaces(ScatteringModel):
    """Diffuse bodies (B,) estimated by rays, which are always cast over the full circle and meet nothing beyond the horizon."""

    def __init__(self, key: Indices, caster: RayCaster) -> None:
        """key: (B,) index of each body in the scene."""
        self.key, self._caster = key, caster
        self.scatterers: Indices = np.zeros(len(key), dtype=np.int64)
        self._index = np.full(len(caster.bodies), -1, dtype=np.int64)  # of each body of the scene, in this model
        self._index[key] = np.arange(len(key))

    @classmethod
    @override
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        """Rays meet all bodies of the scene."""
        sampler = context.fidelity.sampler
        caster = RayCaster(context.scene_bodies, context.radar, context.earth_radius, sampler, context.seed, context.rays)
        return cls(key, caster)

    @override
    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        present = instant.line_of_sight.present(instant.time)
        hits = self._caster.hits(antenna, instant.time, instant.max_range, instant.movers, present)
        own = np.flatnonzero(self._index[hits.body] >= 0)
        # A ray covers the area R^2 dOmega / cos i, of sigma0 = gamma cos i: the cosines cancel, and a hit needs no normal
        section = self._caster.gamma[hits.body] * hits.range**2 * hits.solid_angle
        body, amplitude = self._index[hits.body[own]], (np.sqrt(section) * hits.phasor)[own]
        order = np.argsort(body, kind="stable")
        return BodyEchoes.of_points(hits.position[own][order], amplitude[order], body[order])

    max_rcs = staticmethod(DiffuseScattering.max_rcs)

    @staticmethod
    @override
    def description(body: Body, conditions: Conditions, computed: str) -> str:
        radar, sampler = conditions.radar, SAMPLER_NAMES[conditions.fidelity.sampler]
        missed = missed_area_range(radar.rays, radar.beamwidth, radar.beamwidth_el)
        return (
            f"diffuse, {computed}, by {sampler} rays, {radar.rays} to 3 x 3 beamwidths (one azimuth in "
            f"twenty misses a square metre beyond {missed:.0f} m); no ray leaves beyond 1.5 beamwidths above and below"
        )

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """Unknown: it depends on how many rays meet the body."""
        return None


def _closer_hits(
    target: RayTarget, pose: BodyPose, antenna: Floats, directions: Floats, nearest: Floats
) -> tuple[Indices, Indices]:
    """Rays that meet this target before `nearest` (M,) [m], and the triangle of each. Lowers `nearest` for them."""
    triangle, distance = target.first_hit(pose, antenna, directions)
    which = np.flatnonzero(distance < nearest)
    nearest[which] = distance[which]
    return which, triangle[which]
