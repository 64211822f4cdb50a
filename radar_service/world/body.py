"""Records of bodies: the material, the radar reflector, the triangle mesh and the body itself."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from radar_service.numerics import Floats, Indices, map_from_body, turned
from radar_service.world.motion import Motion
from radar_service.world.presence import Presence


@dataclass(frozen=True)
class Material:
    """The scattering of a surface at X band."""

    name: str
    gamma: float  # sigma0 = gamma cos(incidence), power ratio
    scattering: str  # name of a model in radar_service.scattering.models: default for bodies of this material


@dataclass(frozen=True)
class Reflector:
    """A radar reflector at the origin of its body's frame.

    kind: "corner", one trihedral of triangular plates that opens ahead, its axis level; "octahedral", eight of them in three
        crossed square plates; "lens", a Luneburg lens whose reflecting cap covers its after half.
    size: leg of the trihedrals, or radius of the lens [m].
    hung: of an octahedral one: "catch-rain", one trihedral opens up; "point-up", a corner of the plates is on top.
    """

    kind: str
    size: float
    hung: str = "catch-rain"


@dataclass(frozen=True)
class Plating:
    """Dents that welding and the sea leave in plates between frames (IACS Rec. 47: 4 mm standard, 8 mm limit).

    depth: mean over panels of their largest depth [m].
    frame: distance of frames [m].
    tier: height over which the depth of a panel is drawn [m].
    seed: of the draws.
    """

    depth: float
    frame: float
    tier: float
    seed: int


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in a body's own frame: vertices (V, 3) float64 [m], faces (F, 3) int64, every index in range.

    solid: whether it is known to be of closed surfaces that are wound outward: what faces away from outside is hidden there.
    It equals itself alone.
    """

    vertices: Floats
    faces: Indices
    solid: bool = field(default=False, metadata={"derived": True})  # see truth.truth_file.scene_hash

    def __post_init__(self) -> None:
        assert self.vertices.ndim == 2 and self.vertices.shape[1] == 3 and self.faces.shape[1:] == (3,)

    @property
    def used_vertices(self) -> Floats:
        """The vertices (U, 3) that triangles have, in their order [m]."""
        return used_rows(self.vertices, self.faces)

    @cached_property
    def top(self) -> float:
        """Height of the highest vertex that a triangle has [m]."""
        return float(self.used_vertices[:, 2].max())

    def part(self, which: Indices) -> "Mesh":
        """Returns the triangles `which` of the mesh, with no other vertices than theirs."""
        faces = self.faces[which]
        used = np.zeros(len(self.vertices), dtype=np.bool_)
        used[faces] = True
        return Mesh(self.vertices[used], (np.cumsum(used) - 1)[faces])

    def placed(self, heading: float, offset: Floats) -> "Mesh":
        """Returns the mesh with its bow along y, if that pointed along `heading` [rad], and its origin at `offset` (3,) [m].

        Quarter turns are exact.
        """
        if not (heading or offset.any()):
            return self
        cos, sin = math.cos(heading), math.sin(heading)
        if abs(cos * sin) < 1e-15:  # a quarter turn, but for rounding
            cos, sin = round(cos), round(sin)
        east, north, up = self.vertices.T
        vertices = np.stack([cos * east - sin * north, sin * east + cos * north, up], axis=1) + offset
        return Mesh(vertices, self.faces, self.solid)


def used_rows(rows: Floats, index: Indices) -> Floats:
    """The rows (V, ...) that occur in an index of any shape, in their order: flags take less time than to sort the index."""
    used = np.zeros(len(rows), dtype=np.bool_)
    used[index] = True
    return np.asarray(rows[used])


