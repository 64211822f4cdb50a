"""Land as a ship under way observes it: each point is evaluated once a passage, at the instant at which boresight points at it.

That holds for points of diffuse surfaces that rest on the map. A piece is what boresight passes over PIECE azimuths, numbered
alike wherever a run begins. While the beam passes a point that is far enough, its range follows S (`echo.boresight_track`).
Nearer points, and those beside own ship, keep a range history each (`echo.moving`).
"""

import math
from dataclasses import dataclass

import numpy as np

from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.boresight_track import BoresightTrack, TrackPart
from radar_service.echo.range_history import apparent_position, elevation_above, elevation_of, slant_range
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.echo.visibility import mast_speed
from radar_service.numerics import Complexes, Flags, Floats, Indices, Polar, effective_earth_radius
from radar_service.propagation import LandBefore, diffraction_height, local_attenuation, received_amplitude, two_way_phase
from radar_service.scattering import ALL_PATHS, BearingWedge, BodyEchoes, RestingPoints
from radar_service.trace import OcclusionScene, SurfacePoints
from radar_service.world import Scene, SightLines

PIECE = 64  # azimuths
NEAREST_BORDER = 150.0  # m
BORDER_WAY = 45.0  # times the way in which boresight turns by 1 rad: bearings change by 1/45 of that at most
GROUND = 2.0  # m above the sea: land whose range changes exactly as S is assumed to, beside what the bearing changes
MAX_HEIGHT_PHASE = 0.04  # rad at half a beamwidth off boresight, by which points at other heights may leave that: -38 dB
LOW, MAX_LOW_PHASE = 3.0, 0.014  # m, rad: what land of that height may change of its way by the sea, -38 dB of its F^2
NEAR_CROSSING = 10.0  # times that way: what is nearer is beside own ship: boresight may meet it twice a turn, or never
WIDE, MARGIN = 2.5, 1.12  # times `reach`, beyond which bearings change by 4 % at most while a piece, this wide, passes


@dataclass(frozen=True)
class LandPiece:
    """What boresight passes over the azimuths of a piece.

    row: (E,) azimuths, from the first of the piece on, at which boresight points at each echo.
    distance: (E,) R - S there [m].
    amplitude: (E,) there, with the phase of R - S [sqrt(W)].
    near: the echoes that keep a range history each, also those beside own ship, of all pieces about them.
    near_points: (N,) which points these are.
    """

    row: Floats
    distance: Floats
    amplitude: Complexes
    near: ObservedEchoes
    near_points: Indices


