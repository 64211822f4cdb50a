"""Range histories: range and azimuth of moving echoes over a few consecutive azimuths, without evaluating each one at each.

Between the first azimuth and the last one, range and azimuth are parabolas through three instants: the first, the middle and
the last. A straight track that is s [m] long from the middle to either end, at range R, leaves its parabola by at most
0.074 s^3 / R^2. Echoes too near for that, and bodies that do not move smoothly, are computed at each azimuth.
"""

from typing import NamedTuple

import numpy as np

from radar_service.numerics import Flags, Floats, Indices, Singles, wrap_angle

PARABOLA_ERROR = 0.074  # see above
TOLERANCE = 5e-6  # m off the parabola: 2 mrad of two-way phase at 9.41 GHz, -54 dB
MAX_AZIMUTH_CHANGE = 0.05  # rad from the middle to either end: the series of the arc tangent errs by 6e-8 rad


class Parabola(NamedTuple):
    """Interpolation from three instants to K: nodes (3,) [s]; weights first and last (K,) of changes since the middle; both
    weights (2, K) in single precision; separate: whether each echo has the bytes that it has alone."""

    nodes: Floats
    first: Floats
    last: Floats
    weights: Singles
    separate: bool = False

    def change(self, first: Floats, last: Floats) -> Singles:
        """Change (E, K) since the middle of what changes by `first` and `last` (E,) at the outer nodes."""
        ends = np.empty((len(first), 2), dtype=np.float32)
        ends[:, 0], ends[:, 1] = first, last
        change: Singles = (ends[:, None] @ self.weights)[:, 0] if self.separate else ends @ self.weights
        return change


def parabola(time: Floats, separate: bool = False) -> Parabola:
    """The parabola over evenly spaced times (K,) [s]; separate: as of a Parabola."""
    middle, half = (time[0] + time[-1]) / 2.0, (time[-1] - time[0]) / 2.0
    u = (time - middle) / half if half > 0.0 else np.zeros(len(time))
    first, last = u * (u - 1.0) / 2.0, u * (u + 1.0) / 2.0
    weights = np.array([first, last], dtype=np.float32)
    return Parabola(np.array([middle - half, middle, middle + half]), first, last, weights, separate)


def interpolation_error(values: Floats, nodes: Floats, over: Parabola) -> Floats:
    """Greatest distance (...) between values (K, ..., N) and the parabola through their `nodes` (3, ..., N)."""
    weights = (weight.reshape(-1, *[1] * (values.ndim - 1)) for weight in (over.first, over.last))
    first, last = weights
    fitted = nodes[1] + first * (nodes[0] - nodes[1]) + last * (nodes[2] - nodes[1])
    return np.asarray(np.abs(values - fitted).max(axis=(0, -1), initial=0.0))


class RangeHistory(NamedTuple):
    """Echoes (E,) over K azimuths: range (E,) at the middle [m]; changes since, (E, K), of range [m] and azimuth [rad]."""

    range: Floats
    range_migration: Singles
    azimuth_change: Singles


def interpolated_history(
    nodes: list[Floats], apparent: list[Floats], middle: Floats, earth_radius: float, over: Parabola
) -> tuple[RangeHistory, Flags]:
    """The range history of echoes at positions (E, 3) relative to the antenna at the three nodes, and which need `exact_history`.

    apparent: the same as an antenna that sways observes them (`apparent_position`); middle: ranges at the middle (E,) [m].
    """
    first, last = ((slant_range(position, earth_radius) - middle) for position in (nodes[0], nodes[2]))
    changes, large = zip(*(_azimuth_change(apparent[1], position) for position in (apparent[0], apparent[2])), strict=True)
    history = RangeHistory(middle, over.change(first, last), over.change(changes[0], changes[1]))
    track = nodes[2] - nodes[0]
    half = np.sqrt(np.einsum("ij,ij->i", track, track)) / 2.0
    near = PARABOLA_ERROR * half * half * half > TOLERANCE * middle * middle
    return history, near | large[0] | large[1]


def exact_history(
    history: RangeHistory, which: Indices, positions: Floats, level: Floats | None, azimuth: Floats, earth_radius: float
) -> Floats:
    """Writes the exact changes of echoes `which` (W,) into `history`; returns their elevations (W, K) [rad].

    positions: (K, W, 3) relative to the antenna [m]; level: matrices (K, 3, 3) of `apparent_position`, None for an antenna
    that does not sway; azimuth: (W,) at the middle [rad].
    """
    history.range_migration[which] = (slant_range(positions, earth_radius) - history.range[which]).T
    matrices = np.broadcast_to(np.eye(3), (len(positions), 3, 3)) if level is None else level
    observed = apparent_position(positions, matrices, earth_radius)
    history.azimuth_change[which] = wrap_angle(np.arctan2(observed[..., 0], observed[..., 1]) - azimuth).T
    return elevation_of(observed).T


def apparent_position(positions: Floats, level: Floats, earth_radius: float) -> Floats:
    """Positions (..., E, 3) relative to the antenna as an antenna that sways observes them, by matrices `level` (..., 3, 3) from
    the map to the deck, with the earth's drop applied."""
    curved = positions.copy()
    curved[..., 2] -= (positions[..., 0] ** 2 + positions[..., 1] ** 2) / (2.0 * earth_radius)
    return np.asarray(curved @ np.swapaxes(level, -1, -2))


def elevation_of(direction: Floats) -> Floats:
    """Elevation (...) [rad] of directions (..., 3)."""
    return np.arctan2(direction[..., 2], np.hypot(direction[..., 0], direction[..., 1]))


def elevation_above(position: Floats, earth_radius: float) -> Floats:
    """Elevation (...) [rad] of positions (..., 3) relative to the antenna, with the earth's drop, from horizontal."""
    square = position[..., 0] ** 2 + position[..., 1] ** 2
    return np.arctan2(position[..., 2] - square / (2.0 * earth_radius), np.sqrt(square))


def slant_range(position: Floats, earth_radius: float) -> Floats:
    """Range (...) [m] of positions (..., 3) relative to the antenna; as `frames.polar_from_map`, without the angles."""
    square = position[..., 0] ** 2 + position[..., 1] ** 2
    z = position[..., 2] - square / (2.0 * earth_radius)
    return np.asarray(np.sqrt(square + z * z))


def _azimuth_change(middle: Floats, position: Floats) -> tuple[Floats, Flags]:
    """Azimuth (E,) [rad] from `middle` to `position` (E, 3), and where it exceeds MAX_AZIMUTH_CHANGE."""
    cross = position[:, 0] * middle[:, 1] - position[:, 1] * middle[:, 0]
    dot = position[:, 0] * middle[:, 0] + position[:, 1] * middle[:, 1]
    ratio = np.divide(cross, dot, out=np.full(len(dot), np.inf), where=dot > 0.0)
    large = np.abs(ratio) > MAX_AZIMUTH_CHANGE
    ratio[large] = 0.0
    return ratio * (1.0 - ratio * ratio / 3.0), large  # a power would cost twenty times the products
