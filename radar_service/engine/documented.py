"""The specification exactly as printed: rays, hits, chirps, matched filter, Gaussian. It is the base line of every chart.

Its amplitudes are relative, as eq. 8 has no transmitter, and its errors are kept (docs/specification.md#errata). It adds only
what the specification does not define. Bearings run as everywhere in the project (row 8). Radar and bodies have their poses
at the time of each spoke. The ground plane moves with own ship. Bodies may be points.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from radar_service.numerics import (
    BLAS_LIMIT,
    RAYS,
    Flags,
    Floats,
    Indices,
    Profiles,
    Singles,
    direction,
    effective_earth_radius,
    generator,
    polar_from_map,
    wrap_angle,
)
from radar_service.propagation import printed_atmosphere, printed_two_ray_factor, rms_wave_height
from radar_service.radar import printed_two_way
from radar_service.receive import (
    beam_spread,
    chirp,
    chirp_sum,
    compress,
    detect,
    printed_phase,
    pulse_times,
    sample_delay,
    window,
)
from radar_service.records import Fidelity
from radar_service.trace import BOX_BEAMWIDTHS, TriangleList, TriangleScene, azimuth_offsets, elevation_offsets
from radar_service.world import BodyPoses, Motion, Presence, Presences, Scene

TRACERS: dict[str, type[TriangleScene] | type[TriangleList]] = {"embree": TriangleScene, "moller_trumbore": TriangleList}
ON_SURFACE = 1e-9  # of the range: a surface does not occlude a point that lies on it


@dataclass(frozen=True)
class AzimuthHits:
    """Hits (H,) of the rays of one azimuth: slant range and height above the sea [m], offsets from boresight [rad]."""

    range: Floats
    azimuth: Floats
    elevation: Floats
    height: Floats


@dataclass(frozen=True)
class Solid:
    """A body's triangles, their position (3,) on the map [m] and rotation (3, 3) map_from_body."""

    triangles: TriangleScene | TriangleList
    position: Floats
    rotation: Floats


@dataclass(frozen=True)
class Traced:
    """Triangles in their own frame, ready for rays, their motion and their presence."""

    triangles: TriangleScene | TriangleList
    motion: Motion
    presence: Presence


