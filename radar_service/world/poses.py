"""Poses of many bodies at many instants. Bodies at rest are computed once, straight courses all together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np

from radar_service.numerics import Floats, Indices, body_rotation, map_from_deck, turned, wrap_bearing
from radar_service.world.body import Body, Mesh
from radar_service.world.motion import Motion
from radar_service.world.seaway_motion import SeawayMotion, sways_on_course

SWAYS = 64  # of ships at instants at a time: arrays of their waves stay in the cache


@dataclass(frozen=True)
class BodyPose:
    """Pose of one body at one instant.

    position: (3,) on the map [m].
    heading: [rad].
    rotation: (3, 3) map_from_body of a body that rolls or pitches; None: the heading alone turns it.
    """

    position: Floats
    heading: float
    rotation: Floats | None = None

    @property
    def matrix(self) -> Floats:
        """The rotation (3, 3) map_from_body."""
        return body_rotation(self.heading) if self.rotation is None else self.rotation

    @property
    def upright(self) -> "BodyPose":
        """The pose of the same body without roll and pitch."""
        return BodyPose(self.position, self.heading)

    @property
    def lean(self) -> Floats | None:
        """The rotation (3, 3) from the body's own frame to that of the upright body; None for an upright one."""
        return None if self.rotation is None else body_rotation(self.heading).T @ self.rotation

    def lifted(self, height: float) -> "BodyPose":
        """The pose of the same body `height` [m] higher."""
        return self if height == 0.0 else replace(self, position=self.position + [0.0, 0.0, height])

    def map_from_frame(self, points: Floats) -> Floats:
        """Points (..., 3) of the body's own frame on the map [m]."""
        return points @ self.matrix.T + self.position

    def frame_from_map(self, points: Floats, earth_radius: float) -> Floats:
        """Map points (..., 3) in the body's own frame, curved about its origin as `trace.occluder` explains [m].

        A leaning body curves along its own axes: that errs by less than its size squared over ae, 1 mm for 100 m.
        """
        local = points - self.position
        if self.rotation is None and self.heading != 0.0:
            local = local @ body_rotation(self.heading)
        if np.isfinite(earth_radius):
            local[..., 2] -= (local[..., 0] ** 2 + local[..., 1] ** 2) / (2.0 * earth_radius)
        return local if self.rotation is None else np.asarray(local @ self.rotation)


MAP_POSE = BodyPose(np.zeros(3), 0.0)  # of a mesh whose vertices are map coordinates


class PoseArrays(NamedTuple):
    """Poses of B bodies at K instants: position (K, B, 3) [m], heading (K, B) [rad].

    rotation: of each body that rolls or pitches, by its index: matrices (K, 3, 3) map_from_body.
    """

    position: Floats
    heading: Floats
    rotation: Mapping[int, Floats]

    def of_body(self, k: int, b: int) -> BodyPose:
        """The pose of body b at instant k."""
        rotation = self.rotation[b][k] if b in self.rotation else None
        return BodyPose(self.position[k, b], float(self.heading[k, b]), rotation)

    @property
    def rotation_numbers(self) -> Indices:
        """The place of each body (B,) among those that roll or pitch, in the order of `rotation`; -1 for an upright one."""
        number = np.full(self.position.shape[1], -1)
        number[list(self.rotation)] = np.arange(len(self.rotation))
        return number

    def map_from_bodies(self, k: int, points: Floats, body: Indices) -> Floats:
        """Points (E, 3) of bodies' own frames, point e of body body[e], on the map [m] at instant k."""
        placed = map_from_bodies(points, body, self.position[k], self.heading[k])
        if self.rotation:
            own, rotation = self._leaning(k, body)
            placed[own] = np.einsum("ei,eji->ej", points[own], rotation) + self.position[k].take(body[own], axis=0)
        return placed

    def frames_from_map(self, k: int, points: Floats, body: Indices, earth_radius: float) -> Floats:
        """Map points (E, 3), point e in the frame of body[e] at instant k, curved about its origin [m]."""
        local = points - self.position[k].take(body, axis=0)
        east, north, up = local.T
        if np.isfinite(earth_radius):
            up -= (east * east + north * north) / (2.0 * earth_radius)
        cosine, sine = _turns(self.heading[k], body)
        framed = turned(local, cosine, -sine)
        if self.rotation:
            own, rotation = self._leaning(k, body)
            framed[own] = np.einsum("ei,eij->ej", local[own], rotation)
        return framed

    def rotated_from_bodies(self, k: int, vectors: Floats, body: Indices) -> Floats:
        """Vectors (E, 3) of bodies' own frames, vector e of body[e], along the map's axes at instant k."""
        rotated = turned(vectors, *_turns(self.heading[k], body))
        if self.rotation:
            own, rotation = self._leaning(k, body)
            rotated[own] = np.einsum("ei,eji->ej", vectors[own], rotation)
        return rotated

    def _leaning(self, k: int, body: Indices) -> tuple[Indices, Floats]:
        """Which of bodies (E,) roll or pitch, (L,), and their rotations (L, 3, 3) map_from_body at instant k."""
        number = self.rotation_numbers
        own = np.flatnonzero(number[body] >= 0)
        return own, np.stack([rotation[k] for rotation in self.rotation.values()])[number[body[own]]]


