"""What the beam makes of moving echoes over a few consecutive azimuths, without asking each echo at each azimuth.

Between the first azimuth and the last an echo's range and azimuth are parabolas through three instants: the first, the
middle and the last one. A straight course s [m] long from the middle to either end, seen from range R, leaves it by at most
0.074 s^3 / R^2: the third derivative of R is at most 2 v^3 / (sqrt(3) R^2), and a parabola through three points h apart
errs by h^3 / (9 sqrt(3)) of it. Echoes too near for that, and bodies that do not go smoothly, are computed at each azimuth.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import wrap_angle

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]
Pattern = Callable[[Floats], Floats]  # offset from boresight [rad] to gain relative to it

NEAR = 0.074  # see above
TOLERANCE = 5e-6  # m that a parabola may leave the path: 2 mrad of two-way phase at 9.41 GHz, -54 dB
GREATEST_TURN = 0.05  # rad of azimuth from the middle to either end, where the series of the arc tangent errs by 6e-8 rad
TABLE_STEPS = 4096  # beam gains per beamwidth: the nearest one errs by less than -75 dB of boresight
TABLE_MOST = 2**22


class BeamWeightedEchoes(NamedTuple):
    """Echoes (E,) over K consecutive azimuths, the beam's weight included: range [m] at the middle of them, change of it
    from there (E, K) [m], amplitude (E, K) [sqrt(W)]."""

    range: Floats
    range_migration: Singles
    amplitude: NDArray[np.complex64]


class Parabola(NamedTuple):
    """Weights that carry values at three instants to K of them: nodes (3,) [s]; first and last (K,), of changes since the
    middle."""

    nodes: Floats
    first: Floats
    last: Floats

    def change(self, first: Floats, last: Floats) -> Singles:
        """Change (E, K) since the middle of what has changed by `first` and `last` (E,) at the outer nodes."""
        ends, weights = np.stack([first, last], axis=1), np.stack([self.first, self.last])
        change: Singles = ends.astype(np.float32) @ weights.astype(np.float32)
        return change


def parabola(time: Floats) -> Parabola:
    """The parabola over times (K,) [s], evenly spaced."""
    middle, half = (time[0] + time[-1]) / 2.0, (time[-1] - time[0]) / 2.0
    u = (time - middle) / half if half > 0.0 else np.zeros(len(time))
    return Parabola(np.array([middle - half, middle, middle + half]), u * (u - 1.0) / 2.0, u * (u + 1.0) / 2.0)


def interpolation_error(path: Floats, nodes: Floats, over: Parabola) -> Floats:
    """How far (...) paths (K, ..., N) leave the parabola through `nodes` (3, ..., N), the greatest distance."""
    rise = over.first.reshape(-1, *[1] * (path.ndim - 1)), over.last.reshape(-1, *[1] * (path.ndim - 1))
    fitted = nodes[1] + rise[0] * (nodes[0] - nodes[1]) + rise[1] * (nodes[2] - nodes[1])
    return np.asarray(np.abs(path - fitted).max(axis=(0, -1), initial=0.0))


class RangeHistory(NamedTuple):
    """Echoes (E,) over K azimuths: range (E,) [m] at the middle; changes since, (E, K), of range [m] and azimuth [rad]."""

    range: Floats
    range_migration: Singles
    azimuth_change: Singles


def interpolated_history(
    nodes: list[Floats], seen: list[Floats], middle: Floats, earth_radius: float, over: Parabola
) -> tuple[RangeHistory, NDArray[np.bool_]]:
    """The course of echoes at places (E, 3) relative to the antenna at the three nodes, and which must be done exactly.

    seen: the directions (E, 3) that a swaying antenna takes them for, else the same places; middle: ranges (E,) [m].
    """
    first, last = ((slant_range(place, earth_radius) - middle) for place in (nodes[0], nodes[2]))
    turns, steep = zip(*(_turned(seen[1], place) for place in (seen[0], seen[2])), strict=True)
    course = RangeHistory(middle, over.change(first, last), over.change(turns[0], turns[1]))
    half = nodes[2] - nodes[0]
    reach = np.sqrt(np.einsum("ij,ij->i", half, half)) / 2.0
    near = NEAR * reach * reach * reach > TOLERANCE * middle * middle
    return course, near | steep[0] | steep[1]


def exact_history(
    course: RangeHistory, which: Indices, places: Floats, upright: Floats | None, azimuth: Floats, earth_radius: float
) -> Floats:
    """Lays into `course` the true changes of echoes `which`, at places (K, W, 3) relative to the antenna; returns their
    elevations (W, K) [rad] as the antenna sees them.

    upright: of the three nodes and the K azimuths, as in `Scene.upright_from_map`; azimuth: (W,) [rad] from which it counts.
    """
    course.range_migration[which] = (slant_range(places, earth_radius) - course.range[which]).T
    seen = apparent(
        places, np.broadcast_to(np.eye(3), (len(places), 3, 3)) if upright is None else upright[3:], earth_radius
    )
    course.azimuth_change[which] = wrap_angle(np.arctan2(seen[..., 0], seen[..., 1]) - azimuth).T
    return elevation_of(seen).T


def apparent(places: Floats, upright: Floats, earth_radius: float) -> Floats:
    """Directions (..., E, 3) that a swaying antenna takes places relative to it for, by matrices (..., 3, 3)."""
    bent = places.copy()
    bent[..., 2] -= (places[..., 0] ** 2 + places[..., 1] ** 2) / (2.0 * earth_radius)
    return np.asarray(bent @ np.swapaxes(upright, -1, -2))


def elevation_of(direction: Floats) -> Floats:
    """Elevation (...) [rad] of directions (..., 3)."""
    return np.arctan2(direction[..., 2], np.hypot(direction[..., 0], direction[..., 1]))


def slant_range(place: Floats, earth_radius: float) -> Floats:
    """Range (...) [m] of places (..., 3) relative to the antenna; as `frames.polar_from_map`, without the angles."""
    square = place[..., 0] ** 2 + place[..., 1] ** 2
    z = place[..., 2] - square / (2.0 * earth_radius)
    return np.asarray(np.sqrt(square + z * z))


def _turned(middle: Floats, place: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Azimuth (E,) [rad] from `middle` to `place` (E, 3), and where it is too much for its series."""
    cross = place[:, 0] * middle[:, 1] - place[:, 1] * middle[:, 0]
    dot = place[:, 0] * middle[:, 0] + place[:, 1] * middle[:, 1]
    ratio = np.divide(cross, dot, out=np.full(len(dot), np.inf), where=dot > 0.0)
    steep = np.abs(ratio) > GREATEST_TURN
    ratio[steep] = 0.0
    return ratio * (1.0 - ratio * ratio / 3.0), steep  # a power would cost twenty times the products


