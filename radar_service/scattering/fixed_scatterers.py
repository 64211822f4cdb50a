"""Scattering by fixed scatterers: what models of them share, and diffuse surfaces.

The scatterers of all bodies of a model lie in one set of arrays, so that visibility and amplitudes are computed together.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar

import numpy as np
from typing_extensions import override

from radar_service.numerics import SCATTER, Flags, Floats, Indices, Singles, generator, name_key
from radar_service.propagation import diffraction_height
from radar_service.radar import Radar
from radar_service.records import Fidelity
from radar_service.scattering.model import (
    ALL_PATHS,
    BearingWedge,
    BodyEchoes,
    BodyRun,
    Conditions,
    Instant,
    RunError,
    ScatteringContext,
    ScatteringModel,
)
from radar_service.scattering.resting_points import MapCells, RestingPoints
from radar_service.scattering.surface_sampling import (
    MAX_SCATTERERS,
    Scatterers,
    cell_density,
    density_db,
    normals_and_areas,
    sample_surface,
    surface_db,
    triangle_middles,
)
from radar_service.trace import SurfacePoints
from radar_service.world import Body, BodyPose, BodyPoses, Mesh, PoseArrays, pose_at

PEAK_TO_MEAN = 10.0  # an exponential draw exceeds 10 times its mean once in 22 000


class FixedScatterers(ScatteringModel, ABC):
    """Scatterers (E,) of B bodies, ordered by body. Subclasses say how strongly each scatters."""

    diffracts: ClassVar[bool] = True
    tells_sea_delay: ClassVar[bool] = True

    def __init__(self, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> None:
        """Density follows the resolution cell at the distance of each triangle at time 0."""
        self.bodies, self.key, self.context = tuple(bodies), key, context
        parts = [self.sample(body, context) for body in bodies]
        self.scatterers: Indices = np.array([len(part) for part in parts], dtype=np.int64)
        self._body: Indices = np.repeat(np.arange(len(parts)), self.scatterers)
        of_all = parts[0] if len(parts) == 1 else Scatterers.joined(parts)
        self._position, self._normal, self._area = of_all.position, of_all.normal, of_all.area
        self._triangle, self._phasor, self._span = of_all.triangle, of_all.phasor, of_all.span
        self._lift: Floats = of_all.middle - of_all.position[:, 2]
        self._one_sided: Flags = np.array([body.one_sided for body in bodies], dtype=np.bool_)  # others are wound either way
        self._solid: Flags = np.array([body.mesh is not None and body.mesh.solid for body in bodies], dtype=np.bool_)
        self._poses = BodyPoses(bodies)

    @staticmethod
    @abstractmethod
    def sample(body: Body, context: ScatteringContext) -> Scatterers:
        """The scatterers of one body. Their positions and phases depend on the seed and the names of scene and body."""

    @abstractmethod
    def visible_echoes(
        self, which: Indices, position: Floats, projected: Floats, antenna: Floats, poses: PoseArrays
    ) -> BodyEchoes:
        """The echoes of visible scatterers `which` (A,) at `position` (A, 3) on the map [m], of projected area (A,) above 0
        [m^2], as the antenna (3,) receives them; poses: of the bodies at that instant, the only one."""

    @override
    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        poses = self._poses.at(np.array([instant.time]))
        which, position = self._in_wedge(poses, instant.wedge)
        if not len(which):
            return BodyEchoes.joined([])
        line_of_sight, over = instant.line_of_sight, diffraction_height(self.context.radar, self.context.environment)
        one_sided = self._one_sided | self._hides_backs(antenna, poses, instant)
        normal, earth = self._normals(poses, which), line_of_sight.earth_radius
        projected = self._projected_area(which, position, normal, antenna, earth, one_sided)
        facing = np.flatnonzero(projected)  # no line of sight is sought to what faces away
        which, position, projected = which[facing], position.take(facing, axis=0), projected[facing]
        points = SurfacePoints(self.key[self._body[which]], self._triangle[which], position)
        seen = (points, antenna, instant.time, instant.max_range, instant.movers)
        visible = np.flatnonzero(line_of_sight.visible(*seen, over_horizon=over))
        which, position = which[visible], position.take(visible, axis=0)  # rows: a quarter of the time of [visible]
        projected = projected[visible]
        return self.visible_echoes(which, position, projected, antenna, poses)

    def _hides_backs(self, antenna: Floats, poses: PoseArrays, instant: Instant) -> Flags:
        """Which bodies (B,) hide all that faces away from the antenna (3,): solid ones that it stands outside of in plan."""
        solid = np.flatnonzero(self._solid)
        hides = np.zeros(len(self.bodies), dtype=np.bool_)
        if len(solid):
            middle, radius = (part[solid] for part in self._plan_circles)
            off = poses.map_from_bodies(0, middle, solid)[:, :2] - antenna[:2]
            itself = instant.line_of_sight.occludes_itself(self.key[solid], instant.time, instant.movers)
            hides[solid] = itself & (np.einsum("ij,ij->i", off, off) > radius**2)
        return hides

    def _heights(self, which: Indices, position: Floats) -> tuple[Floats, Floats]:
        """Middle heights on the map and vertical extents (A,) [m] of what scatterers `which` stand for, above the sea."""
        middle, span = position[:, 2] + self._lift[which], self._span[which]
        low, high = np.maximum(middle - span / 2.0, 0.0), middle + span / 2.0
        above = (span > 0.0) & (high > low)
        return np.where(above, (low + high) / 2.0, position[:, 2]), np.where(above, high - low, 0.0)

    @cached_property
    def _at_start(self) -> tuple[Floats, Floats]:
        """Positions (E, 3) [m] and normals (E, 3) on the map at time 0; those of bodies at rest hold at all times."""
        return self._map_at_start()

    def _map_at_start(self) -> tuple[Floats, Floats]:
        """Computes `_at_start`."""
        poses = self._poses.at(np.zeros(1))
        if not (poses.position.any() or poses.heading.any() or poses.rotation):  # on the map already
            return self._position, self._normal
        position = poses.map_from_bodies(0, self._position, self._body)
        return position, poses.rotated_from_bodies(0, self._normal, self._body)

    @cached_property
    def _plan_circles(self) -> tuple[Floats, Floats]:
        """Middles (B, 3) of the bodies' plans in their own frames, and radii (B,) about them [m]."""
        middles, radii = [body.middle for body in self.bodies], [body.radius for body in self.bodies]
        return np.array(middles).reshape(-1, 3), np.array(radii)

    def _in_wedge(self, poses: PoseArrays, wedge: BearingWedge | None) -> tuple[Indices, Floats]:
        """Scatterers (A,) within a wedge and their positions (A, 3) on the map [m]."""
        if wedge is None:
            which = np.arange(len(self._body))
            return which, self._positions(poses, which)
        middle, radius = self._plan_circles
        near = wedge.contains(poses.map_from_bodies(0, middle, np.arange(len(self.bodies))), radius)
        which = np.flatnonzero(near[self._body])
        if not len(which):
            return which, np.zeros((0, 3))
        position = self._positions(poses, which)
        kept = np.flatnonzero(self._counted(wedge.contains(position), which))
        return (which, position) if len(kept) == len(which) else (which[kept], position.take(kept, axis=0))

    def _counted(self, inside: Flags, which: Indices) -> Flags:
        """Which scatterers `which` (A,) count where some are `inside` (A,) a wedge."""
        return inside

    def _positions(self, poses: PoseArrays, which: Indices) -> Floats:
        """Positions (A, 3) on the map [m] of scatterers `which`."""
        moving = self._moving_among(which)
        if not len(moving) and len(which) == len(self._body):  # by far the most of a coast's scatterers: not copied
            return self._at_start[0]
        if len(moving) == len(which):
            return poses.map_from_bodies(0, self._position.take(which, axis=0), self._body[which])
        position, mover = self._at_start[0].take(which, axis=0), which[moving]
        position[moving] = poses.map_from_bodies(0, self._position.take(mover, axis=0), self._body[mover])
        return position

    def _normals(self, poses: PoseArrays, which: Indices) -> Floats:
        """Normals (A, 3) on the map of scatterers `which`."""
        moving = self._moving_among(which)
        if len(moving) == len(which):
            return poses.rotated_from_bodies(0, self._normal.take(which, axis=0), self._body[which])
        normal, mover = self._at_start[1].take(which, axis=0), which[moving]
        normal[moving] = poses.rotated_from_bodies(0, self._normal.take(mover, axis=0), self._body[mover])
        return normal

    def _moving_among(self, which: Indices) -> Indices:
        """Where in `which` (A,) scatterers of bodies that move are."""
        if not len(self._poses.moving):
            return np.zeros(0, dtype=np.int64)
        moves = np.zeros(len(self.bodies), dtype=np.bool_)
        moves[self._poses.moving] = True
        return np.flatnonzero(moves[self._body[which]])

    def _projected_area(
        self, which: Indices, position: Floats, normal: Floats, antenna: Floats, earth_radius: float, one_sided: Flags
    ) -> Floats:
        """Area (A,) of each scatterer projected across the line of sight [m^2]; one_sided: which bodies (B,) reflect on their
        outer sides alone."""
        cosine = cosines(position, normal, antenna, earth_radius)
        cosine = np.where(one_sided[self._body[which]], np.maximum(cosine, 0.0), np.abs(cosine))
        cosine[self._triangle[which] < 0] = 1.0
        return np.asarray(cosine * self._area[which])


