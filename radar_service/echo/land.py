"""Land as a ship under way observes it: each point is evaluated once a passage, at the instant at which boresight points at it.

That holds for the points of diffuse surfaces that rest on the map: they neither fluctuate nor have an aspect. A piece is what
boresight passes over PIECE azimuths, whose numbers are the same wherever a run begins. While the beam passes a point that is far
enough, its range follows S (`echo.boresight_track`). Nearer points keep a range history each (`echo.moving`).
"""

from dataclasses import dataclass

import numpy as np

from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.echo.boresight_track import MAX_TURN, BoresightTrack, TrackPart
from radar_service.echo.range_history import apparent_position, elevation_above, elevation_of, slant_range
from radar_service.echo.sea_paths import Paths, range_and_factor
from radar_service.echo.visibility import mast_speed
from radar_service.numerics.frames import Polar, effective_earth_radius
from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.propagation.diffraction import diffraction_height
from radar_service.propagation.radar_equation import received_amplitude, two_way_phase
from radar_service.scattering.fixed_scatterers import DiffuseScattering, cosines
from radar_service.scattering.model import ALL_PATHS, BearingWedge, BodyEchoes
from radar_service.scattering.resting_points import RestingPoints
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.world.scene import Scene

PIECE = 64  # azimuths
NEAREST_BORDER = 150.0  # m
BORDER_WAY = 45.0  # times the way in which boresight turns by 1 rad: bearings change by 1/45 of that at most
GROUND = 2.0  # m above the sea: land whose range changes exactly as S is assumed to, beside what the bearing changes
MAX_HEIGHT_PHASE = 0.04  # rad at the edge of the beam, by which points at other heights may leave that: -38 dB of a point
NEAR_CROSSING = 10.0  # times that way: of anything nearer it is not certain that it is on boresight once a turn
MARGIN = 1.2  # of the width of a piece: by a tenth more bearings change while it passes


@dataclass(frozen=True)
class LandPiece:
    """What boresight passes over the azimuths of a piece.

    row: (E,) azimuths, from the first of the piece on, at which boresight points at each echo.
    distance: (E,) R - S there [m].
    amplitude: (E,) there, with the phase of R - S [sqrt(W)].
    near: the echoes that keep a range history each.
    """

    row: Floats
    distance: Floats
    amplitude: Complexes
    near: ObservedEchoes


