"""The ensemble: the scatterers of all bodies in one set of arrays, and what the antenna makes of them at an instant."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from radar_service.fidelity import MIN_SCATTERERS
from radar_service.frames import body_rotation, map_from_body
from radar_service.radar.parameters import Radar
from radar_service.random import SCATTER, generator
from radar_service.scattering.diffuse import (
    Scatterers,
    cell_density,
    no_scatterers,
    point_scatterer,
    scatter_over,
    triangle_frames,
)
from radar_service.scattering.physical_optics.beam_crossing import BeamCrossing
from radar_service.scattering.physical_optics.optical_body import OpticalBody, optical_body
from radar_service.scene.poses import BodyPoses, PoseArrays, placed_at, pose_at
from radar_service.scene.world import Body
from radar_service.trace.line_of_sight import OcclusionScene, Surface
from radar_service.trace.occluder import BodyPose

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class BodyEchoes:
    """What bodies send back for as long as the aspect hardly changes, (M,) points: position (M, 3) [m] in the body's own
    frame, amplitude [m] (root of the cross-section, with its phase at that point), and which body of the ensemble."""

    position: Floats
    amplitude: NDArray[np.complex128]
    body: Indices

    def __post_init__(self) -> None:
        assert self.position.shape == (len(self.body), 3) and self.amplitude.shape == self.body.shape

    def __len__(self) -> int:
        return len(self.body)


class Sector(NamedTuple):
    """Bearings within `half` of `middle` [rad] from an antenna (3,), and all that is nearer than `close` [m]."""

    antenna: Floats
    middle: float
    half: float
    close: float

    def holds(self, place: Floats, size: Floats | float = 0.0) -> NDArray[np.bool_]:
        """Which places (M, 3) on the map are in it, or have something in it within `size` (M,) [m] around them."""
        east, north = place[:, 0] - self.antenna[0], place[:, 1] - self.antenna[1]
        distance = np.sqrt(east * east + north * north)
        ahead = east * np.sin(self.middle) + north * np.cos(self.middle)
        near = distance <= self.close + size
        if self.half >= np.pi:
            return np.ones(len(place), dtype=np.bool_)
        if np.any(size):
            aside = np.arcsin(np.divide(size, distance, out=np.ones_like(distance), where=~near))
            return np.asarray(near | (ahead >= distance * np.cos(np.minimum(self.half + aside, np.pi))))
        return np.asarray(near | (ahead >= distance * np.cos(self.half)))


class ScattererSource(Protocol):
    """B bodies whose reflections can be asked for."""

    @property
    def bodies(self) -> tuple[Body, ...]: ...

    @property
    def key(self) -> Indices:
        """Index (B,) of each body in the scene."""
        ...

    @property
    def rays(self) -> int:
        """Rays cast so far, but for those of the landscape."""
        ...

    def __len__(self) -> int: ...

    def forget(self) -> None:
        """Have everything evaluated anew next time: so that it can be timed."""
        ...

    def reflections(
        self,
        occlusion: OcclusionScene,
        antenna: Floats,
        time: float,
        reach: float,
        movers: bool = True,
        sector: Sector | None = None,
    ) -> BodyEchoes:
        """What the antenna (3,) sees of bodies as they stand at `time` [s]; arguments as in `OcclusionScene.visible`. sector: what
        is asked for, by default all; more may be there."""
        ...


@dataclass(frozen=True)
class ScattererSet:
    """Scatterers (E,) of B bodies, ordered by body; those by physical optics have none but an optical body."""

    bodies: tuple[Body, ...]
    key: Indices  # (B,) index of each body in the scene
    position: Floats  # (E, 3) m, each in its own body's frame
    normal: Floats  # (E, 3)
    area: Floats  # (E,) m^2
    triangle: Indices  # (E,) within the body's mesh, -1 for a point
    phasor: NDArray[np.complex128]  # (E,)
    body: Indices  # (E,) which body
    gamma: Floats  # (B,)
    rcs: Floats  # (B,) m^2, nan where not declared
    optical: tuple[OpticalBody | None, ...]  # (B,)
    passing: BeamCrossing | None = None  # what says for when optics is evaluated; None: for the time asked
    held: dict[int, tuple[float, BodyEchoes]] = field(default_factory=dict)  # the last of each optical body, and for when

    def __len__(self) -> int:
        return len(self.bodies)

    @property
    def rays(self) -> int:
        """Rays cast so far, from bounce to bounce."""
        return sum(body.scene.rays for body in self.optical if body is not None)

    def forget(self) -> None:
        """Have physical optics evaluated anew next time: so that it can be timed."""
        self.held.clear()

    def reflections(
        self,
        occlusion: OcclusionScene,
        antenna: Floats,
        time: float,
        reach: float,
        movers: bool = True,
        sector: Sector | None = None,
    ) -> BodyEchoes:
        """What the antenna (3,) sees of bodies as they stand at `time` [s]; arguments as in `OcclusionScene.visible`. sector: what
        is asked for, by default all; more may be there."""
        stands = self._fleet.stands(np.array([time]))
        near = self._near(stands, sector)
        asked, place = self._asked(stands, near, sector)
        surface = Surface(self.key[self.body[asked]], self.triangle[asked])
        visible = np.flatnonzero(occlusion.visible(surface, place, antenna, time, reach, movers))
        asked, place = asked[visible], place[visible]
        amplitude = self._amplitude(asked, place, self._normals(stands, asked), antenna, occlusion.earth_radius)
        heard = np.flatnonzero(amplitude)
        asked = asked[heard]
        parts = [BodyEchoes(self.position[asked], amplitude[heard], self.body[asked])]
        for b, optical in enumerate(self.optical):
            if optical is not None and near[b]:
                parts.append(self._by_optics(b, optical, occlusion, antenna, time, reach, movers))
        return _by_body(parts)

    @cached_property
    def _fleet(self) -> BodyPoses:
        return BodyPoses(self.bodies)

    @cached_property
    def _at_start(self) -> tuple[Floats, Floats]:
        """Places (E, 3) [m] and normals (E, 3) on the map at time 0: for good of what rests."""
        stands = self._fleet.poses_at(0.0)
        return placed(self.position, self.body, stands), turned(self.normal, self.body, stands)

    @cached_property
    def _plans(self) -> tuple[Floats, Floats]:
        """Middles (B, 3) of the bodies' plans in their own frames, and radii (B,) about them [m]."""
        middles, radii = [body.middle for body in self.bodies], [body.radius for body in self.bodies]
        return np.array(middles).reshape(-1, 3), np.array(radii)

    def _near(self, stands: PoseArrays, sector: Sector | None) -> Flags:
        """Which bodies (B,) may have anything in a sector."""
        if sector is None or not self.bodies:
            return np.ones(len(self.bodies), dtype=np.bool_)
        middle, radius = self._plans
        every = np.arange(len(self.bodies))
        return sector.holds(placed_at(middle, every, stands.position[0], stands.heading[0]), radius)

    def _asked(self, stands: PoseArrays, near: Flags, sector: Sector | None) -> tuple[Indices, Floats]:
        """Which scatterers (A,) of bodies `near` (B,) a sector asks for, and their places (A, 3) on the map [m]: of bodies
        with a declared cross-section all or none, as they share it."""
        asked = np.flatnonzero(near[self.body])
        moved = list(self._movers_in(asked))
        untouched = not moved and len(asked) == len(self.body)  # by far the most of a coast's scatterers: not copied
        place = self._at_start[0] if untouched else self._at_start[0][asked]
        for b, part in moved:
            place[part] = map_from_body(self.position[asked[part]], stands.position[0, b], stands.heading[0, b])
        if sector is None:
            return asked, place
        held, body = sector.holds(place), self.body[asked]
        shared = np.zeros(len(self.bodies), dtype=np.bool_)
        shared[body[held]] = True
        kept = np.flatnonzero(held | (shared & ~np.isnan(self.rcs))[body])
        return asked[kept], place[kept]

    def _normals(self, stands: PoseArrays, asked: Indices) -> Floats:
        """Normals (A, 3) on the map of the scatterers `asked` for."""
        normal = self._at_start[1][asked]
        for b, part in self._movers_in(asked):
            normal[part] = self.normal[asked[part]] @ body_rotation(stands.heading[0, b]).T
        return normal

    def _movers_in(self, asked: Indices) -> Iterator[tuple[int, slice]]:
        """The bodies that move, and where in `asked` (A,), which rise, their scatterers are."""
        for b in self._fleet.moving.tolist():
            first, last = np.searchsorted(asked, self._first[b : b + 2])
            if first < last:
                yield b, slice(first, last)

    @cached_property
    def _first(self) -> Indices:
        """The first scatterer (B + 1,) of each body, and the end."""
        return np.searchsorted(self.body, np.arange(len(self.bodies) + 1))

    def _by_optics(
        self, b: int, body: OpticalBody, occlusion: OcclusionScene, antenna: Floats, time: float, reach: float, movers: bool
    ) -> BodyEchoes:
        """What body b sends back by physical optics; arguments as in `reflections`."""
        if self.passing is not None:
            time = self.passing.moment(self.bodies[b], time)
            antenna = self.passing.scene.antenna(time)[0]
        held = self.held.get(b)
        if held is not None and held[0] == time and self.passing is not None:
            return held[1]
        stand = pose_at(self.bodies[b], time)

        def seen(points: Floats, triangle: Indices) -> NDArray[np.bool_]:
            surface = Surface(np.full(len(points), self.key[b]), triangle)
            place = map_from_body(points, stand.position, stand.heading)
            return occlusion.visible(surface, place, antenna, time, reach, movers)

        position, amplitude = body.echoes(antenna_from(self.bodies[b], stand, antenna, occlusion.earth_radius), seen)
        found = BodyEchoes(position, amplitude, np.full(len(position), b))
        self.held[b] = (time, found)
        return found

    def _amplitude(
        self, asked: Indices, place: Floats, normal: Floats, antenna: Floats, earth_radius: float
    ) -> NDArray[np.complex128]:
        """Root of the cross-section [m] with its phase of visible scatterers `asked` for, (A,): declared ones shared by
        projected area, the others diffuse (constant gamma: sigma = gamma cos(i) A)."""
        sight = antenna - place
        sight[:, 2] -= (sight[:, 0] ** 2 + sight[:, 1] ** 2) / (2.0 * earth_radius)  # as the surface sees the antenna
        length = np.sqrt(np.einsum("ij,ij->i", sight, sight))  # a third of the time of linalg.norm
        cosine = np.abs(np.einsum("ij,ij->i", sight, normal)) / np.maximum(length, 1e-9)  # meshes are wound either way
        cosine[self.triangle[asked] < 0] = 1.0
        facing, body = cosine * self.area[asked], self.body[asked]
        total = np.bincount(body, facing, minlength=len(self.bodies))
        per_area = np.where(np.isnan(self.rcs), self.gamma, self.rcs / np.where(total > 0, total, 1.0))
        return np.asarray(np.sqrt(per_area[body] * facing) * self.phasor[asked])


