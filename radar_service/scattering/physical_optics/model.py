"""Physical optics as a scattering model: metal meshes, evaluated body by body when the beam crosses them."""

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from radar_service.block_cache import BlockCache
from radar_service.fidelity import Fidelity
from radar_service.frames import map_from_body
from radar_service.radar.parameters import Radar
from radar_service.scattering.beam_crossing import BeamCrossing
from radar_service.scattering.model import BodyEchoes, Instant, ScatteringContext
from radar_service.scattering.physical_optics.facets import MAX_FACETS
from radar_service.scattering.physical_optics.optical_body import OpticalBody, facet_enlargement, optical_body
from radar_service.scattering.physical_optics.patches import concave_sides
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.scene.body import Body
from radar_service.scene.poses import BodyPose, map_from_bodies, pose_at
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import SurfacePoints
from radar_service.types import Flags, Floats, Indices

FACETS_DB, REBOUNCES_DB = 0.1, 0.4  # plates and corners against their formulas (tests/scattering/physical_optics)


class PhysicalOptics:
    """Bodies (B,) by physical optics with up to `Fidelity.bounces` surfaces in a row."""

    def __init__(
        self, bodies: Sequence[Body], key: Indices, optical: Sequence[OpticalBody], crossing: BeamCrossing | None
    ) -> None:
        """key: (B,) index of each body in the scene; crossing: when the beam crosses bodies; then echoes are those of the
        crossing nearest to the requested instant, else those of the instant itself."""
        self.bodies, self.key = tuple(bodies), key
        self.scatterers: Indices = np.zeros(len(key), dtype=np.int64)
        self._optical, self._crossing = tuple(optical), crossing
        # Two per body: the one in use, and the next one; by body, instant and whether movers may occlude
        self._results: BlockCache[tuple[int, float, bool], BodyEchoes] = BlockCache(2 * max(1, len(key)))

    @classmethod
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        """As `ScatteringModel.build`."""
        optical = [optical_body(body, context.radar, context.fidelity.bounces, context.rays) for body in bodies]
        return cls(bodies, key, optical, context.crossing)

    def echoes(self, launch: Floats, receive: Floats, instant: Instant) -> BodyEchoes:
        """As `ScatteringModel.echoes`."""
        parts = [self._body_echoes(b, launch, receive, instant) for b in self._in_sector(instant)]
        return BodyEchoes(
            np.concatenate([np.zeros((0, 3)), *(part.position for part in parts)]),
            np.concatenate([np.zeros(0, dtype=np.complex128), *(part.amplitude for part in parts)]),
            np.concatenate([np.zeros(0, dtype=np.int64), *(part.body for part in parts)]),
        )

    def clear(self) -> None:
        """Drops the results of all bodies."""
        self._results.clear()

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

    def _body_echoes(self, b: int, launch: Floats, receive: Floats, instant: Instant) -> BodyEchoes:
        """Echoes of body b; kept between calls where the beam's crossing decides the instant and one antenna serves both."""
        body, time = self.bodies[b], instant.time
        if self._crossing is None:
            return self._evaluate(b, launch, receive, time, instant)
        time = self._crossing.instant(body, time)
        moved = self._crossing.antenna_moved(instant.time, time)
        if receive is not launch:
            return self._evaluate(b, launch + moved, receive + moved, time, instant)
        antenna = launch + moved
        return self._results.get((b, time, instant.movers), lambda: self._evaluate(b, antenna, antenna, time, instant))

    def _evaluate(self, b: int, launch: Floats, receive: Floats, time: float, instant: Instant) -> BodyEchoes:
        """Echoes of body b at `time` [s]."""
        body, line_of_sight = self.bodies[b], instant.line_of_sight
        pose = pose_at(body, time)

        def visible_from(end: Floats, points: Floats, triangle: Indices) -> Flags:
            position = map_from_body(points, pose.position, pose.heading)
            surface = SurfacePoints(np.full(len(points), self.key[b]), triangle, position)
            return line_of_sight.visible(surface, end, time, instant.max_range, instant.movers)

        launched = antenna_in_body_frame(body, pose, launch, line_of_sight.earth_radius)
        received = launched if receive is launch else antenna_in_body_frame(body, pose, receive, line_of_sight.earth_radius)
        position, amplitude = self._optical[b].echoes(
            launched,
            received,
            lambda points, triangle: visible_from(launch, points, triangle),
            lambda points, triangle: visible_from(receive, points, triangle),
        )
        return BodyEchoes(position, amplitude, np.full(len(position), b))

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