class DiffuseScattering(FixedScatterers):
    """Rough surfaces: sigma0 = gamma cos(incidence) (constant gamma; Long, Radar Reflectivity of Land and Sea, 2001)."""

    has_resting_points: ClassVar[bool] = True

    @staticmethod
    def sample(body: Body, context: ScatteringContext) -> Scatterers:
        """Scatterers over the mesh."""
        return sampled(body, context, MAX_SCATTERERS)

    def visible_echoes(
        self, which: Indices, position: Floats, projected: Floats, antenna: Floats, poses: PoseArrays
    ) -> BodyEchoes:
        """gamma times the projected area. Each scatterer is an echo, at the middle height of what it stands for."""
        body = self._body[which]
        gamma = np.array([body.material.gamma for body in self.bodies], dtype=np.float64)
        amplitude = np.sqrt(gamma[body] * projected) * self._phasor[which]
        middle, span = self._heights(which, position)
        place, lift = self._position.take(which, axis=0), middle - position[:, 2]
        place[:, 2] += lift
        for b, rotation in poses.rotation.items():
            of_body = np.flatnonzero(body == b)
            place[of_body] = self._position[which[of_body]] + lift[of_body, None] * rotation[0, 2]  # up on the map
        return BodyEchoes(place, amplitude, body, np.full(len(body), ALL_PATHS, dtype=np.int64), span)

    def resting_points(self) -> RestingPoints:
        """The points of bodies that all rest; as many as there are scatterers."""
        position, normal = self._map_at_start()
        height, span = self._heights(np.arange(len(position)), position)
        gamma = np.array([body.material.gamma for body in self.bodies], dtype=np.float64)
        strength = np.sqrt(gamma[self._body] * self._area) * self._phasor
        cells, order = MapCells.of(position)
        return RestingPoints(
            cells,
            position.take(order, axis=0),
            normal.take(order, axis=0).astype(np.float32),
            self._triangle[order].astype(np.int32),
            self._body[order].astype(np.int32),
            self._one_sided[self._body[order]],
            (height - position[:, 2])[order].astype(np.float32),
            span[order].astype(np.float32),
            strength[order].astype(np.complex64),
        )

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """The peak of speckle over all of the area."""
        assert body.mesh is not None
        return PEAK_TO_MEAN * body.material.gamma * float(normals_and_areas(body.mesh)[1].sum())

    @staticmethod
    @override
    def description(body: Body, conditions: Conditions, computed: str) -> str:
        per_cell, requested = cell_scatterers(body, conditions), conditions.fidelity.scatterers_per_cell
        fewer = f"; the limit of {MAX_SCATTERERS} allows no {requested:g}" if per_cell < requested else ""
        return f"diffuse, {computed}, {per_cell:.3g} scatterers per resolution cell{fewer}"

    @staticmethod
    @override
    def sampling_db(scatterers: int, multipath: bool) -> float:
        return surface_db(scatterers, multipath)

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """The error of the scatterers in a cell, and of all of them."""
        error, scatterers = density_db(cell_scatterers(body, conditions)), conditions.scatterers
        if scatterers is None or scatterers <= 1:
            return error
        return max(error, cls.sampling_db(scatterers, conditions.environment.multipath))

    @staticmethod
    def run_error(body: Body, conditions: Conditions, run: BodyRun) -> RunError:
        """What a surface loses by coming nearer than it was when its scatterers were drawn: its cells have fewer."""
        if run.approach >= run.start:
            return RunError()
        radar, per_cell = conditions.radar, conditions.fidelity.scatterers_per_cell
        start, closest = (max(radar.beamwidth * distance, radar.range_step) for distance in (run.start, run.approach))
        there, before = per_cell * closest / start, density_db(per_cell)
        if conditions.scatterers is not None:
            there = max(there, conditions.scatterers / max(1.0, body.length * body.beam / (closest * radar.range_step)))
        after = density_db(there)
        if after <= before:
            return RunError()
        text = f"at its closest, {run.nearest:.0f} m, {there:.2g} scatterers per resolution cell"
        return RunError(math.sqrt(after**2 - before**2), (f"{text}: {after:.2g} dB",))