class LandPassages:
    """Pieces of land at rest on the map, as the antenna of a scene passes it."""

    def __init__(
        self, scene: Scene, key: Indices, line_of_sight: OcclusionScene, max_range: float, points: RestingPoints
    ) -> None:
        """key: (B,) index in the scene of each body that `points` name; max_range: beyond it no echo is received [m].

        top_way: of the antenna while boresight turns by 1 rad, at its highest speed [m]; least_border: of any piece [m].
        """
        self._scene, self._key, self._line_of_sight, self._max_range = scene, key, line_of_sight, max_range
        self.points, self.track = points, BoresightTrack(scene)
        self._movers = line_of_sight.has_movers
        self._over_horizon = diffraction_height(scene.radar, scene.environment)
        self.top_way = (scene.own_ship.top_speed + mast_speed(scene)) / self.track.turn_rate
        self.least_border = NEAREST_BORDER
        self._sea_slant = 2.0 * scene.radar.height if scene.environment.multipath else 0.0  # see `_phase_change`
        self._earth_radius = effective_earth_radius(scene.environment.earth_factor)

    def way_at(self, number: float) -> float:
        """How far the antenna moves over the ground while boresight turns by 1 rad [m], as fast as at an azimuth number."""
        before, after = self.track.antenna(np.array([number - 0.5, number + 0.5]))[:, :2]
        return float(np.hypot(*(after - before))) / self._scene.radar.azimuth_step

    def border(self, way: float) -> float:
        """Distance [m] from which on points have no range history, by `way_at` [m]."""
        low = float(self._phase_change(way, self._sea_slant * LOW)) / MAX_LOW_PHASE
        return max(self.least_border, BORDER_WAY * way, math.sqrt(low))

    def piece(self, number: int) -> LandPiece:
        """The piece of that number; number 0 begins at azimuth number 0."""
        first, end = number * PIECE, (number + 1) * PIECE
        part = self.track.between(first - 1.0, end + 1.0)
        antenna, way = part.polynomial[0, :3], self.way_at(part.middle)
        reach = way * (NEAR_CROSSING + (end - first + 2) * self._scene.radar.azimuth_step)
        sway, turn = self._scene.own_ship.sway, PIECE * self._scene.radar.azimuth_step
        half = MARGIN * turn / 2.0 + (0.0 if sway is None else sway.max_tilt)
        wedge = BearingWedge(antenna, float(self.track.bearing(np.array(part.middle))), half, WIDE * reach)
        which, crossing, cosine = part.passed(self.points, wedge, first, end, reach)
        seen = self._visible(which, antenna, float(self._scene.radar.time_of_spokes(part.middle)))
        which = which[seen]
        amplitude = np.asarray(self.points.strength[which] * np.sqrt(cosine[seen]), dtype=np.complex128)
        return self._evaluated(part, way, first, which, crossing[seen], amplitude)

    def _evaluated(
        self, part: TrackPart, way: float, first: int, which: Indices, crossing: Floats, amplitude: Complexes
    ) -> LandPiece:
        """The piece from azimuth number `first` on, of visible points (N,) with roots of cross-sections `amplitude` (N,) [m]."""
        antenna, shift, level = part.at(crossing)
        offset = self._middles(which) - antenna
        near = self._near(offset, antenna[:, 2], way)
        far = np.flatnonzero(~near) if near.any() else slice(None)
        levels = None if level is None else level[far]
        distance, received = self._received(which[far], offset[far], antenna[far], levels)
        if self._scene.environment.attenuators:
            time = self._scene.radar.time_of_spokes(crossing[far])
            lines = SightLines(antenna[far], time, np.arctan2(offset[far, 0], offset[far, 1]), distance)
            received = received * local_attenuation(self._scene.radar, self._scene.environment, lines)
        distance -= shift[far]
        phase = two_way_phase(distance, self._scene.radar.wavelength)
        observed = self._observed(which[near], amplitude[near])
        return LandPiece(crossing[far] - first, distance, amplitude[far] * received * phase, observed, which[near])

    def _visible(self, which: Indices, antenna: Floats, time: float) -> Indices:
        """Indices of those of points `which` (N,) that the antenna (3,) has a line of sight to at `time` [s]."""
        points, body = self.points, self._key[self.points.body[which]]
        triangle = points.triangle[which].astype(np.int64)
        seen = SurfacePoints(body, triangle, points.position.take(which, axis=0))
        visible = self._line_of_sight.visible(
            seen, antenna, time, self._max_range, self._movers, over_horizon=self._over_horizon
        )
        return np.flatnonzero(visible)

    def _middles(self, which: Indices) -> Floats:
        """Positions (N, 3) on the map [m] of the middles of what points `which` stand for."""
        position = self.points.position.take(which, axis=0)
        position[:, 2] += self.points.lift[which]
        return position

    def _near(self, offset: Floats, antenna_height: Floats, way: float) -> Flags:
        """Which echoes at offsets (N, 3) from the antenna [m] are near, or too high or low for their distance."""
        distance2 = offset[:, 0] ** 2 + offset[:, 1] ** 2
        slant = np.abs(offset[:, 2] ** 2 - (antenna_height - GROUND) ** 2)
        by_sea = self._sea_slant * np.maximum(offset[:, 2] + antenna_height, 0.0)
        phase = self._phase_change(way, np.maximum(slant, by_sea))
        return np.asarray((distance2 < self.border(way) ** 2) | (phase > MAX_HEIGHT_PHASE * distance2))

    def _phase_change(self, way: float, slant: Floats | float) -> Floats:
        """Phase [rad], times the square of the distance [m], that gathers up to half a beamwidth off boresight between two ranges
        of which one is slant / (2 R) longer [m]: by other heights, or by the sea, 2 h1 h2 / R."""
        radar = self._scene.radar
        return np.asarray(np.pi / radar.wavelength * way * radar.beamwidth * slant)

    def _received(self, which: Indices, offset: Floats, antenna: Floats, level: Floats | None) -> tuple[Floats, Complexes]:
        """Ranges (N,) [m] of points at offsets (N, 3) from antennas (N, 3) [m], and by what their amplitudes are received."""
        radar, distance = self._scene.radar, slant_range(offset, self._earth_radius)
        elevation = elevation_above(offset, self._earth_radius)
        tilt_error: Floats | float = 0.0
        if level is not None:
            tilt_error = elevation_of(apparent_position(offset[:, None], level, self._earth_radius)[:, 0]) - elevation
        polar = Polar(distance, elevation, elevation, np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2))
        paths = Paths(np.full(len(which), ALL_PATHS), self.points.span[which].astype(np.float64))
        height = offset[:, 2] + antenna[:, 2]
        land = LandBefore(self._line_of_sight, antenna, offset, self._key[self.points.body[which]])
        _, factor = range_and_factor(radar, self._scene.environment, polar, height, antenna[:, 2], paths, tilt_error, land)
        return distance, received_amplitude(radar, distance) * factor

    def _observed(self, which: Indices, amplitude: Complexes) -> ObservedEchoes:
        """Points `which` (N,) as echoes, of bodies that rest on the map."""
        position, path = self._middles(which), np.full(len(which), ALL_PATHS)
        span = self.points.span[which].astype(np.float64)
        return ObservedEchoes(
            BodyEchoes(position, amplitude, self.points.body[which].astype(np.int64), path, span), position
        )


def joined(parts: list[ObservedEchoes], points: list[Indices]) -> ObservedEchoes:
    """The echoes of consecutive pieces; each point, which `points` (N,) name, once: as in the piece nearest to the middle."""
    echoes = BodyEchoes.joined([part.echoes for part in parts])
    piece = np.repeat(np.arange(len(parts)), [len(part) for part in points])
    order = np.argsort(np.abs(piece - (len(parts) - 1) / 2.0), kind="stable")
    _, first = np.unique(np.concatenate(points)[order], return_index=True)
    if len(first) < len(order):
        echoes = echoes.chosen(np.sort(order[first]))
    return ObservedEchoes(echoes, echoes.position)