def _by_body(parts: Sequence[BodyEchoes]) -> BodyEchoes:
    """All reflections in one record, in rising order of body."""
    position, amplitude, body = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("position", "amplitude", "body")
    )
    order = np.argsort(body, kind="stable")
    return BodyEchoes(position[order], amplitude[order], body[order])


def antenna_from(body: Body, stand: BodyPose, antenna: Floats, earth_radius: float) -> Floats:
    """The antenna (3,) in a body's own frame [m], raised by what the earth drops in between, so that ranges in that frame
    are those of the antenna's frame (DESIGN section 2)."""
    local = (antenna - stand.position) @ body_rotation(stand.heading)
    east, north, _ = local - body.middle
    local[2] += (east**2 + north**2) / (2.0 * earth_radius)
    return np.asarray(local)


def placed(points: Floats, body: Indices, stands: Sequence[BodyPose]) -> Floats:
    """Points (E, 3) [m] of bodies' own frames, each of `body` (E,) in rising order, on the map."""
    place = turned(points, body, stands)
    if len(stands):
        place += np.array([stand.position for stand in stands])[body]
    return place


def turned(vectors: Floats, body: Indices, stands: Sequence[BodyPose]) -> Floats:
    """Vectors (E, 3) of bodies' own frames, each of `body` (E,) in rising order, along the map's axes."""
    result = vectors.copy()
    for b, stand in enumerate(stands):
        if stand.heading:
            part = slice(*np.searchsorted(body, [b, b + 1]))
            result[part] = vectors[part] @ body_rotation(stand.heading).T
    return result


