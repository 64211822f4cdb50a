"""Records of bodies: materials, radar reflector, triangle mesh and the body itself; slices and windings of large meshes."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Floats, Indices, map_from_body, turned
from radar_service.world.error import SceneError
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


# Materials scatter at X band by sigma0 = gamma cos(incidence), gamma as a power ratio. This constant-gamma law and its
# values for land are from Barton, Land clutter models for radar design and analysis (1985): -20 dB for flat ground, -15 dB
# for farmland and desert, -12 dB for rolling hills, -10 dB for wooded hills, -5 dB for mountains and towns. The spread
# about these means is about 5 dB. No table covers small built parts (rails, frames, joints): their values assume that the
# power reflected by a smooth slab at normal incidence is scattered evenly.
_GAMMA_DB: dict[str, tuple[float, str]] = {
    "steel": (0.0, "optics"),  # a ship's side: fittings and joints scatter nearly all power (perfect diffuser)
    "aluminium": (0.0, "optics"),  # as steel at X band: both are good conductors
    "wood": (-10.0, "diffuse"),  # |Gamma|^2 about -10 dB for permittivity 3, spread over all angles
    "fibreglass": (-10.0, "diffuse"),  # permittivity about 4 in thin sheet: half the power passes through, as for wood
    "concrete": (-6.0, "diffuse"),  # |Gamma|^2 -6 dB at normal incidence for permittivity 6 (ITU-R P.2040: 5.24)
    "brick": (-8.0, "diffuse"),  # |Gamma|^2 -9 dB for permittivity 3.9 (ITU-R P.2040), rougher than concrete
    "glass": (-8.0, "diffuse"),  # |Gamma|^2 -7 dB for permittivity 6.3 (ITU-R P.2040); frames make it scatter
    "building": (-5.0, "diffuse"),  # Barton: towns
    "rock": (-5.0, "diffuse"),  # Barton: mountains
    "land": (-12.0, "diffuse"),  # Barton: rolling hills
    "urban": (-10.0, "diffuse"),  # low houses and gardens: below Barton's towns
    "sand": (-20.0, "diffuse"),  # Barton: flat ground
    "vegetation": (-12.0, "diffuse"),  # Barton: between farmland and wooded hills
    "ice": (-15.0, "diffuse"),  # permittivity 3.2, rough at the wavelength: as farmland
    "rubber": (-15.0, "diffuse"),  # inflatable boats: thin, lossy, smooth
}

MATERIALS: dict[str, Material] = {
    name: Material(name, 10.0 ** (gamma_db / 10.0), scattering) for name, (gamma_db, scattering) in _GAMMA_DB.items()
}

BUILT = frozenset({"concrete", "brick", "glass", "building"})  # what bridges, quays and houses are made of
VESSEL_MATERIALS = frozenset({"steel", "aluminium", "wood", "fibreglass", "rubber"})  # what vessels and buoys are built of

# Power reflectivity of a smooth surface at normal incidence [dB], for bodies by physical optics:
# |Gamma|^2 = |(sqrt(eps) - 1) / (sqrt(eps) + 1)|^2 of its permittivity at 10 GHz (ITU-R P.2040 for building materials).
# Phase, polarization, angle and the reflection from the far side of a thin sheet are not modelled.
_REFLECTIVITY_DB: dict[str, float] = {
    "steel": 0.0,  # -0.01 dB: a conductor
    "aluminium": 0.0,
    "wood": -15.6,  # permittivity 2.0
    "fibreglass": -9.5,  # 4
    "concrete": -8.1,  # 5.24
    "brick": -9.7,  # 3.9
    "glass": -7.3,  # 6.3
    "building": -8.1,  # mostly concrete
    "rock": -7.3,  # 6, dry
    "land": -9.5,  # 4, dry soil; wet soil reflects about 4 dB more
    "urban": -8.1,  # concrete
    "sand": -11.4,  # 3, dry
    "vegetation": -20.0,  # leaves and air; no part is smooth at the wavelength
    "ice": -10.9,  # 3.2
    "rubber": -11.4,  # 3
}

# Land as the ground that reflects rays: rms height [m] of its surface about a plane, after the land types of Barton, Radar
# Equations for Modern Radar (2013): 10 m for towns, 1 m for flat land. Those of rock, sand, ice and concrete are estimates.
# Vegetation is not here: it absorbs what would reach the ground.
GROUND_ROUGHNESS = {
    "building": 10.0, "urban": 10.0, "brick": 10.0, "glass": 10.0, "rock": 3.0, "land": 1.0, "sand": 0.3, "ice": 0.1,
    "concrete": 0.02,
}  # fmt: skip


def is_metal(material: Material) -> bool:
    """Whether a surface reflects more than half of the power."""
    return power_reflectivity(material.name) > 0.5


def power_reflectivity(material: str) -> float:
    """Returns the power reflectivity (0 to 1) of a smooth surface of a known material at normal incidence."""
    return float(10.0 ** (_REFLECTIVITY_DB[material] / 10.0))


def permittivity(material: str) -> float:
    """Returns the relative permittivity that gives a known material, which is no metal, its power reflectivity."""
    amplitude = math.sqrt(power_reflectivity(material))
    return ((1.0 + amplitude) / (1.0 - amplitude)) ** 2


def material_from_name(name: str, location: str) -> Material:
    """Returns the material of this name. Raises SceneError at `location` with the names of all materials."""
    if name not in MATERIALS:
        raise SceneError(
            f'{location}: "{name:.60}" is not a known material; one of {", ".join(MATERIALS)}; choose the nearest'
        )
    return MATERIALS[name]


def is_diffuse_land(body: Body) -> bool:
    """Whether a body is land by its published sigma0, which holds what the ground before it reflects."""
    return is_land(body) and body.scattering == "diffuse" and body.rcs is None


def is_land(body: Body) -> bool:
    """Whether a body is land: a mesh at rest of a material that no vessel is built of."""
    return body.mesh is not None and body.motion.at_rest and body.material.name not in VESSEL_MATERIALS


def is_ground(body: Body) -> bool:
    """Whether a body is land that is not built: a height map, or of a material that is not in BUILT."""
    return is_land(body) and (body.one_sided or body.material.name not in BUILT)


MAX_JUDGED, SLICES = 300_000, 16  # triangles that remarks judge, some 3 s of processor time; slices that have as many in all
FACTOR = np.uint64(0x9E3779B97F4A7C15)  # odd, its bits without a pattern: 2^64 over the golden ratio
Marks = NDArray[np.uint64]


def mesh_sample(mesh: Mesh) -> Mesh:
    """Returns a mesh of at most MAX_JUDGED triangles as it is; of a larger one as many, in slices across its longest axis."""
    if len(mesh.faces) <= MAX_JUDGED:
        return mesh
    axis, size = int(np.ptp(mesh.vertices, axis=0).argmax()), MAX_JUDGED // SLICES
    order = np.argsort(mesh.vertices[mesh.faces[:, 0], axis])
    first = np.linspace(0, len(order) - size, SLICES).astype(np.int64)
    return mesh.part(order[(first[:, None] + np.arange(size)).ravel()])


def outward_winding(mesh: Mesh) -> int:
    """Returns the side of its triangles that is outside if all of a mesh is closed: 1 the one their winding faces, -1 the other.

    0 where a part may be open. Each edge of a closed mesh runs both ways equally often, so marks of all edges, with the sign of
    their direction, add up to 0.
    """
    marks, total = row_marks(mesh.vertices), 0
    for i in range(3):
        begin, end = marks[mesh.faces[:, i]], marks[mesh.faces[:, i - 2]]
        edge, rises = _mixed(begin ^ end), begin < end
        total += int(edge[rises].sum()) - int(edge[~rises].sum())
    if total % 2**64:
        return 0
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return int(np.sign(np.einsum("ij,ij->", a, np.cross(b, c))))


def row_marks(rows: Floats) -> Marks:
    """Returns 64 bits (N,) for each of rows (N, K), the same for equal rows, whatever the sign of 0.

    Of 10 million different rows two have the same in 1 of 400,000 cases.
    """
    total = np.zeros(len(rows), dtype=np.uint64)
    for column in rows.T:
        total = _mixed(total ^ (column + 0.0).view(np.uint64))
    return total


def _mixed(values: Marks) -> Marks:
    """Whole numbers (N,) with all of their bits mixed, different ones differently."""
    spread = (values ^ (values >> np.uint64(29))) * FACTOR
    return np.asarray(spread ^ (spread >> np.uint64(32)))
