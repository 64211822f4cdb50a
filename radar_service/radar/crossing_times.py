"""When the boresight crosses points that move about the antenna.

The boresight turns evenly, so a crossing is a root of boresight - bearing, modulo a full circle. A scan is searched in steps,
and each root is refined within its step. A point that stays more than NEAR of its own steps away turns by less than the
boresight does, so few steps are enough; any other point is searched from spoke to spoke.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Flags, Floats, Indices, wrap_angle

FULL_CIRCLE = 2.0 * np.pi
STEPS = 8  # of a scan, for points that are not near, where the antenna does not sway
NEAR = 4.0  # steps: from there a step turns the bearing by at most asin(1 / 3), half of what the boresight turns
SNAP = 1e-12  # rad: rounding of a bearing; a point this close to the boresight at the edge of a step is crossed there
ROUNDING = 1e-15  # of a bearing [rad] and of a share of a turn: closer is not possible
ITERATIONS = 60  # at most: a point at rest takes one

Offsets = Callable[[Indices, Floats], Floats]  # east and north (E, 2) [m] from the antenna of points (E,) at times (E,) [s]


class Crossings(NamedTuple):
    """point: index (E,) of the crossed point; time: (E,) [s], rising; scan: (E,) of each."""

    point: Indices
    time: Floats
    scan: Indices


class CrossingSearch:
    """Finds crossings.

    offsets: of the points, as the antenna observes them; count: number of points; period: of the rotation [s]; spokes:
    in a scan; steps: of a scan, for points that are not near.
    """

    def __init__(self, offsets: Offsets, count: int, period: float, spokes: int, steps: int = STEPS) -> None:
        self.offsets, self._points, self._spokes, self._steps = offsets, np.arange(count), spokes, steps
        self._period = period

    def within(self, scan: int, count: int = 1) -> Crossings:
        """Returns the crossings of so many scans; each begins with the boresight to the north, and its end is the next one's."""
        points, scans = np.tile(self._points, count), np.repeat(np.arange(scan, scan + count), len(self._points))
        track = self._tracks(points, scans, self._steps)
        near = _are_near(track)
        parts = [self._crossed_in(points[~near], scans[~near], track[~near])]
        if near.any():
            track = self._tracks(points[near], scans[near], self._spokes)
            parts.append(self._crossed_in(points[near], scans[near], track))
        joined = Crossings._make(np.concatenate(column) for column in zip(*parts, strict=True))
        order = np.lexsort((joined.point, joined.time, joined.scan))
        return Crossings._make(column[order] for column in joined)

    def _tracks(self, points: Indices, scan: Indices, steps: int) -> Floats:
        """Offsets (P, steps + 1, 2) [m] of points (P,) at the edges of the steps of a scan (P,)."""
        time = self._time(scan[:, None] + np.arange(steps + 1) / steps)
        flat = self.offsets(np.repeat(points, steps + 1), time.ravel())
        return flat.reshape(len(points), steps + 1, 2)

    def _crossed_in(self, points: Indices, scan: Indices, track: Floats) -> Crossings:
        """Crossings of points (P,) in scans (P,). track: their offsets (P, T, 2) [m], in steps of less than half a circle."""
        steps = track.shape[1] - 1
        share = np.arange(steps + 1) / steps
        bearing = np.arctan2(track[..., 0], track[..., 1])
        ahead = wrap_angle(FULL_CIRCLE * share - bearing)
        ahead[np.abs(ahead) < SNAP] = 0.0
        advance = FULL_CIRCLE / steps - wrap_angle(np.diff(bearing, axis=1))
        begin, end = ahead[:, :-1], ahead[:, 1:]
        end = end + FULL_CIRCLE * np.rint((begin + advance - end) / FULL_CIRCLE)
        which, step = np.nonzero(np.ceil(begin / FULL_CIRCLE) != np.ceil(end / FULL_CIRCLE))
        low, high = begin[which, step], end[which, step]
        turn = FULL_CIRCLE * np.minimum(np.ceil(low / FULL_CIRCLE), np.ceil(high / FULL_CIRCLE))
        root = self._root(points[which], scan[which], share[step], share[step + 1], low - turn, high - turn)
        return Crossings(points[which], self._time(scan[which] + root), scan[which])

    def _root(self, points: Indices, scan: Indices, a: Floats, b: Floats, at_a: Floats, at_b: Floats) -> Floats:
        """The share (E,) of the turn at which the boresight meets points (E,), between a and b (E,); Illinois method.

        at_a, at_b: how far the boresight is ahead there [rad], of different signs.
        """
        a, b, at_a, at_b = a.copy(), b.copy(), at_a.copy(), at_b.copy()
        root = np.where(at_a == 0.0, a, b)
        left = np.flatnonzero((at_a != 0.0) & (at_b != 0.0))
        for _ in range(ITERATIONS):
            if not len(left):
                break
            fa, fb = at_a[left], at_b[left]
            middle = (a[left] * fb - b[left] * fa) / (fb - fa)
            value = self._ahead(points[left], scan[left], middle)
            root[left] = middle
            crossed = np.sign(value) == np.sign(fb)
            a[left] = np.where(crossed, a[left], b[left])
            at_a[left] = np.where(crossed, fa / 2.0, fb)
            b[left], at_b[left] = middle, value
            left = left[(np.abs(value) > ROUNDING) & (np.abs(b[left] - a[left]) > ROUNDING)]
        return root

    def _ahead(self, points: Indices, scan: Indices, share: Floats) -> Floats:
        """How far the boresight is ahead of points (E,) after shares (E,) of a turn [rad]."""
        offset = self.offsets(points, self._time(scan + share))
        return wrap_angle(FULL_CIRCLE * share - np.arctan2(offset[:, 0], offset[:, 1]))

    def _time(self, turns: Floats) -> Floats:
        """Times (E,) [s] after turns (E,) since the start of the simulation."""
        return turns * self._period


def _are_near(track: Floats) -> Flags:
    """Which points come within NEAR of their own steps of the antenna. track: (P, T, 2) [m]."""
    step = np.linalg.norm(np.diff(track, axis=1), axis=2).max(axis=1)
    return np.asarray(np.linalg.norm(track, axis=2).min(axis=1) <= NEAR * step)
