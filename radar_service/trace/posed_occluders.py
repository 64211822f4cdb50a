"""Occlusion by many rigid bodies at an instant: their lines of sight in arrays, those of bodies of one mesh in one ray test."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Flags, Floats, Indices
from radar_service.trace.occluder import Occluder, hit_before, reach_of, sphere_reach
from radar_service.world import PoseArrays

MAX_SHORT = 2**15  # numbers of 16 bits: they sort in a fifth of the time


class LinesOfSight(NamedTuple):
    """Lines of sight (K,) in the curved frames of bodies.

    which: (K,) the points that they go to. first: (K, 3) where they begin. begin: (K, 3) where they reach the body's sphere.
    line: (K, 3) from first to the point [m]. skipped: (K,) the share of it that is left out.
    """

    which: Indices
    first: Floats
    begin: Floats
    line: Floats
    skipped: Floats


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
        kind = self.kind[body] if len(self.occluders) > MAX_SHORT else self.kind.astype(np.int16)[body]
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
        lines = self.lines_of_sight(body, origin, points, passing=True)
        reach = reach_of(lines.line, lines.skipped)
        occluded = np.zeros(len(body), dtype=np.bool_)
        for occluder, which in self.kinds.groups(body[lines.which]):
            rays = lines.begin.take(which, axis=0), lines.line.take(which, axis=0)
            occluded[lines.which[which]] = occluder.scene.occluded(*rays, reach[which])
        return occluded

    def self_occluded(self, body: Indices, origin: Floats, points: Floats, own: tuple[Indices, Indices]) -> Flags:
        """Which points (P, 3), each of one of these bodies (P,), other parts of that occlude from `origin` (3,), or from one each
        (P, 3), on the map [m]; own: first and last (exclusive) triangle (P,) that never occlude each."""
        lines = self.lines_of_sight(body, origin, points, passing=False)
        occluded = np.zeros(len(body), dtype=np.bool_)
        for occluder, which in self.kinds.groups(body):
            first, ray, way = (part.take(which, axis=0) for part in (lines.first, lines.begin, lines.line))
            occluded[which] = hit_before(occluder.scene, first, ray, way, (own[0][which], own[1][which]))
        return occluded

    def lines_of_sight(self, body: Indices, origin: Floats, points: Floats, passing: bool) -> LinesOfSight:
        """Lines of sight from `origin` to points (P, 3), in frames of bodies (P,). passing: those alone that come near them."""
        count, poses = len(body), self.poses
        lean = np.array([rotation[0] for rotation in poses.rotation.values()]).reshape(-1, 3, 3)
        bodies = poses.position[0], np.cos(poses.heading[0]), np.sin(poses.heading[0]), poses.rotation_numbers, lean
        spheres = self.kinds.centre, sphere_reach(self.kinds.radius)
        which, skipped = np.empty(count, dtype=np.int64), np.empty(count)
        first, begin, line = np.empty((3, count, 3))
        sizes = count, 1 if origin.ndim == 1 else count, len(self.kinds.kind), len(lean), passing
        ends = (np.asarray(position, dtype=np.float64).reshape(-1, 3) for position in (origin, points))
        taken = map(np.ascontiguousarray, (body, *ends, *bodies, *spheres))
        results = which, first, begin, line, skipped
        kept = KERNELS.lines_of_sight(*sizes, self.earth_radius, *taken, *results)
        return LinesOfSight(which[:kept], first[:kept], begin[:kept], line[:kept], skipped[:kept])
