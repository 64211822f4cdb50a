"""Which scatterers the antenna sees: past the horizon, the range, the body itself, all that rests, all that moves."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import Polar, distances_from_map, map_from_body
from radar_service.scene.poses import BodyPoses
from radar_service.scene.world import Body, Mesh
from radar_service.trace.occluder import BodyPose, Occluder, beyond_horizon

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
STILL = BodyPose(np.zeros(3), 0.0)


class Surface(NamedTuple):
    """On what each of E points lies: the body's index in the scene, the triangle in its mesh (-1: the whole body)."""

    body: Indices
    triangle: Indices


class OcclusionScene:
    """What can hide things: one occluder for all bodies at rest on the map, and one for each mesh that moves."""

    def __init__(self, bodies: Sequence[Body], earth_radius: float, idle: Collection[int] = ()) -> None:
        """idle: indices of moving bodies that never stand before anything, and are not asked."""
        self.earth_radius = earth_radius
        resting = np.array([body.motion.at_rest for body in bodies], dtype=np.bool_)
        self._faces = np.array([0 if body.mesh is None else len(body.mesh.faces) for body in bodies], dtype=np.int64)
        still_faces = np.where(resting, self._faces, 0)
        self._still_first = np.cumsum(still_faces) - still_faces  # first triangle of each body in the joined mesh
        self._resting = resting
        joined = _joined_mesh([body for body in bodies if body.motion.at_rest])
        self._still = Occluder(joined, earth_radius) if joined is not None else None
        self._movers = {
            i: Occluder(body.mesh, earth_radius)
            for i, body in enumerate(bodies)
            if body.mesh is not None and not body.motion.at_rest and i not in idle
        }
        self._fleet = BodyPoses([bodies[i] for i in self._movers])

    @property
    def rays(self) -> int:
        """Rays cast so far."""
        occluders = [*self._movers.values()] + ([self._still] if self._still else [])
        return sum(occluder.rays for occluder in occluders)

    def visible(
        self, surface: Surface, place: Floats, antenna: Floats, time: float, reach: float, movers: bool = True
    ) -> Flags:
        """Which points (E,) of surfaces, at places (E, 3) on the map, the antenna (3,) sees at `time` [s].

        reach: range [m] beyond which nothing counts as seen; movers: whether what moves may stand in between.
        """
        distance, slant = distances_from_map(place, antenna, self.earth_radius)
        over = beyond_horizon(distance, place[:, 2], float(antenna[2]), self.earth_radius)
        seen = np.flatnonzero(~over & (slant < reach))
        for occluder, stand, key in self._in_between(surface, time, movers):
            mine = (self._resting[surface.body] if key is None else surface.body == key)[seen]
            if mine.any() or occluder.may_occlude(stand, antenna, place[seen]):
                seen = seen[~self._hidden(occluder, stand, surface, place, antenna, seen, mine)]
        visible = np.zeros(len(place), dtype=np.bool_)
        visible[seen] = True
        return visible

    def _in_between(self, surface: Surface, time: float, movers: bool) -> list[tuple[Occluder, BodyPose, int | None]]:
        """What may stand before a surface at `time` [s], where, and which body it is (None: all that rests): first all that
        rests, but before it the mover that all of the surface lies on, which hides most of itself."""
        found: list[tuple[Occluder, BodyPose, int | None]] = [] if self._still is None else [(self._still, STILL, None)]
        found += [(self._movers[key], stand, key) for key, stand in (self._stands(time) if movers else {}).items()]
        return sorted(found, key=lambda one: one[2] is None or not (surface.body == one[2]).all())

    def still_cone(self, antenna: Floats) -> tuple[float, float, float]:
        """What all that rests may hide from the antenna (3,), as `Occluder.cone`; a half width of 0 where nothing rests."""
        return (0.0, 0.0, np.inf) if self._still is None else self._still.cone(STILL, antenna)

    def hides(self, places: Floats, antenna: Floats, time: float, movers: bool = True) -> Flags:
        """Which places (W, 3) on the map anything at rest, or what moves if `movers`, hides from the antenna (3,) at
        `time` [s]."""
        hidden = np.zeros(len(places), dtype=np.bool_)
        if self._still is not None:
            hidden |= self._still.hides(STILL, antenna, places)
        for key, stand in self._stands(time).items() if movers else ():
            hidden |= self._movers[key].hides(stand, antenna, places)
        return hidden

    def shadowed(self, place: Floats, polar: Polar, antenna: Floats, time: float) -> Indices:
        """Which of these places at rest a mover hides at `time` [s]: their indices, each once.

        place: (E, 3) seen past all that rests, in rising order of azimuth; polar: the same as the antenna (3,) sees them.
        """
        shadowed = [np.zeros(0, dtype=np.int64)]
        for key, stand in self._stands(time).items() if len(place) else ():
            occluder = self._movers[key]
            middle, half, begin = occluder.cone(stand, antenna)
            behind = _within(polar.azimuth, middle, half)
            behind = behind[polar.distance[behind] >= begin]
            shadowed.append(behind[occluder.hides(stand, antenna, place[behind])])
        return np.unique(np.concatenate(shadowed))

    def _stands(self, time: float) -> dict[int, BodyPose]:
        return dict(zip(self._movers, self._fleet.poses_at(time), strict=True))

    def _hidden(
        self,
        occluder: Occluder,
        stand: BodyPose,
        surface: Surface,
        place: Floats,
        antenna: Floats,
        which: Indices,
        mine: Flags,
    ) -> Flags:
        """Of scatterers `which`, those hidden by this occluder, on which those flagged `mine` lie themselves."""
        if mine.all():
            return occluder.self_occluded(stand, antenna, place.take(which, axis=0), self._own_triangles(surface, which))
        if not mine.any():
            return occluder.hides(stand, antenna, place.take(which, axis=0))
        hidden = np.zeros(len(which), dtype=np.bool_)
        own = self._own_triangles(surface, which[mine])
        hidden[mine] = occluder.self_occluded(stand, antenna, place[which[mine]], own)
        hidden[~mine] = occluder.hides(stand, antenna, place[which[~mine]])
        return hidden

    def _own_triangles(self, surface: Surface, which: Indices) -> tuple[Indices, Indices]:
        """The triangles, first to last (exclusive), that cannot hide a scatterer: its own one, or all of a body that
        counts as a point."""
        key, triangle = surface.body[which], surface.triangle[which]
        first = np.where(self._resting, self._still_first, 0)[key]
        on_triangle = triangle >= 0
        last = np.where(on_triangle, first + triangle + 1, first + self._faces[key])
        return first + np.where(on_triangle, triangle, 0), last


def _within(azimuth: Floats, middle: float, half: float) -> Indices:
    """Indices of the rising azimuths (E,) [-pi, pi] that lie within `half` of `middle`, the short way round."""
    turns = 2.0 * np.pi * np.arange(-1, 2)
    first = np.searchsorted(azimuth, middle - half + turns)
    last = np.searchsorted(azimuth, middle + half + turns, side="right")
    return np.unique(np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)]))


def _joined_mesh(bodies: Sequence[Body]) -> Mesh | None:
    """The meshes of bodies at rest as one, on the map; None where there is none."""
    vertices: list[Floats] = []
    faces: list[Indices] = []
    count = 0
    for body in bodies:
        if body.mesh is None:
            continue
        pose = body.motion.pose(0.0)
        vertices.append(map_from_body(body.mesh.vertices, pose.position[0], float(pose.heading[0])))
        faces.append(body.mesh.faces + count)
        count += len(body.mesh.vertices)
    return Mesh(np.concatenate(vertices), np.concatenate(faces)) if vertices else None