class HasMotion(Protocol):
    """Anything that moves."""

    @property
    def motion(self) -> Motion: ...


class BodyPoses:
    """The motions of bodies (B,), evaluated together. moving: indices of the bodies that do not rest."""

    def __init__(self, bodies: Sequence[HasMotion]) -> None:
        self._motions = [body.motion for body in bodies]
        self.moving: Indices = np.array([b for b, m in enumerate(self._motions) if not m.at_rest], dtype=np.int64)
        self._moves = np.isin(np.arange(len(bodies)), self.moving)
        self._straight = np.array([m.is_straight for m in self._motions], dtype=np.bool_)
        self._with_segments = set(self.moving[~self._straight[self.moving]].tolist())
        self._position = np.array([m.position[0] for m in self._motions]).reshape(-1, 3)
        self._heading = wrap_bearing(np.array([m.heading[0] for m in self._motions])).reshape(-1)
        self._velocity = np.array([m.final_velocity for m in self._motions]).reshape(-1, 3)
        self._start = np.array([m.time[0] for m in self._motions])
        laws = {b: m.sway for b, m in enumerate(self._motions) if m.keeps_course and isinstance(m.sway, SeawayMotion)}
        rows = {b: law.on_course(self._motions[b].heading, self._velocity[b]) for b, law in laws.items()}
        self._on_course = {b: (laws[b], row) for b, row in rows.items() if row is not None}

    def at(self, time: Floats, requested: Indices | None = None) -> PoseArrays:
        """Poses of all bodies at each time (K,) [s]. Rows of bodies not in `requested` (N,) are undefined; None: all."""
        heading = np.repeat(self._heading[None], len(time), axis=0)
        rotation: dict[int, Floats] = {}
        if requested is not None and 2 * len(requested) < len(self._motions):  # few of them
            position = np.empty((len(time), len(self._motions), 3))
            position[:, requested] = self._on_straights(time, requested)
        elif 2 * len(self.moving) > len(self._motions):  # most of them move: all together
            position = self._on_straights(time, slice(None))
        else:
            position = np.repeat(self._position[None], len(time), axis=0)
            position[:, self.moving] = self._on_straights(time, self.moving)
        others = self._with_segments if requested is None else self._with_segments.intersection(requested.tolist())
        swayed = [b for b in others if b in self._on_course]
        step = max(1, SWAYS // max(1, len(time)))
        for part in np.split(np.array(swayed), range(step, len(swayed), step)) if swayed else []:
            rotation |= self._swayed(time, part, position, heading)
        for b in others.difference(swayed):
            pose = self._motions[b].pose(time)
            position[:, b], heading[:, b] = pose.position, pose.heading
            if pose.rotation is not None:
                rotation[b] = pose.rotation
        return PoseArrays(position, heading, rotation)

    def _swayed(self, time: Floats, which: Indices, position: Floats, heading: Floats) -> dict[int, Floats]:
        """Adds heave to positions (K, B, 3) of ships `which` (N,) `_on_course` at times (K,) [s], and returns their rotations."""
        laws, amplitude = zip(*(self._on_course[b] for b in which.tolist()), strict=True)
        roll, pitch, heave = sways_on_course(laws, amplitude, position[:, which].swapaxes(0, 1), time)
        position[:, which, 2] += heave.T
        return dict(zip(which.tolist(), map_from_deck(heading[:, which].T, roll, pitch), strict=True))

    def _on_straights(self, time: Floats, which: Indices | slice) -> Floats:
        """Positions (K, N, 3) [m] at times (K,) [s] of bodies `which` (N,) that rest, or go straight from their only knot on."""
        since = np.maximum(time[:, None] - self._start[which], 0.0)
        position: Floats = since[:, :, None] * self._velocity[which]
        position += self._position[which]
        return position

    def uneven(self, time: Floats, requested: Indices) -> Indices:
        """The bodies `requested` (N,) that may not go straight, or rest, throughout times (K,) [s]."""
        moving = requested[self._moves[requested]]
        certain = self._straight[moving] & (self._start[moving] <= time.min())
        return np.array([b for b in moving[~certain].tolist() if not self._motions[b].is_even(time)], dtype=np.int64)

    def each_at(self, time: float) -> list[BodyPose]:
        """The pose of each body at `time` [s]."""
        poses = self.at(np.array([time]))
        return [poses.of_body(0, b) for b in range(len(self._motions))]


def pose_at(body: Body, time: float) -> BodyPose:
    """The pose of one body at `time` [s]."""
    pose = body.motion.pose(time)
    return BodyPose(pose.position[0], float(pose.heading[0]), None if pose.rotation is None else pose.rotation[0])


def map_from_bodies(points: Floats, body: Indices, position: Floats, heading: Floats) -> Floats:
    """Points (E, 3) of upright bodies' own frames, point e of body body[e], on the map [m].

    position: (B, 3) [m] and heading: (B,) [rad] of the bodies.
    """
    rotated = turned(points, *_turns(heading, body))
    rotated += position if len(position) == 1 else position.take(body, axis=0)
    return rotated


def _turns(heading: Floats, body: Indices) -> tuple[Floats, Floats]:
    """Cosine and sine of the headings of bodies (E,), by those of all (B,) [rad]: of whichever are fewer; (1,) of one body."""
    if len(heading) == 1:
        return np.cos(heading), np.sin(heading)
    if len(body) < len(heading):
        turn = heading[body]
        return np.cos(turn), np.sin(turn)
    return np.cos(heading)[body], np.sin(heading)[body]


def rotated_from_bodies(vectors: Floats, body: Indices, poses: Sequence[BodyPose]) -> Floats:
    """Vectors (E, 3) of bodies' own frames, each of `body` (E,) in rising order, along the map's axes."""
    result = vectors.copy()
    for b, pose in enumerate(poses):
        if pose.heading or pose.rotation is not None:
            part = slice(*np.searchsorted(body, [b, b + 1]))
            result[part] = vectors[part] @ pose.matrix.T
    return result


def map_from_ordered_bodies(points: Floats, body: Indices, poses: Sequence[BodyPose]) -> Floats:
    """Points (E, 3) of bodies' own frames, each of `body` (E,) in rising order, on the map [m]."""
    result = rotated_from_bodies(points, body, poses)
    if poses:
        result += np.array([pose.position for pose in poses])[body]
    return result


def merged_mesh(bodies: Sequence[Body]) -> Mesh | None:
    """The meshes of bodies at rest as one mesh in map coordinates, in their order; None where no body has a mesh."""
    posed = [(pose_at(body, 0.0).map_from_frame(body.mesh.vertices), body.mesh) for body in bodies if body.mesh is not None]
    if len(posed) < 2:  # a large one is not copied
        return Mesh(posed[0][0], posed[0][1].faces) if posed else None
    vertices, meshes = zip(*posed, strict=True)
    first = np.cumsum([0, *(len(points) for points in vertices[:-1])])
    return Mesh(np.concatenate(vertices), np.concatenate([mesh.faces + k for mesh, k in zip(meshes, first, strict=True)]))