@dataclass(frozen=True)
class Body:
    """An object that the radar can detect.

    name: unique in the scene.
    mesh: its surface; None for a point.
    motion: its position and heading at any time.
    material: of its surface.
    scattering: name of its model in `scattering.models`.
    rcs: declared radar cross-section [m^2], or None.
    swerling: case of fluctuation, 0 for a steady target.
    mmsi: identity for AIS, or None.
    length, beam: horizontal extents in its own frame [m], 0 for a point.
    is_vessel: whether its reference point is the middle of its waterline: hulls, and meshes of what vessels are built of.
    presence: when it is in the scene at all.
    reflector: the radar reflector that it is; None of all else.
    effects: what it keeps of the keys of effects, by their names (`stages`).
    one_sided: whether only the sides of its triangles reflect that their winding faces: land, whose lower side is no surface.
    plating: how its walls are dented, where it scatters by physical optics; None: they are flat.
    """

    name: str
    mesh: Mesh | None
    motion: Motion
    material: Material
    scattering: str
    rcs: float | None
    swerling: int
    mmsi: int | None
    length: float
    beam: float
    is_vessel: bool = False
    presence: Presence = field(default=Presence.always, metadata={"added": 1})  # see truth.truth_file.scene_hash
    one_sided: bool = field(default=False, metadata={"added": 2})
    reflector: Reflector | None = field(default=None, metadata={"added": 3})
    effects: Mapping[str, Any] = field(default_factory=dict)
    plating: Plating | None = field(default=None, metadata={"added": 4})

    @property
    def at_rest(self) -> bool:
        """Whether it neither moves nor comes nor goes."""
        return self.motion.at_rest and self.presence.constant and bool(self.presence.present[0])

    @property
    def middle(self) -> Floats:
        """Middle (3,) of the plan view in the body frame [m], at height 0. The mesh may be far from the frame's origin."""
        return self._plan[0]

    @property
    def radius(self) -> float:
        """Radius [m] of the circle about `middle` that encloses the plan view, however it rolls; 0 for a point."""
        return self._plan[1]

    @property
    def arm(self) -> float:
        """Maximum horizontal distance [m] of the mesh from the origin of the body frame, about which the body turns."""
        return self._plan[2]

    @property
    def top_speed(self) -> float:
        """The highest speed [m/s] of any part by motion and sway; turns of the heading not counted."""
        sway = self.motion.sway
        if sway is None:
            return self.motion.top_speed
        roll, pitch, yaw, heave = sway.max_rates.tolist()
        return float(self.motion.top_speed + heave + self.arm * (roll + pitch + yaw))

    def moved_within(self, time: float, span: float) -> float:
        """How far [m] any part may get within a span [s] about `time` [s], while the body turns as fast as then."""
        return span * (self.top_speed + self.arm * abs(float(self.motion.turn_rate(time)[0])))

    @cached_property
    def diagonal(self) -> float:
        """Diagonal [m] of the box that encloses the mesh; 0 for a point."""
        return 0.0 if self.mesh is None else float(np.linalg.norm(np.ptp(self.mesh.vertices, axis=0)))

    @cached_property
    def reference(self) -> Floats:
        """Reference point (3,) in the body frame [m]: where a truth has the body. The origin, but for vessels."""
        if not self.is_vessel or self.mesh is None:
            return np.zeros(3)
        sea = -float(self.motion.position[0, 2])  # in the body frame
        line = _section(self.mesh, sea)
        middle = self.middle[:2] if not len(line) else (line.min(axis=0) + line.max(axis=0)) / 2.0
        return np.array([*middle, sea])

    def middle_at(self, time: float) -> Floats:
        """Returns the map position (3,) [m] of `middle` at `time` [s]."""
        pose = self.motion.pose(time)
        if pose.rotation is not None:
            return np.asarray(pose.position[0] + pose.rotation[0] @ self.middle)
        return map_from_body(self.middle, pose.position[0], float(pose.heading[0]))

    def middles_at(self, time: Floats) -> Floats:
        """Returns the map positions (K, 3) [m] of `middle` at times (K,) [s]."""
        pose = self.motion.pose(time)
        if pose.rotation is not None:
            return np.asarray(pose.position + pose.rotation @ self.middle)
        return np.asarray(pose.position + turned(self.middle, np.cos(pose.heading), np.sin(pose.heading)))

    @cached_property
    def _plan(self) -> tuple[Floats, float, float]:
        """Middle, radius and arm of the plan view."""
        if self.mesh is None:
            return np.zeros(3), 0.0, 0.0
        vertices = self.mesh.used_vertices
        east, north, _ = vertices.T
        middle = np.array([east.min() + east.max(), north.min() + north.max(), 0.0]) / 2.0
        if self.motion.sway is not None and self.motion.sway.tilts:  # whatever it leans to
            radius, arm = (float(np.linalg.norm(vertices - about, axis=1).max()) for about in (middle, np.zeros(3)))
            return middle, radius, arm
        radius = np.hypot(east - middle[0], north - middle[1]).max()
        return middle, float(radius), float(np.hypot(east, north).max())


def _section(mesh: Mesh, height: float) -> Floats:
    """Where edges (P, 2) of a mesh pass a height [m]."""
    begin = mesh.vertices[mesh.faces]
    end = np.roll(begin, -1, axis=1)
    rise = end[..., 2] - begin[..., 2]
    passes = (begin[..., 2] < height) != (end[..., 2] < height)
    share = (height - begin[passes][:, 2]) / rise[passes]
    return np.asarray(begin[passes][:, :2] + share[:, None] * (end[passes] - begin[passes])[:, :2])
