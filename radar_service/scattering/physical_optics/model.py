"""Physical optics as a scattering model: metal meshes, evaluated body by body when the beam crosses them.

Equal bodies share what does not depend on their motion.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from typing_extensions import override

from radar_service.numerics import Floats, Indices, map_from_body
from radar_service.propagation import diffraction_height
from radar_service.radar import Radar, horizon
from radar_service.records import Fidelity
from radar_service.scattering.model import (
    ALL_PATHS,
    AspectModel,
    BodyEchoes,
    BodyRun,
    Caster,
    Conditions,
    Instant,
    RunError,
    ScatteringContext,
)
from radar_service.scattering.physical_optics.body_legs import FLATTEST, BodyLeg, SeaField, ground_before
from radar_service.scattering.physical_optics.cast_shadows import Onlooker
from radar_service.scattering.physical_optics.mesh_quality import (
    CURVES_DB,
    MAX_SAG,
    curve_sag,
    is_concave,
    length_text,
    mesh_quality,
    outward_side,
)
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces, aspect_seconds
from radar_service.scattering.physical_optics.plane_echoes import EdgeLimits, PlaneOptics, Wave
from radar_service.scattering.physical_optics.plating import PlatedWalls, vessel_remarks
from radar_service.scattering.physical_optics.scattering_centres import (
    PATHS,
    UPRIGHT,
    Lattice,
    PathCentres,
    flattest,
    over_nodes,
    strongest,
)
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.trace import content_key
from radar_service.world import Body, BodyPose, Mesh, Plating, pose_at, power_reflectivity

BOX_CORNERS = np.arange(8)[:, None] & [1, 2, 4] > 0  # (8, 3) at which end of each axis each lies
# Facets are added coherently, and equal facets repeat their error of phase, so it forms a beam of its own. With these sags it
# is 0.2 dB; with 1/64 of the wavelength it is up to 0.8 dB (tests/scattering/physical_optics/test_curves.py).
SHAPE_SAG = {"sphere": 1.0 / 300.0, "cylinder": 1.0 / 400.0}  # wavelengths
MAX_CURVES_DB = 1.0  # beyond it bends are more likely edges than curves: no number is given
FACETS_DB = 0.1  # plates against their formulas (tests/scattering/physical_optics)
REBOUNCES_DB = 0.4  # 0.33 dB rms over 317 aspects of seven ships against brute force (docs/accuracy.md#accuracy)


@dataclass(frozen=True)
class OpticalBody:
    """A mesh that scatters by physical optics.

    mesh: its triangles. optics: its pieces. limits: what bounds edges and cells. reflectivity: power ratio at each surface.
    """

    mesh: Mesh
    optics: PlaneOptics
    limits: EdgeLimits
    reflectivity: float

    @classmethod
    def of(cls, body: Body, radar: Radar, bounces: int) -> "OpticalBody":
        """A body with a mesh, prepared for this radar."""
        assert body.mesh is not None
        mesh, outside = body.mesh, outward_side(body.mesh)
        bounces = bounces if is_concave(mesh) else 1
        wave = Wave(radar.wavelength, radar.polarization)
        pieces = PlanarPieces.of(mesh, outside)
        walls = PlatedWalls.of(mesh, pieces.normal, pieces.spans, body.plating, radar.wavelength)
        optics = PlaneOptics.of(pieces, wave, bounces, radar.range_resolution, walls)
        return cls(mesh, optics, EdgeLimits.of(radar, mesh), power_reflectivity(body.material.name))

    def dry_box(self, height: float) -> Floats:
        """The corners (8, 3) of the box around what rises above the sea, where the origin is at a height over it [m]."""
        low, high = self.mesh.vertices.min(axis=0), self.mesh.vertices.max(axis=0)
        low[2] = max(low[2], min(-height, high[2]))
        return np.asarray(np.where(BOX_CORNERS, high, low))

    def leaning(self, lean: Floats) -> "OpticalBody":
        """The same body rotated by a matrix (3, 3), so that the sea is level in its frame."""
        mesh = Mesh(self.mesh.vertices @ lean.T, self.mesh.faces)
        return replace(self, mesh=mesh, optics=self.optics.rotated(lean))

    def echoes(self, legs: tuple[BodyLeg, ...], water: float = -np.inf) -> list[PathCentres]:
        """The centres of each path of one leg, or of two: the direct one and the one by the sea.

        water: height of the sea in the body's frame [m]; nothing below it scatters. Raises MemoryError.
        """
        sea, wave, longest = legs[0].sea, self.optics.wave, self.limits.longest
        if sea is not None:
            longest = longest._replace(edge=min(longest.edge, sea.longest))
        echoes = self.optics.echoes(legs, water, longest)
        cell = self.limits.cell(legs[0].length(echoes.place))
        lattice = Lattice.over(echoes.place, cell, flattest(legs), water)
        weights, received = over_nodes(legs, lattice, echoes), legs[0].weight(lattice.nodes) ** 2
        lengths, result = [leg.length(lattice.nodes) for leg in legs], []
        weight = np.choose(echoes.ways, np.broadcast_arrays(echoes.ways, *weights)[1:])
        amplitude = echoes.amplitude * self.reflectivity ** (echoes.surfaces / 2.0) * weight
        for (out, back), fields in zip(PATHS, lattice.sums(amplitude, echoes.ways, len(weights)), strict=False):
            sums = fields * wave.phasor(-lengths[out] - lengths[back])
            kept = strongest(np.abs(sums * received))
            result.append(PathCentres(out + back, lattice.nodes[kept], sums[kept]))
        return result


def optical_bodies(bodies: Sequence[Body], radar: Radar, bounces: int) -> list[OpticalBody]:
    """`OpticalBody` of each body. Those of equal meshes, materials and plating are one object."""
    optical: dict[tuple[bytes, str, Plating | None], OpticalBody] = {}
    result = []
    for body in bodies:
        assert body.mesh is not None
        key = content_key(body.mesh.vertices, body.mesh.faces), body.material.name, body.plating
        if key not in optical:
            optical[key] = OpticalBody.of(body, radar, bounces)
        result.append(optical[key])
    return result


class PhysicalOptics(AspectModel):
    """Bodies (B,) by physical optics with up to `Fidelity.bounces` surfaces in a row."""

    by_aspect: ClassVar[bool] = True
    diffracts: ClassVar[bool] = True
    lit_by_sea: ClassVar[bool] = True  # with ranges of their own, so the plan tells no delay

    def __init__(self, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> None:
        self.bodies, self.key = tuple(bodies), key
        self.scatterers: Indices = np.zeros(len(key), dtype=np.int64)
        self._optical = optical_bodies(bodies, context.radar, context.fidelity.bounces)
        self._radar, self._environment = context.radar, context.environment
        self._over_horizon = diffraction_height(context.radar, context.environment)

    @override
    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        return BodyEchoes.joined([self.body_echoes(b, antenna, instant) for b in self._in_wedge(instant)])

    def coherence(self, b: int, distance: float) -> float:
        """Size [m] over which phases are summed into one echo of body b at `distance` [m]: echoes hold while its aspect
        turns by much less than a wavelength over this."""
        return self._optical[b].limits.coherence(distance - self.bodies[b].radius)

    def upright(self, b: int, distance: float) -> float:
        """The height [m] of what `coherence` is the length of."""
        flattest = FLATTEST if self._environment.multipath else np.inf
        return self._optical[b].limits.coherence(distance - self.bodies[b].radius, UPRIGHT, flattest)

    def _in_wedge(self, instant: Instant) -> list[int]:
        """The bodies that have a part in the wedge of an instant."""
        if instant.wedge is None:
            return list(range(len(self.bodies)))
        centre = np.array([body.middle_at(instant.time) for body in self.bodies]).reshape(-1, 3)
        return np.flatnonzero(instant.wedge.contains(centre, np.array([body.radius for body in self.bodies]))).tolist()

    @override
    def body_echoes(self, b: int, antenna: Floats, instant: Instant) -> BodyEchoes:
        posed = pose_at(self.bodies[b], instant.time)
        optical = self._optical[b] if posed.lean is None else self._optical[b].leaning(posed.lean)
        legs = self._legs(b, optical, posed, antenna, instant)
        centres = optical.echoes(legs, self._lowest(b, legs[0]))
        if posed.lean is not None:
            centres = [path._replace(position=path.position @ posed.lean) for path in centres]
        return BodyEchoes.joined([_body_echoes(b, path, len(legs) > 1) for path in centres])

    def _legs(self, b: int, optical: OpticalBody, posed: BodyPose, antenna: Floats, instant: Instant) -> tuple[BodyLeg, ...]:
        """The direct leg to body b in a pose, and the one by the sea where that does not stand for all paths, above what
        reflects."""
        over_sea, scene = self._environment.multipath and bool(antenna[2] > 0.0), instant.line_of_sight
        sea = self._sea_field(b, optical, posed.upright, antenna) if over_sea else None
        by_paths = over_sea and not (sea is not None and sea.all_paths)
        ground = 0.0
        if by_paths and sea is None:
            ground = ground_before(self._radar, self._environment, scene, antenna, _box(optical, posed.upright))
        pose, raised = posed.lifted(-ground).upright, antenna - [0.0, 0.0, ground]
        others = scene.other_occluders(int(self.key[b]), antenna, instant.time, instant.movers)
        before = scene.posed_triangles(others, instant.time)
        shadows = self._onlooker(optical, pose, raised, instant, by_paths).shadows(
            [(triangles, each.lifted(-ground)) for triangles, each in before]
        )
        fields = (None, sea) if by_paths else (sea,)
        return tuple(
            BodyLeg(number > 0, pose, raised, scene.earth_radius, field, cast)
            for number, (field, cast) in enumerate(zip(fields, shadows, strict=True))
        )

    def _lowest(self, b: int, leg: BodyLeg) -> float:
        """Height [m] in the frame of body b below which nothing scatters: of the sea, or where nothing diffracts of the way over
        the horizon to its middle."""
        water, height = -float(leg.pose.position[2]), max(float(leg.antenna[2]), 0.0)
        if height < self._over_horizon:
            return water
        middle = leg.on_map(self.bodies[b].middle)
        beyond = math.dist(middle[:2], leg.antenna[:2]) - float(horizon(0.0, height, leg.earth_radius))
        return water + max(beyond, 0.0) ** 2 / (2.0 * leg.earth_radius)

    @override
    def casters(
        self, b: int, among: Mapping[int, float], antenna: Floats, instant: Instant, own_moved: float
    ) -> list[Caster]:
        pose = pose_at(self.bodies[b], instant.time)
        optical = self._optical[b] if pose.lean is None else self._optical[b].leaning(pose.lean)
        onlooker = self._onlooker(optical, pose.upright, antenna, instant, self._environment.multipath and antenna[2] > 0.0)
        posed = instant.line_of_sight.posed_triangles(list(among), instant.time)
        nearest = [onlooker.nearest(*other, moved, own_moved) for moved, other in zip(among.values(), posed, strict=True)]
        return [Caster(key, distance) for key, distance in zip(among, nearest, strict=True) if distance < np.inf]

    @staticmethod
    def _onlooker(optical: OpticalBody, pose: BodyPose, antenna: Floats, instant: Instant, by_paths: bool) -> Onlooker:
        """A body in the frame in which the sea is level, as other bodies may hide it from the antenna (3,); by_paths: by the sea
        too."""
        radius = instant.line_of_sight.earth_radius
        legs = tuple(Picture(antenna, radius, by_sea) for by_sea in (False, True)[: 1 + by_paths])
        return Onlooker(_box(optical, pose), legs)

    def _sea_field(self, b: int, optical: OpticalBody, pose: BodyPose, antenna: Floats) -> SeaField | None:
        """The field of all paths at body b where diffraction counts, and None elsewhere."""
        body = self.bodies[b]
        middle = map_from_body(body.middle, pose.position, pose.heading) - antenna
        distance = float(np.hypot(middle[0], middle[1]))
        ends = max(distance, 1.0), max(distance + body.radius, 1.0)
        top = max(float(pose.position[2]) + float(optical.mesh.vertices[:, 2].max()), 0.0)
        return SeaField.at_body(self._radar, self._environment, ends, top, float(antenna[2]))

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """A plate of all its area, which each bounce may light once more: 4 pi A^2 / lambda^2."""
        assert body.mesh is not None
        area = float(normals_and_areas(body.mesh)[1].sum())
        return 4.0 * math.pi * (fidelity.bounces * area / radar.wavelength) ** 2

    @staticmethod
    @override
    def description(body: Body, conditions: Conditions, computed: str) -> str:
        assert body.mesh is not None
        bounces = conditions.fidelity.bounces if is_concave(body.mesh) else 1
        pieces = len(PlanarPieces.of(body.mesh, outward_side(body.mesh)))
        how = f"up to {bounces} bounces, as parts face each other" if bounces > 1 else "one surface, as none faces another"
        cost = f"{pieces} pieces, some {1e3 * aspect_seconds(pieces, bounces):.2g} ms an aspect"
        return f"physical optics, {how}; {cost}, {computed}"

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """Measured: of plates against closed forms, of meshes whose parts face each other against brute force."""
        assert body.mesh is not None
        return REBOUNCES_DB if is_concave(body.mesh) else FACETS_DB

    @staticmethod
    def run_error(body: Body, conditions: Conditions, run: BodyRun) -> RunError:
        """Errors of curves, beyond those of plates and corners."""
        assert body.mesh is not None
        sag = curve_sag(body.mesh)
        curves = CURVES_DB * sag / (MAX_SAG * conditions.radar.wavelength)
        if curves > MAX_CURVES_DB:
            remark = f"bends that are meant as curves sag by {length_text(sag)} and err by over {MAX_CURVES_DB:.0f} dB"
            return RunError(0.0, (remark,))
        return RunError(curves, (f"curves sag by {length_text(sag)}: {curves:.1g} dB",)) if curves > 0.0 else RunError()

    @staticmethod
    def coherence_at(body: Body, radar: Radar, nearest: float) -> float:
        """The longer of cell and edge [m]."""
        assert body.mesh is not None
        return EdgeLimits.of(radar, body.mesh).coherence(nearest)

    @staticmethod
    @override
    def shape_sag(shape: str, wavelength: float) -> float | None:
        return SHAPE_SAG[shape] * wavelength if shape in SHAPE_SAG else None

    @staticmethod
    @override
    def mesh_remarks(body: Body, conditions: Conditions, nearest: float) -> list[str]:
        """Returns the remarks of `mesh_quality` and `vessel_remarks`."""
        return mesh_quality(body, conditions.radar, conditions.fidelity.bounces, nearest) + vessel_remarks(body)


def _box(optical: OpticalBody, pose: BodyPose) -> Floats:
    """The corners (8, 3) of the box around what of an upright body rises above the sea, on the map [m]."""
    return map_from_body(optical.dry_box(float(pose.position[2])), pose.position, pose.heading)


def _body_echoes(b: int, centres: PathCentres, by_paths: bool) -> BodyEchoes:
    """The echoes of a path of body b; without sea reflection, and where diffraction counts, its only path stands for all."""
    count = len(centres.amplitude)
    path = np.full(count, centres.path if by_paths else ALL_PATHS)
    return BodyEchoes(centres.position, centres.amplitude, np.full(count, b), path, np.zeros(count))
