"""Occlusion by many rigid bodies at an instant: their lines of sight in arrays, those of bodies of one mesh in one ray test."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.trace.occluder import Occluder, begun_nearby, hit_before, passes_by, reach_of
from radar_service.world.poses import PoseArrays


@dataclass(frozen=True)
class OccluderKinds:
    """The occluders of bodies (N,): `occluders`, each of one mesh, and which of them a body has, kind (N,).

    centre: (N, 3) and radius: (N,) of their bounding spheres, in their own frames [m]; top: (N,) highest points there [m].
    """

    occluders: Sequence[Occluder]
    kind: Indices
    centre: Floats
    radius: Floats
    top: Floats

    @classmethod
    def of(cls, occluders: Sequence[Occluder]) -> "OccluderKinds":
        """Of bodies with such occluders, some of them the same."""
        distinct = list({id(occluder): occluder for occluder in occluders}.values())
        number = {id(occluder): n for n, occluder in enumerate(distinct)}
        kind = np.array([number[id(occluder)] for occluder in occluders], dtype=np.int64)
        centre = np.array([occluder.sphere[0] for occluder in distinct]).reshape(-1, 3)[kind]
        radius, top = np.array([(occluder.sphere[1], occluder.top) for occluder in distinct]).reshape(-1, 2)[kind].T
        return cls(distinct, kind, centre, radius, top)

    def tops(self, poses: PoseArrays) -> Floats:
        """Highest points (N,) of bodies on the map at the first instant of `poses` [m]."""
        tops = poses.position[0, :, 2] + self.top
        leaning = list(poses.rotation)
        centre = poses.map_from_bodies(0, self.centre[leaning], np.array(leaning, dtype=np.int64))
        tops[leaning] = centre[:, 2] + self.radius[leaning]
        return tops

    def groups(self, body: Indices) -> Iterator[tuple[Occluder, Indices]]:
        """The occluders of bodies (P,), each with the indices of those that have it."""
        kind = self.kind[body]
        order = np.argsort(kind, kind="stable")
        begins = np.flatnonzero(np.diff(kind[order], prepend=-1))
        for which in np.split(order, begins[1:]) if len(begins) else []:
            yield self.occluders[kind[which[0]]], which


@dataclass(frozen=True)
class PosedOccluders:
    """Bodies (N,) that occlude, and their poses at one instant."""

    kinds: OccluderKinds
    poses: PoseArrays
    earth_radius: float

    def occluded(self, body: Indices, origin: Floats, points: Floats) -> Flags:
        """Which of `points` (P, 3) of others, each behind one of these bodies (P,), that one occludes from `origin` (3,), or from
        one each (P, 3), all on the map [m]."""
        begin, line = self._lines_of_sight(body, origin, points)
        centre, radius = self.kinds.centre.take(body, axis=0), self.kinds.radius[body]
        near = np.flatnonzero(passes_by(line, centre - begin, radius))
        begin, line, centre = (part.take(near, axis=0) for part in (begin, line, centre))
        begin, skipped = begun_nearby(begin, line, centre - begin, radius[near])
        reach = reach_of(line, skipped)
        occluded = np.zeros(len(body), dtype=np.bool_)
        for occluder, which in self.kinds.groups(body[near]):
            rays = begin.take(which, axis=0), line.take(which, axis=0)
            occluded[near[which]] = occluder.scene.occluded(*rays, reach[which])
        return occluded

    def self_occluded(self, body: Indices, origin: Floats, points: Floats, own: tuple[Indices, Indices]) -> Flags:
        """Which points (P, 3), each of one of these bodies (P,), other parts of that occlude from `origin` (3,), or from one each
        (P, 3), on the map [m]; own: as of `Occluder.self_occluded`."""
        origin, line = self._lines_of_sight(body, origin, points)
        begin, _ = begun_nearby(origin, line, self.kinds.centre.take(body, axis=0) - origin, self.kinds.radius[body])
        occluded = np.zeros(len(body), dtype=np.bool_)
        for occluder, which in self.kinds.groups(body):
            first, ray, way = (part.take(which, axis=0) for part in (origin, begin, line))
            occluded[which] = hit_before(occluder.scene, first, ray, way, (own[0][which], own[1][which]))
        return occluded

    def _lines_of_sight(self, body: Indices, origin: Floats, points: Floats) -> tuple[Floats, Floats]:
        """Where lines of sight begin and how far they go (P, 3), in the frames of bodies (P,)."""
        if origin.ndim == 1:
            every = np.arange(len(self.kinds.kind))
            begin = self._in_frames(every, np.broadcast_to(origin, (len(every), 3))).take(body, axis=0)
        else:
            begin = self._in_frames(body, origin)
        return begin, self._in_frames(body, points) - begin

    def _in_frames(self, body: Indices, points: Floats) -> Floats:
        """Map points (P, 3), each in the curved frame of a body (P,) (`BodyPose.frame_from_map`)."""
        return self.poses.frames_from_map(0, points, body, self.earth_radius)
