"""Physical optics as a scattering model: metal meshes, evaluated body by body when the beam crosses them.

Equal bodies share what does not depend on their motion.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar, NamedTuple, Self

import numpy as np
from typing_extensions import override

from radar_service.numerics.frames import body_rotation, map_from_body
from radar_service.numerics.types import Complexes, Flags, Floats, Indices
from radar_service.propagation.diffraction import diffraction_height
from radar_service.propagation.multipath import reflection_points
from radar_service.radar.parameters import Radar, horizon
from radar_service.records.fidelity import Fidelity
from radar_service.scattering.model import ALL_PATHS, AspectModel, BodyEchoes, Caster, Instant, ScatteringContext
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.cast_shadows import CastShadows, Onlooker, most_triangles
from radar_service.scattering.physical_optics.convex_bodies import Centres
from radar_service.scattering.physical_optics.convex_sights import casters_over, plain_sights
from radar_service.scattering.physical_optics.facets import MAX_FACETS, edge_limits
from radar_service.scattering.physical_optics.illumination import Illumination, lift
from radar_service.scattering.physical_optics.mesh_quality import (
    CURVES_DB,
    MAX_SAG,
    curve_sag,
    length_text,
    mesh_quality,
)
from radar_service.scattering.physical_optics.optical_body import (
    OpticalBody,
    facet_enlargement,
    optical_bodies,
)
from radar_service.scattering.physical_optics.own_shadows import OwnShadows
from radar_service.scattering.physical_optics.patches import is_concave, outward_side
from radar_service.scattering.physical_optics.path_centres import PathCentres
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces, aspect_seconds
from radar_service.scattering.physical_optics.plating import dents_db
from radar_service.scattering.physical_optics.rounded_aspect import RoundedAspect
from radar_service.scattering.physical_optics.scattering_centres import UPRIGHT
from radar_service.scattering.physical_optics.sea_field import SeaField, ground_before, strength_by_sea
from radar_service.scattering.physical_optics.shadow_edges import Edges, Visible
from radar_service.scattering.physical_optics.vessel_walls import vessel_remarks
from radar_service.scattering.predictions import NEAREST, BodyRun, Conditions, RunError
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.trace.line_of_sight import SurfacePoints
from radar_service.trace.occluder import Occluder
from radar_service.world.body import Body
from radar_service.world.poses import BodyPose, pose_at

# Facets are added coherently, and equal facets repeat their error of phase, so it forms a beam of its own. With these sags it
# is 0.2 dB; with 1/64 of the wavelength it is up to 0.8 dB (tests/scattering/physical_optics/test_curves.py).
SHAPE_SAG = {"sphere": 1.0 / 300.0, "cylinder": 1.0 / 400.0}  # wavelengths
MAX_CURVES_DB = 1.0  # beyond it bends are more likely edges than curves: no number is given
SHADOW_SHARE = 0.03  # of a facet: rms error of where a shadow of the body's own parts ends (shadow_edges)
SIMPLE = 200  # triangles: a plain hull has 104, and sharing its trace saves a quarter of its time
FACETS_DB, REBOUNCES_DB = 0.1, 0.4  # plates and corners against their formulas (tests/scattering/physical_optics)


class _View(NamedTuple):
    """A body as an antenna has it: prepared for its pose, in the frame in which the sea is level, with the legs to it.

    lean: from its own frame to that one; None: they are the same. by_paths: echoes by the sea are apart. on_land: land reflects.
    """

    optical: OpticalBody
    legs: tuple[BodyLeg, ...]
    pose: BodyPose
    lean: Floats | None
    by_paths: bool
    on_land: bool

    @property
    def water(self) -> float:
        """Height of the sea, or of the land that reflects in its place [m]."""
        return -float(self.pose.position[2])

    @property
    def is_shaded(self) -> bool:
        """Whether another body or the horizon may shade it, or diffraction counts: what it shows then hangs on more than its
        pose."""
        return self.on_land or any(
            leg.edges is None or leg.others is None or len(leg.others) > 0 or leg.sea is not None for leg in self.legs
        )

    def traced(self) -> Illumination | None:
        """What the legs reach, for other poses near by; None where that hangs on more than the pose."""
        return None if self.is_shaded else self.optical.illuminated(self.legs, self.water)


class PhysicalOptics(AspectModel):
    """Bodies (B,) by physical optics with up to `Fidelity.bounces` surfaces in a row."""

    by_aspect: ClassVar[bool] = True
    diffracts: ClassVar[bool] = True
    lit_by_sea: ClassVar[bool] = True
    tells_sea_delay: ClassVar[bool] = False  # echoes by each path have ranges of their own
    has_resting_points: ClassVar[bool] = False
    upright: ClassVar[float] = UPRIGHT
    dents_db = staticmethod(dents_db)

    def __init__(
        self, bodies: Sequence[Body], key: Indices, optical: Sequence[OpticalBody], context: ScatteringContext
    ) -> None:
        """key: (B,) index of each body in the scene."""
        self.bodies, self.key = tuple(bodies), key
        self.scatterers: Indices = np.zeros(len(key), dtype=np.int64)
        self._optical, self._radar, self._environment = tuple(optical), context.radar, context.environment
        self._over_horizon = diffraction_height(context.radar, context.environment)
        self._trace_step = math.radians(context.fidelity.trace_step_deg)

    @classmethod
    @override
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        optical = optical_bodies(bodies, context.radar, context.fidelity.bounces, context.rays)
        return cls(bodies, key, optical, context)

    @override
    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        return BodyEchoes.joined([self.body_echoes(b, antenna, instant) for b in self._in_wedge(instant)])

    def coherence(self, b: int, distance: float) -> float:
        """Size [m] over which phases are summed into one echo of body b at `distance` [m]: echoes hold while its aspect
        turns by much less than a wavelength over this."""
        return self._optical[b].coherence(distance)

    def clear(self) -> None:
        """Clears nothing: no cache depends on an instant."""

    def _in_wedge(self, instant: Instant) -> list[int]:
        """The bodies that have a part in the wedge of an instant."""
        if instant.wedge is None:
            return list(range(len(self.bodies)))
        centre = np.array([body.middle_at(instant.time) for body in self.bodies]).reshape(-1, 3)
        near = instant.wedge.contains(centre, np.array([body.radius for body in self.bodies]))
        return [int(b) for b in np.flatnonzero(near)]

    @override
    def body_echoes(
        self, b: int, antenna: Floats, instant: Instant, trace: Callable[[], Illumination | None] | None = None
    ) -> BodyEchoes:
        seen = self._view(b, antenna, instant, pose_at(self.bodies[b], instant.time))
        kept = None if trace is None or seen.is_shaded else trace()
        if kept is not None:
            centres = seen.optical.echoes_near(kept, seen.legs, seen.water)
        else:
            centres = seen.optical.echoes(seen.legs, seen.water)
        if seen.lean is not None:
            centres = [path._replace(position=path.position @ seen.lean) for path in centres]
        return BodyEchoes.joined([_body_echoes(b, path, seen.by_paths) for path in centres])

    @override
    def passage_echoes(
        self, b: int, antenna: Floats, times: Floats, instant: Instant
    ) -> tuple[BodyEchoes, Complexes] | None:
        optical, middle = self._optical[b], len(times) // 2
        pose = pose_at(self.bodies[b], float(times[middle]))
        plain = optical.is_small_and_convex and instant.movers and not self._ground(optical, pose, antenna[middle], instant)
        sights = plain_sights(self.bodies[b], self._radar, self._environment, antenna, times, instant) if plain else None
        if sights is None:
            return None
        onlooker = self._onlooker(optical, pose, antenna[middle], instant, sights.legs > 1)
        casters = casters_over(int(self.key[b]), onlooker, antenna, times, instant)
        centres = optical.centres_at(sights, casters, most_triangles(len(optical.mesh.faces)))
        if centres is None:
            each = zip(antenna, times.tolist(), strict=True)
            centres = Centres.of([self.body_echoes(b, at, replace(instant, time=time)) for at, time in each])
        count = len(centres.path)
        path = centres.path if sights.legs > 1 else np.full(count, ALL_PATHS)
        return BodyEchoes(
            centres.position, centres.amplitude[:, 0], np.full(count, b), path, np.zeros(count)
        ), centres.amplitude

    @override
    def trace_step(self, b: int) -> float:
        few = self.bodies[b].motion.sway is not None and len(self._optical[b].mesh.faces) <= SIMPLE  # a trace takes little
        return self._trace_step if self._optical[b].is_concave and not few else 0.0

    @override
    def turned(self, b: int, antenna: Floats, time: Floats) -> Floats:
        position, matrix = _poses(self.bodies[b], time)
        view = antenna - position
        distance = np.maximum(np.linalg.norm(view, axis=1, keepdims=True), 1e-9)
        toward = np.einsum("ki,kij->kj", view / distance, matrix)
        step = np.linalg.norm(np.diff(np.concatenate([toward, matrix[:, 2]], axis=1), axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(step)])

    @override
    def traced(self, b: int, antenna: Floats, instant: Instant, times: Floats) -> Illumination | None:
        body = self.bodies[b]
        assert body.mesh is not None
        height = lift(body.mesh.vertices, *_poses(body, np.append(instant.time, times)))
        return self._view(b, antenna, instant, pose_at(body, instant.time).lifted(height)).traced()

    @override
    def rounded_aspect(self, b: int, antenna: Floats, time: float) -> RoundedAspect:
        body = self.bodies[b]
        return RoundedAspect.of(antenna, pose_at(body, time), 2.0 * self._trace_step, body.middle, body.radius)

    @override
    def traced_at(self, b: int, aspect: RoundedAspect, instant: Instant) -> Illumination | None:
        return self._view(b, aspect.antenna, instant, aspect.pose, alone=True).traced()

    def _view(self, b: int, antenna: Floats, instant: Instant, posed: BodyPose, alone: bool = False) -> _View:
        """Body b as the antenna has it in a pose at an instant, above what reflects; alone: as if there were no others."""
        lean, scene = posed.lean, instant.line_of_sight
        optical = self._optical[b] if lean is None else self._optical[b].leaning(lean)
        over_sea = self._environment.multipath and antenna[2] > 0.0
        sea = self._sea_field(b, optical, posed.upright, antenna) if over_sea else None
        by_paths = over_sea and not (sea is not None and sea.all_paths)
        others = [] if alone else scene.other_occluders(int(self.key[b]), antenna, instant.time, instant.movers)
        own = scene.occluder_of(int(self.key[b]), instant.time, instant.movers)
        own = own if own is not None and self._in_reach(b, posed.upright, antenna, instant) else None
        ground = self._ground(optical, posed.upright, antenna, instant) if by_paths and sea is None and not alone else 0.0
        posed, antenna = posed.lifted(-ground), antenna - [0.0, 0.0, ground]
        onlooker = self._onlooker(optical, posed.upright, antenna, instant, by_paths)
        posed_others = scene.posed_triangles(others, antenna, instant.time)
        shadows = onlooker.shadows([(triangles, pose.lifted(-ground)) for triangles, pose in posed_others])
        legs = [
            self._leg(b, optical, leg.by_sea, posed, antenna, instant, others, cast, own, ground)
            for leg, cast in zip(onlooker.legs, shadows, strict=True)
        ]
        legs[-1] = replace(legs[-1], sea=sea)
        return _View(optical, tuple(legs), posed.upright, lean, by_paths, ground > 0.0)

    def _ground(self, optical: OpticalBody, pose: BodyPose, antenna: Floats, instant: Instant) -> float:
        """`ground_before` a body in a pose."""
        return ground_before(self._radar, self._environment, instant.line_of_sight, antenna, _box(optical, pose))

    @override
    def casters(
        self, b: int, among: Mapping[int, float], antenna: Floats, instant: Instant, own_moved: float
    ) -> list[Caster]:
        pose = pose_at(self.bodies[b], instant.time)
        optical = self._optical[b] if pose.lean is None else self._optical[b].leaning(pose.lean)
        onlooker = self._onlooker(optical, pose.upright, antenna, instant, self._environment.multipath and antenna[2] > 0.0)
        posed = instant.line_of_sight.posed_triangles(list(among), antenna, instant.time)
        nearest = [onlooker.nearest(*other, moved, own_moved) for moved, other in zip(among.values(), posed, strict=True)]
        return [Caster(key, distance) for key, distance in zip(among, nearest, strict=True) if distance < np.inf]

    @staticmethod
    def _onlooker(optical: OpticalBody, pose: BodyPose, antenna: Floats, instant: Instant, by_paths: bool) -> Onlooker:
        """A body in the frame in which the sea is level, as other bodies may hide it from the antenna (3,); by_paths: by the sea
        too."""
        radius = instant.line_of_sight.earth_radius
        legs = tuple(Picture(antenna, radius, by_sea) for by_sea in (False, True)[: 1 + by_paths])
        return Onlooker(_box(optical, pose), legs, len(optical.mesh.faces))

    def _leg(
        self, b: int, optical: OpticalBody, by_sea: bool, posed: BodyPose, antenna: Floats, instant: Instant,
        others: list[int], shadows: CastShadows | None, own: Occluder | None, ground: float,
    ) -> BodyLeg:  # fmt: skip
        """The direct leg to a body, or the one by the sea, with what the scene lets it reach.

        optical: body b in the frame in which the sea is level. posed: its pose. others: bodies that may occlude it.
        shadows: that they cast, as from `Onlooker.shadows`. own: of the body, where all of it is in reach. ground: height of what
        reflects above the sea [m]; pose and antenna are above that.
        """
        scene, key, pose, up = instant.line_of_sight, int(self.key[b]), posed.upright, np.array([0.0, 0.0, ground])

        def visible(points: Floats, triangle: Indices, bodies: list[int]) -> Flags:
            position = map_from_body(points, pose.position, pose.heading)
            surface = SurfacePoints(np.full(len(points), key), triangle, position + up)
            seen = (antenna + up, instant.time, instant.max_range, instant.movers, bodies)
            if not by_sea:
                return scene.visible(surface, *seen, over_horizon=self._over_horizon)
            return scene.visible_by_sea(surface, reflection_points(position, antenna, scene.earth_radius)[0] + up, *seen)

        crowded = shadows is None
        edges: Edges | None = None
        seen: Visible = partial(visible, bodies=others if crowded else [])
        if own is not None and not crowded:
            own_shadows = OwnShadows(own, posed, antenna, scene.earth_radius, by_sea)
            seen, edges = own_shadows.visible, own_shadows.edges
        place = (*self._reach_and_top(b, optical, pose, antenna), antenna[2])
        strength = 1.0 if ground or not by_sea else strength_by_sea(self._radar, self._environment, *place)
        return BodyLeg(by_sea, pose, antenna, scene.earth_radius, seen, edges, crowded, strength, others=shadows)

    def _in_reach(self, b: int, pose: BodyPose, antenna: Floats, instant: Instant) -> bool:
        """Whether all of body b above the sea lies this side of the horizon, if it has one, and of the maximum range."""
        body = self.bodies[b]
        middle = map_from_body(body.middle, pose.position, pose.heading)
        distance = math.dist(middle, antenna) + body.diagonal
        low = max(float(antenna[2]), float(middle[2]) + body.diagonal) < self._over_horizon
        return distance < instant.max_range and (
            low or distance < float(horizon(0.0, max(float(antenna[2]), 0.0), instant.line_of_sight.earth_radius))
        )

    def _sea_field(self, b: int, optical: OpticalBody, pose: BodyPose, antenna: Floats) -> SeaField | None:
        """The field of all paths at body b where diffraction counts, and None elsewhere."""
        (_, *ends), top = self._reach_and_top(b, optical, pose, antenna)
        return SeaField.at_body(self._radar, self._environment, (float(ends[0]), float(ends[1])), top, float(antenna[2]))

    def _reach_and_top(self, b: int, optical: OpticalBody, pose: BodyPose, antenna: Floats) -> tuple[Floats, float]:
        """Distances along the earth (3,) of the near end, the middle and the far end of body b, and its top over the sea [m]."""
        body = self.bodies[b]
        middle = map_from_body(body.middle, pose.position, pose.heading) - antenna
        top = max(float(pose.position[2]) + float(optical.mesh.vertices[:, 2].max()), 0.0)
        return np.maximum(np.hypot(middle[0], middle[1]) + body.radius * np.array([-1.0, 0.0, 1.0]), 1.0), top

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
        distance = math.dist(body.middle_at(0.0), conditions.antenna) - body.radius
        times = facet_enlargement(body, conditions.radar, distance)
        coarse = "" if times == 1.0 else f"; facets {times:.1f} times longer than they should be, at most {MAX_FACETS}"
        bounces = conditions.fidelity.bounces if is_concave(body.mesh) else 1
        pieces = len(PlanarPieces.of(body.mesh, outward_side(body.mesh)))
        how = f"up to {bounces} bounces, as parts face each other" if bounces > 1 else "one surface, as none faces another"
        cost = f"{pieces} pieces, some {1e3 * aspect_seconds(pieces, bounces):.2g} ms an aspect by planes"
        return f"physical optics, {how}; {cost}, {computed}{coarse}"

    @staticmethod
    def sampling_db(scatterers: int, multipath: bool) -> float:
        """None: there are no scatterers."""
        return 0.0

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """Measured against closed forms: plates, and corners where parts of the mesh face each other."""
        assert body.mesh is not None
        return REBOUNCES_DB if is_concave(body.mesh) else FACETS_DB

    @staticmethod
    def run_error(body: Body, conditions: Conditions, run: BodyRun) -> RunError:
        """Errors of facets at the closest approach, beyond those of plates and corners."""
        assert body.mesh is not None
        distance, radar = max(run.nearest, NEAREST), conditions.radar
        times, edge = facet_enlargement(body, radar, distance), edge_limits(radar, body.mesh).longest_edge(distance)
        shadow = SHADOW_SHARE / math.sqrt(2.0) * min(1.0, times * edge / body.diagonal) ** 1.5
        errors, remarks = [20.0 * math.log10(1.0 + shadow)], []
        if times > 1.0:
            errors.append(FACETS_DB * times**2)
        if times > 1.0 and times > facet_enlargement(body, radar, max(run.start - body.radius, NEAREST)):
            remarks.append(
                f"at its closest, {run.nearest:.0f} m, facets are {times:.1f} times too long: {errors[-1]:.1g} dB"
            )
        sag = curve_sag(body.mesh)
        curves = CURVES_DB * sag / (MAX_SAG * radar.wavelength)
        if 0.0 < curves <= MAX_CURVES_DB:
            errors.append(curves)
            remarks.append(f"curves sag by {length_text(sag)}: {curves:.1g} dB")
        elif curves > MAX_CURVES_DB:
            remarks.append(
                f"bends that are meant as curves sag by {length_text(sag)} and err by over {MAX_CURVES_DB:.0f} dB"
            )
        return RunError(math.hypot(*errors), tuple(remarks))

    @staticmethod
    def coherence_at(body: Body, radar: Radar, nearest: float) -> float:
        """The longer side of the cells in which facets are summed."""
        assert body.mesh is not None
        return max(edge_limits(radar, body.mesh).at(nearest))

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


def _poses(body: Body, time: Floats) -> tuple[Floats, Floats]:
    """Positions (K, 3) on the map [m] and rotations (K, 3, 3) map_from_body of a body at times (K,) [s]."""
    pose = body.motion.pose(time)
    if pose.rotation is not None:
        return pose.position, pose.rotation
    return pose.position, np.array([body_rotation(heading) for heading in pose.heading.tolist()])