def joined(parts: list[BeamWeightedEchoes], azimuths: int) -> BeamWeightedEchoes:
    """Echoes of several parts over the same azimuths as one record."""
    if len(parts) == 1:
        return parts[0]
    none = BeamWeightedEchoes(np.zeros(0), np.zeros((0, azimuths), np.float32), np.zeros((0, azimuths), np.complex64))
    return BeamWeightedEchoes(*(np.concatenate(column) for column in zip(none, *parts, strict=True)))


def turned_amplitude(base: Complexes, weight: Singles, range_migration: Singles, wavelength: float) -> NDArray[np.complex64]:
    """Amplitudes (E, K): `base` (E,) of the middle, weighted (E, K) and turned by changes of range `range_migration` (E, K) [m]."""
    phase = range_migration * np.float32(-4.0 * np.pi / wavelength)  # some 100 rad: float32 leaves 1e-5 of a radian
    amplitude = np.empty(phase.shape, dtype=np.complex64)
    np.multiply(np.cos(phase), weight, out=amplitude.real)
    np.multiply(np.sin(phase), weight, out=amplitude.imag)
    amplitude *= base.astype(np.complex64)[:, None]
    return amplitude


class BeamTable:
    """Gains of a pattern relative to boresight, even in the offset, ready to be looked up."""

    def __init__(self, pattern: Pattern, beamwidth: float, extent: float, span: float, steps: int = TABLE_STEPS) -> None:
        """extent: offset [rad] up to which echoes count; span: of the boresights that are swept together [rad]; steps: gains
        per beamwidth."""
        self.extent, self.span = extent, span
        reach = extent + 2.0 * span  # one that counts for the first boresight is farther from the last
        per_radian = min(steps / beamwidth, TABLE_MOST / reach)
        offset = wrap_angle(np.arange(int(reach * per_radian) + 2) / per_radian)
        self._gain, self._per_radian = pattern(offset).astype(np.float32), np.float32(per_radian)

    def __call__(self, offset: Singles) -> Singles:
        """Gain at offsets from boresight, any shape [rad]; beyond the table's reach it is that at its end."""
        entry = np.abs(offset)
        entry *= self._per_radian
        entry += np.float32(0.5)
        gain: Singles = self._gain.take(entry.astype(np.intp), mode="clip")
        return gain