def sampled(body: Body, context: ScatteringContext, max_scatterers: int) -> Scatterers:
    """Scatterers over a mesh, so many to a resolution cell at the distance of each triangle at time 0."""
    assert body.mesh is not None
    pose, fidelity = pose_at(body, 0.0), context.fidelity
    rng = generator(context.seed, SCATTER, name_key(context.scene_name, body.name))
    density = surface_density(body.mesh, pose, context)
    sea = -float(pose.position[2]) if body.motion.sway is None else -np.inf  # what is above it differs by instant
    return sample_surface(body.mesh, density, rng, fidelity.min_scatterers, max_scatterers=max_scatterers, sea=sea)


def surface_density(mesh: Mesh, pose: BodyPose, context: ScatteringContext | Conditions) -> Floats:
    """Scatterers per m^2 (F,) on each triangle of a body's mesh in its pose at time 0 that a fidelity asks for."""
    middle, radar = pose.map_from_frame(triangle_middles(mesh)), context.radar
    distance = np.hypot(middle[:, 0] - context.antenna[0], middle[:, 1] - context.antenna[1])
    return cell_density(distance, radar.range_step, radar.beamwidth, context.fidelity.scatterers_per_cell)


def cell_scatterers(body: Body, conditions: Conditions) -> float:
    """Scatterers in a resolution cell of a surface: those of the fidelity, or what MAX_SCATTERERS leaves of them."""
    requested, scatterers = conditions.fidelity.scatterers_per_cell, conditions.scatterers
    if scatterers is None or scatterers < MAX_SCATTERERS:
        return requested
    assert body.mesh is not None
    density = surface_density(body.mesh, pose_at(body, 0.0), conditions)
    expected = float(density @ normals_and_areas(body.mesh)[1])
    return requested * min(1.0, MAX_SCATTERERS / expected)


def cosines(position: Floats, normal: Floats | Singles, end: Floats, earth_radius: float) -> Floats:
    """cos (A,) of the angle between normals and lines of sight from an end (3,)."""
    line = end - position
    line[:, 2] -= (line[:, 0] ** 2 + line[:, 1] ** 2) / (2.0 * earth_radius)  # as the surface sees the antenna
    length = np.sqrt(np.einsum("ij,ij->i", line, line))  # a third of the time of linalg.norm
    return np.asarray(np.einsum("ij,ij->i", line, normal) / np.maximum(length, 1e-9))