def build_scatterers(
    bodies: Sequence[Body],
    radar: Radar,
    antenna: Floats,
    per_cell: float,
    seed: int,
    keys: Sequence[int],
    bounces: int = 3,
    passing: BeamCrossing | None = None,
    min_scatterers: int = MIN_SCATTERERS,
) -> ScattererSet:
    """Scatterers over `bodies`, as dense as the resolution cell at their distance from `antenna` (3,) at time 0 asks for.

    keys: (B,) the index of each body in the scene; bounces: surfaces in a row that physical optics follows;
    passing: where given, optics is evaluated for the moments the beam passes; fewest: points on the smallest surface.
    """
    parts = [
        _scatterers(body, radar, antenna, per_cell, min_scatterers, seed, key)
        for body, key in zip(bodies, keys, strict=True)
    ]
    counts = np.array([len(part) for part in parts], dtype=np.int64)

    def joined(name: str, empty: tuple[int, ...], dtype: type) -> NDArray[np.generic]:
        return np.concatenate([np.zeros(empty, dtype), *(getattr(part, name) for part in parts)])

    return ScattererSet(
        tuple(bodies),
        np.array(keys, dtype=np.int64),
        np.asarray(joined("position", (0, 3), np.float64), np.float64),
        np.asarray(joined("normal", (0, 3), np.float64), np.float64),
        np.asarray(joined("area", (0,), np.float64), np.float64),
        np.asarray(joined("triangle", (0,), np.int64), np.int64),
        np.asarray(joined("phasor", (0,), np.complex128), np.complex128),
        np.repeat(np.arange(len(parts)), counts),
        np.array([body.material.gamma for body in bodies], dtype=np.float64),
        np.array([np.nan if body.rcs is None else body.rcs for body in bodies], dtype=np.float64),
        tuple(optical_body(body, radar, bounces) if uses_optics(body) else None for body in bodies),
        passing,
    )


def uses_optics(body: Body) -> bool:
    """Whether a body scatters by physical optics."""
    return body.mesh is not None and body.rcs is None and body.scattering == "optics"


def _scatterers(
    body: Body, radar: Radar, antenna: Floats, per_cell: float, min_scatterers: int, seed: int, key: int
) -> Scatterers:
    """The scatterers of one body. A declared cross-section on a body within one resolution cell is a point."""
    if body.mesh is None:
        return point_scatterer(np.zeros(3))
    if uses_optics(body):
        return no_scatterers()
    if body.rcs is not None and np.hypot(body.length, body.beam) < radar.range_resolution:
        corners = body.mesh.vertices[np.unique(body.mesh.faces)]
        return point_scatterer((corners.min(axis=0) + corners.max(axis=0)) / 2.0)
    pose = body.motion.pose(0.0)
    centroid, _, _ = triangle_frames(body.mesh)
    place = map_from_body(centroid, pose.position[0], float(pose.heading[0]))
    distance = np.hypot(place[:, 0] - antenna[0], place[:, 1] - antenna[1])
    density = cell_density(distance, radar.range_step, radar.beamwidth, per_cell)
    return scatter_over(body.mesh, density, generator(seed, SCATTER, key), min_scatterers)