class DocumentedEngine:
    """The documented fidelity of a scene. Azimuths are independent of each other and may be computed in any order."""

    def __init__(self, scene: Scene, fidelity: Fidelity, seed: int) -> None:
        """Prepares every body for tracing, in its own frame, once. Raises KeyError for an unknown fidelity.tracer."""
        tracer = TRACERS[fidelity.tracer]
        radar = scene.radar
        self._scene, self._seed = scene, seed
        # As printed: sample n stands at n c / (2 fs), where all else in the project has the middle of its cell.
        self.range: Floats = np.arange(radar.bins, dtype=np.float64) * radar.range_step
        solids = [(body, body.mesh) for body in scene.bodies if body.mesh is not None]
        self._traced = [Traced(tracer(m.vertices, m.faces), body.motion, body.presence) for body, m in solids]
        if scene.environment.ground_plane:
            self._traced.append(Traced(tracer(*ground_plane(2.0 * radar.range_max)), scene.own_ship, Presence.always))
        points = [body for body in scene.bodies if body.mesh is None]
        self._poses, self._point_poses = BodyPoses(self._traced), BodyPoses(points)
        self._presences, self._point_presences = Presences(self._traced), Presences(points)
        self._transmitted = chirp(pulse_times(radar.pulse, radar.sample_rate), radar.bandwidth, radar.pulse)
        self._window = window(radar.window, self._transmitted.size)

    def tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles]]:
        """One revolution in one piece, as eq. 19 needs all of it: index 0 of its first azimuth, field and power.

        requested: ignored, for the same reason.
        """
        yield 0, *self.scan(scan)

    def scan(self, number: int) -> tuple[Profiles, Singles]:
        """Field (A, N) before detection and power (A, N) after eqs. 18 and 19 of the scan of that number, 0 the first."""
        radar = self._scene.radar
        field = np.empty((radar.azimuths, radar.bins), dtype=np.complex64)
        for index in range(radar.azimuths):
            field[index] = self.azimuth_field(number, index)
        power = beam_spread(detect(field), radar.beamwidth, radar.azimuth_step)  # eqs. 18, 19
        return field, power.astype(np.float32)

    @BLAS_LIMIT.held()
    def azimuth_field(self, scan: int, index: int) -> Profiles:
        """Compressed field (N,) of one azimuth, relative amplitude: eqs. 4 to 15."""
        radar = self._scene.radar
        time = radar.time_of_spokes(float(scan * radar.azimuths + index))
        boresight = index * radar.azimuth_step
        if self._scene.blind(np.array([time]), np.array([boresight]))[0]:
            return np.zeros(radar.bins, dtype=np.complex64)
        hits = self._hits(boresight, time, generator(self._seed, RAYS, scan, index))
        if not hits.range.size:
            return np.zeros(radar.bins, dtype=np.complex64)
        delay = sample_delay(hits.range, radar.sample_rate)
        phase = printed_phase(hits.range, radar.wavelength)
        received = chirp_sum(delay, self.amplitude(hits), phase, self._transmitted, radar.bins)
        if radar.eclipsing:
            received[: self._transmitted.size] = 0.0
        return compress(received, self._transmitted, self._window, radar.bins).astype(np.complex64)

    def amplitude(self, hits: AzimuthHits) -> Floats:
        """Amplitude (H,) of each hit, relative; declared cross-sections do not enter. Source:
        docs/specification.md eq. 8."""
        radar, environment = self._scene.radar, self._scene.environment
        gain = printed_two_way(hits.azimuth, hits.elevation, radar.beamwidth, radar.beamwidth_el)
        loss = printed_atmosphere(hits.range, environment.gas_db_per_km)
        return gain / (hits.range**2 + 1.0) * loss * self._multipath(hits)  # eq. 8

    def _multipath(self, hits: AzimuthHits) -> Floats | float:
        radar, environment = self._scene.radar, self._scene.environment
        if not environment.multipath:
            return 1.0
        level = np.sqrt(np.maximum(hits.range**2 - (hits.height - radar.height) ** 2, 0.0))
        factor = printed_two_ray_factor(
            level,
            hits.height,
            radar.height,
            radar.wavelength,
            earth_radius=effective_earth_radius(environment.earth_factor),
            polarization=radar.polarization,
            wave_height=rms_wave_height(environment.sea_state),
        )
        return np.abs(factor) ** 2

    def _hits(self, boresight: float, time: float, random: np.random.Generator) -> AzimuthHits:
        """Hits of the rays of one azimuth [rad] at `time` [s]; each visible point body adds one."""
        radar = self._scene.radar
        antenna = self._scene.antenna(time)[0]
        solids = self._in_sector(boresight, antenna, time)
        azimuth = azimuth_offsets(random, radar.rays, radar.beamwidth)
        elevation = elevation_offsets(random, radar.rays, radar.beamwidth_el)
        distance = nearest(solids, antenna, direction(boresight + azimuth, elevation + radar.tilt))
        points = self._point_hits(boresight, antenna, time, solids)
        azimuth, elevation = np.append(azimuth, points.azimuth), np.append(elevation, points.elevation)
        distance = np.append(distance, points.range)
        met = distance < radar.range_max
        height = antenna[2] + distance[met] * np.sin(elevation[met] + radar.tilt)
        return AzimuthHits(distance[met], azimuth[met], elevation[met], height)

    def _in_sector(self, boresight: float, antenna: Floats, time: float) -> list[Solid]:
        """The bodies whose bounding sphere reaches into the rays of this azimuth."""
        if not self._traced:
            return []
        radar = self._scene.radar
        poses, triangles = self._poses.each_at(time), [traced.triangles for traced in self._traced]
        rotations = [pose.matrix for pose in poses]
        position = np.array([pose.position for pose in poses])
        centre = position + np.array([r @ t.centre for r, t in zip(rotations, triangles, strict=True)])
        radius = np.array([t.radius for t in triangles])
        polar = polar_from_map(centre, antenna, np.inf)
        half = np.arcsin(np.minimum(radius / np.maximum(polar.distance, radius), 1.0))
        off = np.abs(wrap_angle(polar.azimuth - boresight))
        inside = (polar.distance <= radius) | (off <= BOX_BEAMWIDTHS * radar.beamwidth + half)
        chosen = np.flatnonzero(inside & (polar.range - radius < radar.range_max) & self._presences.at(time))
        return [Solid(triangles[k], position[k], rotations[k]) for k in chosen]

    def _point_hits(self, boresight: float, antenna: Floats, time: float, solids: list[Solid]) -> AzimuthHits:
        """Points within 1.5 beamwidths both ways that no surface occludes, as hits."""
        radar = self._scene.radar
        positions = self._point_poses.at(np.array([time])).position[0]
        polar = polar_from_map(positions, antenna, np.inf)
        azimuth = wrap_angle(polar.azimuth - boresight)
        elevation = polar.elevation - radar.tilt
        inside = (np.abs(azimuth) <= BOX_BEAMWIDTHS * radar.beamwidth) & (
            np.abs(elevation) <= BOX_BEAMWIDTHS * radar.beamwidth_el
        )
        chosen = np.flatnonzero(inside & self._point_presences.at(time))
        first_hit = nearest(solids, antenna, direction(polar.azimuth[chosen], polar.elevation[chosen]))
        visible = chosen[first_hit >= polar.range[chosen] * (1.0 - ON_SURFACE)]
        return AzimuthHits(polar.range[visible], azimuth[visible], elevation[visible], positions[visible, 2])


def ground_plane(reach: float) -> tuple[Floats, Indices]:
    """The plane z = 0 out to `reach` [m] each way, as vertices (4, 3) and two triangles (2, 3). Source:
    docs/specification.md#ground-plane."""
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]) * reach
    return corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int64)


def nearest(solids: list[Solid], antenna: Floats, rays: Floats) -> Floats:
    """Distance (M,) [m] to the nearest surface along each unit ray (M, 3), inf where there is none, decided in float64."""
    distance = np.full(len(rays), np.inf)
    for solid in solids:
        origin, local = (antenna - solid.position) @ solid.rotation, rays @ solid.rotation
        triangle = solid.triangles.first_hit(origin, local)
        hit = np.flatnonzero(triangle >= 0)
        along = solid.triangles.hit_distance(triangle[hit], origin, local[hit])
        distance[hit] = np.minimum(distance[hit], np.where(along > 0, along, np.inf))
    return distance
