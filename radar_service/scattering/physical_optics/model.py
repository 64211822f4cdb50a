"""Physical optics as a scattering model: metal meshes, evaluated body by body when the beam crosses them."""

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from radar_service.fidelity import Fidelity
from radar_service.frames import map_from_body
from radar_service.radar.parameters import Radar
from radar_service.scattering.model import BodyEchoes, Instant, ScatteringContext
from radar_service.scattering.physical_optics.facets import MAX_FACETS
from radar_service.scattering.physical_optics.optical_body import OpticalBody, facet_enlargement
from radar_service.scattering.physical_optics.patches import concave_sides
from radar_service.scattering.physical_optics.shared_bodies import optical_bodies
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.scene.body import Body
from radar_service.scene.poses import BodyPose, map_from_bodies, pose_at
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import SurfacePoints
from radar_service.types import Flags, Floats, Indices

FACETS_DB, REBOUNCES_DB = 0.1, 0.4  # plates and corners against their formulas (tests/scattering/physical_optics)


class PhysicalOptics:
    """Bodies (B,) by physical optics with up to `Fidelity.bounces` surfaces in a row."""

    def __init__(self, bodies: Sequence[Body], key: Indices, optical: Sequence[OpticalBody]) -> None:
        """key: (B,) index of each body in the scene."""
        self.bodies, self.key = tuple(bodies), key
        self.scatterers: Indices = np.zeros(len(key), dtype=np.int64)
        self._optical = tuple(optical)

    @classmethod
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        """As `ScatteringModel.build`."""
        return cls(bodies, key, optical_bodies(bodies, context.radar, context.fidelity.bounces, context.rays))

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
        body, line_of_sight, time = self.bodies[b], instant.line_of_sight, instant.time
        pose = pose_at(body, time)

        def visible(points: Floats, triangle: Indices) -> Flags:
            position = map_from_body(points, pose.position, pose.heading)
            surface = SurfacePoints(np.full(len(points), self.key[b]), triangle, position)
            return line_of_sight.visible(surface, antenna, time, instant.max_range, instant.movers)

        local = antenna_in_body_frame(body, pose, antenna, line_of_sight.earth_radius)
        position, amplitude = self._optical[b].echoes(local, local, visible, visible)
        return BodyEchoes.of_points(position, amplitude, np.full(len(position), b))

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


def antenna_in_body_frame(body: Body, pose: BodyPose, antenna: Floats, earth_radius: float) -> Floats:
    """The antenna (3,) in a body's own frame [m], raised by the earth's drop in between.

    Ranges in that frame are then those of the antenna's frame (docs/conventions.md).
    """
    local = pose.frame_from_map(antenna, np.inf)
    east, north, _ = local - body.middle
    local[2] += (east**2 + north**2) / (2.0 * earth_radius)
    return local