class LandPassages:
    """Pieces of land at rest on the map, as the antenna of a scene passes it."""

    def __init__(
        self, scene: Scene, model: DiffuseScattering, line_of_sight: OcclusionScene, max_range: float, points: RestingPoints
    ) -> None:
        """model: of bodies at rest, with its points; max_range: beyond it no echo is received [m]."""
        self._scene, self._model, self._line_of_sight, self._max_range = scene, model, line_of_sight, max_range
        self.points, self.track = points, BoresightTrack(scene)
        self._movers = line_of_sight.has_movers
        self._over_horizon = diffraction_height(scene.radar, scene.environment)
        self._way = (scene.own_ship.top_speed + mast_speed(scene)) / self.track.turn_rate
        self.border = max(NEAREST_BORDER, BORDER_WAY * self._way)
        self._earth_radius = effective_earth_radius(scene.environment.earth_factor)

    def of_scene(self, scene: Scene) -> "LandPassages":
        """Returns the passages in a scene whose rotation has another origin."""
        return LandPassages(scene, self._model, self._line_of_sight, self._max_range, self.points)

    def is_regular(self, first: float, last: float) -> bool:
        """Whether pieces hold from one azimuth number to another: own ship meets no corner, and touches no land."""
        middle = np.array([(first + last) / 2.0])
        reach = NEAR_CROSSING * self._way + (last - first) * self._scene.radar.azimuth_step * self._way
        return self.track.is_smooth(first, last) and not self._within(self.track.antenna(middle)[0], reach)

    def _within(self, antenna: Floats, distance: float) -> bool:
        """Whether any point lies within a distance [m] along the ground of the antenna (3,)."""
        near = self.points.within(BearingWedge(antenna, 0.0, 0.0, distance))
        east, north, _ = (self.points.position[near] - antenna).T
        return bool((east * east + north * north <= distance * distance).any())

    def piece(self, number: int) -> LandPiece:
        """The piece of that number; number 0 begins at azimuth number 0."""
        part = self.track.between(number * PIECE - 1.0, (number + 1) * PIECE + 1.0)
        which, crossing = self._passed(part, number * PIECE)
        which, crossing, amplitude = self._visible(part, which, crossing)
        antenna, shift, level = part.at(crossing)
        offset = self._middles(which) - antenna
        near = self._near(offset, antenna[:, 2])
        far = np.flatnonzero(~near)
        levels = None if level is None else level[far]
        distance, factor = self._received(which[far], offset[far], antenna[far, 2], levels)
        distance -= shift[far]
        return LandPiece(
            crossing[far] - number * PIECE,
            distance,
            amplitude[far] * factor * two_way_phase(distance, self._scene.radar.wavelength),
            self._observed(which[near], amplitude[near]),
        )

    def _passed(self, part: TrackPart, first: int) -> tuple[Indices, Floats]:
        """Points (N,) that boresight passes over the azimuths of a piece, and at which azimuth numbers (N,)."""
        (antenna,), _, _ = part.at(np.array([part.middle]))
        step, sway = self._scene.radar.azimuth_step, self._scene.own_ship.sway
        half = MARGIN * PIECE / 2.0 * step + (0.0 if sway is None else sway.max_tilt)
        way = self._way * PIECE * step
        which = self.points.within(BearingWedge(antenna, float(self.track.bearing(np.array(part.middle))), half, way / MAX_TURN))
        crossing = part.crossings(self._middles(which))
        passed = np.flatnonzero((crossing >= first) & (crossing < first + PIECE))
        return which[passed], crossing[passed]

    def _visible(self, part: TrackPart, which: Indices, crossing: Floats) -> tuple[Indices, Floats, Complexes]:
        """Those of points (N,) that the antenna observes in the middle of a piece, their azimuth numbers, and their amplitudes as
        roots of cross-sections [m]."""
        (antenna,), _, _ = part.at(np.array([part.middle]))
        points, time = self.points, float(self._scene.radar.time_of_spokes(part.middle))
        position = points.position.take(which, axis=0)
        cosine = cosines(position, points.normal.take(which, axis=0), antenna, self._earth_radius)
        cosine = np.where(points.one_sided[which], cosine, np.abs(cosine))
        facing = np.flatnonzero(cosine > 0.0)
        seen = SurfacePoints(
            self._model.key[points.body[which[facing]]], points.triangle[which[facing]], position.take(facing, axis=0)
        )
        visible = facing[
            self._line_of_sight.visible(
                seen, antenna, time, self._max_range, self._movers, over_horizon=self._over_horizon
            )
        ]
        return which[visible], crossing[visible], points.strength[which[visible]] * np.sqrt(cosine[visible])

    def _middles(self, which: Indices) -> Floats:
        """Positions (N, 3) on the map [m] of the middles of what points `which` stand for."""
        position = self.points.position.take(which, axis=0)
        position[:, 2] += self.points.lift[which]
        return position

    def _near(self, offset: Floats, antenna_height: Floats) -> Indices:
        """Flags (N,) of echoes at offsets (N, 3) from the antenna [m] that are near, or too high or low for their distance."""
        distance2 = offset[:, 0] ** 2 + offset[:, 1] ** 2
        slant = np.abs(offset[:, 2] ** 2 - (antenna_height - GROUND) ** 2)
        radar = self._scene.radar
        phase = np.pi / radar.wavelength * self._way * radar.beamwidth * slant  # 2 k (1 - cos(elevation)) way at half a beam
        return np.asarray((distance2 < self.border**2) | (phase > MAX_HEIGHT_PHASE * distance2))

    def _received(
        self, which: Indices, offset: Floats, antenna_height: Floats, level: Floats | None
    ) -> tuple[Floats, Complexes]:
        """Ranges (N,) [m] of points at offsets (N, 3) [m], and by what their amplitudes are received."""
        radar, distance = self._scene.radar, slant_range(offset, self._earth_radius)
        elevation, tilt_error = elevation_above(offset, self._earth_radius), 0.0
        if level is not None:
            tilt_error = elevation_of(apparent_position(offset[:, None], level, self._earth_radius)[:, 0]) - elevation
        polar = Polar(distance, elevation, elevation, np.hypot(offset[:, 0], offset[:, 1]))
        paths = Paths(np.full(len(which), ALL_PATHS), self.points.span[which].astype(np.float64))
        height = offset[:, 2] + antenna_height
        _, factor = range_and_factor(radar, self._scene.environment, polar, height, antenna_height, paths, tilt_error)
        return distance, received_amplitude(radar, distance) * factor

    def _observed(self, which: Indices, amplitude: Complexes) -> ObservedEchoes:
        """Points `which` (N,) as echoes, of bodies that rest on the map."""
        position, path = self._middles(which), np.full(len(which), ALL_PATHS)
        span = self.points.span[which].astype(np.float64)
        return ObservedEchoes(BodyEchoes(position, amplitude, self.points.body[which].astype(np.int64), path, span), position)


def joined(parts: list[ObservedEchoes]) -> ObservedEchoes:
    """The echoes of several pieces."""
    echoes = BodyEchoes.joined([part.echoes for part in parts])
    return ObservedEchoes(echoes, echoes.position)
