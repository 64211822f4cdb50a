"""The antenna as it moves while the beam turns: where it is at each azimuth, and what its own way adds to ranges on boresight.

Azimuths are numbered from the start, with fractions between two of them. S is (vx cos b - vy sin b) / Omega, with the velocity
of the antenna, the bearing b of boresight and the rate Omega at which it turns. On a straight course S changes as fast as the
range of what rests on boresight, so R - S hardly changes while the beam passes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radar_service.echo.range_history import apparent_position
from radar_service.kernels.library import KERNELS
from radar_service.numerics import Floats, Indices, ResultCache, effective_earth_radius, wrap_angle
from radar_service.scattering import BearingWedge, RestingPoints
from radar_service.world import Scene

NODES = 5  # instants over a part of the track, through which it is a polynomial: 1e-9 m over 0.1 s of a roll of 8 s
NEWTON_STEPS = (
    2,
    3,
)  # each squares the error of a crossing; where the antenna sways, it leaves 0.5 % of it (10 degrees in 8 s)
BEARING_STEPS = 6  # towards the bearing on the map of a boresight; each leaves 2 % of the error at a roll of 12 degrees
ANTENNAS = 16  # a tile asks for six arrays of its azimuths and rows, up to three times each
BEFORE = 1e-6  # s before the start, when own ship rests


@dataclass(frozen=True)
class BoresightTrack:
    """The antenna of a scene by azimuth number. Before the start own ship moves as at the start."""

    scene: Scene

    @cached_property
    def earth_radius(self) -> float:
        """Effective [m]."""
        return effective_earth_radius(self.scene.environment.earth_factor)

    @property
    def turn_rate(self) -> float:
        """Of boresight [rad/s]."""
        return 2.0 * np.pi / self.scene.radar.rotation_period

    def antenna(self, number: Floats) -> Floats:
        """Positions (K, 3) of the antenna on the map [m] at azimuth numbers (K,), kept for others that need the same."""
        return self._antennas.get(number.tobytes(), lambda: self._antenna(number))

    @cached_property
    def _antennas(self) -> ResultCache[bytes, Floats]:
        return ResultCache(ANTENNAS, self.scene.revision)

    def _antenna(self, number: Floats) -> Floats:
        """Computes `antenna`."""
        time = self.scene.radar.time_of_spokes(number)
        antenna = self.scene.antenna(time)
        early = np.flatnonzero(time < 0.0)
        if len(early):
            before, after = self.scene.own_ship.pose(np.array([-BEFORE, 0.0])).velocity[:, :2]
            antenna[early, :2] += time[early, None] * (after - before)
        return antenna

    def level(self, number: Floats) -> Floats | None:
        """What `Scene.upright_from_map` returns at azimuth numbers (K,)."""
        return self.scene.upright_from_map(self.scene.radar.time_of_spokes(number))

    def bearing(self, number: Floats) -> Floats:
        """Bearings of boresight [rad], not wrapped."""
        return number * self.scene.radar.azimuth_step

    def shift(self, number: Floats) -> Floats:
        """S (K,) [m] at azimuth numbers (K,)."""
        moved = (self.antenna(number + 0.5) - self.antenna(number - 0.5)) / self.scene.radar.spoke_period
        bearing = self.bearing(number)
        return np.asarray((moved[:, 0] * np.cos(bearing) - moved[:, 1] * np.sin(bearing)) / self.turn_rate)

    def is_smooth(self, first: float, last: float) -> bool:
        """Whether own ship moves without a corner from one azimuth number to another, from the start on."""
        time = self.scene.radar.time_of_spokes(np.array([first - 1.0, last + 1.0]))
        return not self.scene.own_ship.corners(np.maximum(time, 0.0)).any()

    def between(self, first: float, last: float) -> "TrackPart":
        """The track from one azimuth number to another."""
        nodes = np.linspace(first, last, NODES)
        level = self.level(nodes)
        swaying = np.zeros((NODES, 0)) if level is None else level.reshape(NODES, 9)
        values = np.column_stack([self.antenna(nodes), self.shift(nodes), swaying])
        powers = np.vander(np.linspace(-1.0, 1.0, NODES), increasing=True)
        return TrackPart(
            self, (first + last) / 2.0, (last - first) / 2.0, np.asarray(np.linalg.solve(powers, values), np.float64)
        )

    def points_on_boresight(self, number: Floats, distance: Floats, height: float) -> Floats:
        """Positions (D, K, 3) on the map [m] of what boresight points at, at azimuth numbers (K,), along the ground `distance`
        (D,) away and `height` above the sea [m]."""
        antenna, level, boresight = self.antenna(number), self.level(number), self.bearing(number)
        bearing, offset = np.tile(boresight, (len(distance), 1)), np.empty((len(distance), len(number), 3))
        offset[..., 2] = height - antenna[:, 2]
        for step in range(1 if level is None else BEARING_STEPS):
            if step and level is not None:
                bearing += wrap_angle(boresight - np.arctan2(*self.apparent(offset, level)))
            offset[..., 0], offset[..., 1] = distance[:, None] * np.sin(bearing), distance[:, None] * np.cos(bearing)
        return offset + antenna

    def apparent(self, offset: Floats, level: Floats | None) -> tuple[Floats, Floats]:
        """East and north (..., K) of positions (..., K, 3) relative to the antenna, as it observes them; level: (K, 3, 3)."""
        if level is None:
            return offset[..., 0], offset[..., 1]
        seen = apparent_position(offset[..., None, :], level, self.earth_radius)
        return seen[..., 0, 0], seen[..., 0, 1]


@dataclass(frozen=True)
class TrackPart:
    """A track within `half` azimuths of the azimuth number `middle`.

    polynomial: (NODES, 4 or 13) coefficients of the antenna's position, S, and the entries of its level where it sways.
    """

    track: BoresightTrack
    middle: float
    half: float
    polynomial: Floats

    @property
    def sways(self) -> bool:
        """Whether the antenna sways."""
        return len(self.polynomial[0]) > 4

    def at(self, number: Floats) -> tuple[Floats, Floats, Floats | None]:
        """Antenna (N, 3) on the map [m], S (N,) [m] and level (N, 3, 3) at azimuth numbers (N,)."""
        u = (number - self.middle) / self.half
        values = np.zeros((self.polynomial.shape[1], len(u)))
        for coefficients in self.polynomial[::-1]:
            values *= u
            values += coefficients[:, None]
        return values[:3].T, values[3], values[4:].T.reshape(-1, 3, 3) if self.sways else None

    def passed(
        self, points: RestingPoints, wedge: BearingWedge, first: float, end: float, beside: float
    ) -> tuple[Indices, Floats, Floats]:
        """Points (N,) in a wedge that face the antenna in the middle, and that boresight passes from azimuth number `first` to
        before `end`; these numbers (N,); cosines (N,) of normals and lines of sight. Within `beside` [m], the middle passes."""
        runs, radar = points.cells.within(wedge), self.track.scene.radar
        room = int(np.sum(runs[1] - runs[0]))
        which, (crossing, cosine) = np.empty(room, dtype=np.int64), np.empty((2, room))
        sizes = len(runs[0]), len(points), room, self.polynomial.shape[1], NEWTON_STEPS[self.sways]
        numbers = self.middle, self.half, float(first), float(end), radar.azimuth_step
        bounds = float(np.cos(wedge.half)) if wedge.half < np.pi else -2.0, wedge.near, beside, self.track.earth_radius
        taken = *runs, points.position, points.normal, points.one_sided, points.lift, self.polynomial
        count = KERNELS.passed_points(*sizes, *numbers, *bounds, *taken, which, crossing, cosine)
        return which[:count], crossing[:count], cosine[:count]
