"""Physical optics as a scattering model: metal meshes, evaluated body by body when the beam crosses them."""

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from radar_service.fidelity import Fidelity
from radar_service.frames import map_from_body
from radar_service.propagation.legs import reflection_points
from radar_service.radar.parameters import Radar
from radar_service.scattering.model import ALL_PATHS, BodyEchoes, Instant, ScatteringContext
from radar_service.scattering.physical_optics.body_legs import BodyLeg, Visible
from radar_service.scattering.physical_optics.facets import MAX_FACETS
from radar_service.scattering.physical_optics.optical_body import OpticalBody, PathCentres, facet_enlargement
from radar_service.scattering.physical_optics.patches import concave_sides
from radar_service.scattering.physical_optics.shared_bodies import optical_bodies
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.scene.body import Body
from radar_service.scene.poses import BodyPose, map_from_bodies, pose_at
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import SurfacePoints
from radar_service.types import Flags, Floats, Indices

FACETS_DB, REBOUNCES_DB = 0.1, 0.4  # plates and corners against their formulas (tests/scattering/physical_optics)
THIN = 15.0  # m of radius below which a body is searched for as one that casts a thin shadow
PROBES = 40  # triangles of a body, at the corners of which the shadows of large bodies are searched for


class PhysicalOptics:
    """Bodies (B,) by physical optics with up to `Fidelity.bounces` surfaces in a row."""

    def __init__(self, bodies: Sequence[Body], key: Indices, optical: Sequence[OpticalBody], multipath: bool) -> None:
        """key: (B,) index of each body in the scene; multipath: whether the sea reflects."""
        self.bodies, self.key = tuple(bodies), key
        self.scatterers: Indices = np.zeros(len(key), dtype=np.int64)
        self._optical, self._multipath = tuple(optical), multipath

    @classmethod
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        """As `ScatteringModel.build`."""
        optical = optical_bodies(bodies, context.radar, context.fidelity.bounces, context.rays)
        return cls(bodies, key, optical, context.environment.multipath)

    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        """As `ScatteringModel.echoes`."""
        return BodyEchoes.joined([self.body_echoes(b, antenna, instant) for b in self._in_sector(instant)])

    def coherence(self, b: int, distance: float) -> float:
        """Size [m] over which phases are summed into one echo of body b at `distance` [m]: echoes hold while its aspect
        turns by much less than a wavelength over this."""
        return self._optical[b].coherence(distance)

    def clear(self) -> None:
        """Nothing is cached that depends on an instant."""
        return

    def _in_sector(self, instant: Instant) -> list[int]:
        """The bodies that have a part in the sector of an instant."""
        if instant.sector is None:
            return list(range(len(self.bodies)))
        poses = [pose_at(body, instant.time) for body in self.bodies]
        position = np.array([pose.position for pose in poses]).reshape(-1, 3)
        heading = np.array([pose.heading for pose in poses])
        middle = np.array([body.middle for body in self.bodies]).reshape(-1, 3)
        centre = map_from_bodies(middle, np.arange(len(poses)), position, heading)
        near = instant.sector.contains(centre, np.array([body.radius for body in self.bodies]))
        return [int(b) for b in np.flatnonzero(near)]

    def body_echoes(self, b: int, antenna: Floats, instant: Instant) -> BodyEchoes:
        """Echoes of body b alone, as it is at the instant."""
        pose = pose_at(self.bodies[b], instant.time)
        over_sea = self._multipath and antenna[2] > 0.0
        others = instant.line_of_sight.other_occluders(int(self.key[b]), antenna, instant.time, instant.movers)
        ways = (False, True) if over_sea else (False,)
        legs = tuple(self._leg(b, by_sea, pose, antenna, instant, others) for by_sea in ways)
        centres = self._optical[b].echoes(legs, water=-float(pose.position[2]))
        return BodyEchoes.joined([_body_echoes(b, path, over_sea) for path in centres])

    def _leg(
        self, b: int, by_sea: bool, pose: BodyPose, antenna: Floats, instant: Instant, others: tuple[Indices, Floats]
    ) -> BodyLeg:
        """The direct leg to a body, or the one by the sea, with what the scene lets it reach.

        others: bodies that may occlude it and their radii [m], as from `OcclusionScene.other_occluders`.
        """
        scene, key, (among, radius) = instant.line_of_sight, int(self.key[b]), others
        seen = (antenna, instant.time, instant.max_range, instant.movers, among.tolist())

        def visible(points: Floats, triangle: Indices) -> Flags:
            position = map_from_body(points, pose.position, pose.heading)
            surface = SurfacePoints(np.full(len(points), key), triangle, position)
            if not by_sea:
                return scene.visible(surface, *seen)
            return scene.visible_by_sea(surface, reflection_points(position, antenna, scene.earth_radius)[0], *seen)

        thin = bool((radius < THIN).any())
        crowded = thin or (len(among) > 0 and self._is_shaded(b, pose, visible))
        return BodyLeg(by_sea, pose, antenna, scene.earth_radius, visible, crowded, thin)

    def _is_shaded(self, b: int, pose: BodyPose, visible: Visible) -> bool:
        """Whether other bodies cast shadows on some of a few points of body b above the water."""
        mesh = self._optical[b].mesh
        which = np.linspace(0, len(mesh.faces) - 1, min(len(mesh.faces), PROBES)).astype(np.int64)
        corners = mesh.vertices[mesh.faces[which]].reshape(-1, 3)
        corners = corners[corners[:, 2] + pose.position[2] > 0.0]
        return not visible(corners, np.full(len(corners), -1)).all()

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """A plate of all its area, which each bounce may light once more: 4 pi A^2 / lambda^2."""
        assert body.mesh is not None
        area = float(triangle_frames(body.mesh)[2].sum())
        return 4.0 * math.pi * (fidelity.bounces * area / radar.wavelength) ** 2

    @staticmethod
    def description(body: Body, scene: Scene, fidelity: Fidelity, computed: str) -> str:
        """As `ScatteringModel.description`."""
        assert body.mesh is not None
        distance = math.dist(body.middle_at(0.0), scene.antenna(0.0)[0]) - body.radius
        times = facet_enlargement(body, scene.radar, distance)
        coarse = "" if times == 1.0 else f"; facets {times:.1f} times longer than they should be, at most {MAX_FACETS}"
        if not concave_sides(body.mesh).any():
            return f"physical optics, {len(body.mesh.faces)} triangles, none faces another: no bounces, {computed}{coarse}"
        return f"physical optics, up to {fidelity.bounces} bounces, {computed}{coarse}"

    @staticmethod
    def error_db(body: Body, scene: Scene, fidelity: Fidelity, scatterers: int | None) -> float | None:
        """Measured against closed forms: plates, and corners where parts of the mesh face each other."""
        assert body.mesh is not None
        return REBOUNCES_DB if concave_sides(body.mesh).any() else FACETS_DB


def _body_echoes(b: int, centres: PathCentres, over_sea: bool) -> BodyEchoes:
    """The echoes of a path of body b; without sea reflection its only path stands for all."""
    count = len(centres.amplitude)
    path = np.full(count, centres.path if over_sea else ALL_PATHS)
    return BodyEchoes(centres.position, centres.amplitude, np.full(count, b), path, np.zeros(count))
