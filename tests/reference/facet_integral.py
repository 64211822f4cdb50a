"""Means of phasors over triangles times barycentric coordinates, and the scattering of single facets: what kernels do, in numpy.

Perfect conductor, exp(+j w t), waves exp(-j k r), as of `radar_service.scattering.physical_optics.facet_integral`.
"""

from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.scattering.physical_optics.facet_integral import CURRENT, NEARLY_FLAT, SMALL, phasors

GENTLE = 0.5  # rad of bend up to which exp(j x) - 1 is taken by its series, to 2e-11 of it
CYCLES = np.array([[2, 0, 1], [0, 1, 2], [1, 2, 0]])  # corners in cyclic order, by column the one that comes second


def corner_phasors(phases: Floats, bends: Floats) -> Complexes:
    """Means (3, M) of lambda_i exp(j phi) over triangles, lambda_i the barycentric coordinates, phi quadratic.

    phases: (3, M) of phi at the corners [rad]; bends: (3, M), by how much phi at the middle of the edge opposite to each corner
    exceeds the mean of the edge's two ends [rad]. The mean of w exp(j phi) with w linear is the sum of the corners' w times
    these. Linear phases are integrated in closed form; the factor of the bends is interpolated from corners and middles of
    edges (Filon 1928), its products with the linear phase are integrated too, and half of each goes to either end of its edge.
    """
    order = middle_second(phases)
    ordered = phases.take(order)
    result = np.empty(phases.shape, dtype=np.complex128)
    result.ravel()[order] = ordered_means(ordered, phasors(ordered), bubbles(bends.take(order)))
    return result


def middle_second(phases: Floats) -> Indices:
    """Where corners (3, M) lie in flat phases (3, M) when the one between the others comes second, in cyclic order."""
    first, second, third = phases - phases[[1, 2, 0]]
    middle = np.where(first * third >= 0.0, 0, np.where(first * second >= 0.0, 1, 2))
    count = phases.shape[1]
    return np.asarray(CYCLES.take(middle, axis=1) * count + np.arange(count))


def bubbles(bends: Floats) -> Complexes:
    """4 (exp(j bend) - 1) (3, M): weights of the products lambda_i lambda_j, by bends (3, M) of opposite edges [rad]."""
    if np.abs(bends).max(initial=0.0) > GENTLE:
        return np.asarray(4.0 * (phasors(bends) - 1.0))
    square = bends * bends
    result = np.empty(bends.shape, dtype=np.complex128)
    result.real = -2.0 * square * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
    result.imag = 4.0 * bends * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))))
    return result


def ordered_means(phases: Floats, at_corner: Complexes, bubble: Complexes) -> Complexes:
    """The `corner_phasors` of triangles with corners in the order of `middle_second`, by exp(j phi) at them and `bubbles`."""
    span = phases[2] - phases[0]
    flat = np.flatnonzero(np.abs(span) <= NEARLY_FLAT)
    result = _steep_corners(_Edges.of(phases, at_corner, flat), bubble)
    if len(flat):
        gentle = phases[:, flat]
        result[:, flat] = _flat_corners(gentle - gentle[1], bubble[:, flat]) * at_corner[1, flat]
    return result


class _Edges(NamedTuple):
    """Of triangles (M,) by the lowest, middle and highest phase of their corners: moments along the two edges that meet in the
    middle one. `plain`, `toward` and `bubble` are means over an edge of exp(j phi) times 1, s and s (1 - s), where s rises from
    0 to 1 toward the middle corner."""

    span: Floats
    lower: Complexes
    lower_toward: Complexes
    lower_bubble: Complexes
    upper: Complexes
    upper_toward: Complexes
    upper_bubble: Complexes

    @classmethod
    def of(cls, phases: Floats, at_corner: Complexes, flat: Indices) -> "_Edges":
        """flat: those whose span is not used."""
        (low, middle, high), (begin, end, top) = phases, at_corner
        span = high - low
        span[flat] = 1.0
        return cls(span, *_edge_moments(middle - low, begin, end), *_edge_moments(middle - high, top, end))


def _edge_moments(rise: Floats, begin: Complexes, end: Complexes) -> tuple[Complexes, Complexes, Complexes]:
    """The moments of edges (M,) along which the phase rises by `rise`, by exp(j phi) at their ends: integrals by parts."""
    short = np.flatnonzero(np.abs(rise) <= 2.0 * SMALL)
    step = np.empty(len(rise), dtype=np.complex128)
    step.real, step.imag = 0.0, -1.0 / np.where(np.abs(rise) <= 2.0 * SMALL, 1.0, rise)
    plain = (end - begin) * step
    toward = (end - plain) * step
    bubble = toward - (end - 2.0 * toward) * step
    plain[short], toward[short], bubble[short] = _short_edge_moments(rise[short], end[short])
    return plain, toward, bubble


def _short_edge_moments(rise: Floats, end: Complexes) -> tuple[Complexes, Complexes, Complexes]:
    """The moments of `_edge_moments`, without differences of what hardly differs."""
    half = rise / 2.0
    zeroth, first_over = _bessel(half)
    centre = end * phasors(-half)
    plain = centre * zeroth
    return plain, (plain + 1j * centre * (half * first_over)) / 2.0, centre * (first_over / 2.0)


def _linear_mean(edges: _Edges) -> Complexes:
    return np.asarray(-2j * (edges.upper - edges.lower) / edges.span)


def _steep_corners(edges: _Edges, weight: Complexes) -> Complexes:
    """Means (3, M) as of `corner_phasors`, corners by rising phase; weight: (3, M) of the product lambda_i lambda_j, by the
    opposite corner.

    Each is one integration by parts along the edge from the lowest to the highest phase, where d phi = span.
    """
    mean, step = _linear_mean(edges), -1j / edges.span
    at_middle = 2.0 * step * (edges.upper_toward - edges.lower_toward)
    at_low = step * (mean - 2.0 * (edges.lower - edges.lower_toward))
    at_high = step * (2.0 * (edges.upper - edges.upper_toward) - mean)
    upper_bubble = step * (2.0 * edges.upper_bubble - at_middle)
    lower_bubble = step * (at_middle - 2.0 * edges.lower_bubble)
    long_bubble = step * (at_high - at_low)
    bubbles = np.stack([weight[0] * upper_bubble, weight[1] * long_bubble, weight[2] * lower_bubble])
    return np.stack([at_low, at_middle, at_high]) + _shared_by_ends(bubbles)


def _shared_by_ends(bubbles: Complexes) -> Complexes:
    """What the corners (3, M) get of the edges (3, M) opposite to them: half of the two edges that meet there."""
    return np.asarray((bubbles.sum(axis=0) - bubbles) / 2.0)


def _flat_corners(phases: Floats, weight: Complexes) -> Complexes:
    """The corners of `_steep_corners` where phases (3, M) hardly differ: to second order, for the bubbles to first order."""
    together, squares = phases.sum(axis=0), (phases * phases).sum(axis=0)
    bubbles = weight * (1.0 / 12.0 + 1j * (together / 30.0 - phases / 60.0))
    second = (together * together + squares + 2.0 * phases * (together + phases)) / 120.0
    plain = 1.0 / 3.0 + 1j * (together + phases) / 12.0 - second
    return np.asarray(plain + _shared_by_ends(bubbles))


def scattering_amplitude(
    incident: Floats,
    field: Floats,
    received: Floats,
    normal: Floats,
    surface: Complexes | Floats,
    wavelength: float,
) -> Complexes:
    """Scattering amplitude [m] (M,) of conducting facets toward the radar, received with a polarization.

    incident: unit direction of travel (M, 3); field: electric field there over that at the radar's own first facet
    (M, 3); received: unit polarization (M, 3); normal: unit, on the lit side (M, 3); surface: area times the
    mean phase [m^2]. J = 2 n x H (Knott, Shaeffer, Tuley 1985, physical optics), so
    a = -j 2 sqrt(pi) / lambda [(p . d)(n . E) - (p . E)(n . d)] S, which at normal incidence is |a|^2 = 4 pi A^2 / lambda^2.
    """
    along, facing = dot(received, incident), dot(normal, incident)
    current = along * dot(normal, field) - dot(received, field) * facing
    return np.asarray(CURRENT / wavelength * current * surface)


def polarization_of(toward_radar: Floats, polarization: str) -> Floats:
    """Unit electric field (M, 3) of "h" (level) or "v" (upright) waves to or from the radar in unit directions (M, 3)."""
    level = np.stack([-toward_radar[:, 1], toward_radar[:, 0], np.zeros(len(toward_radar))], axis=1)
    length = np.hypot(level[:, 0], level[:, 1])
    level[length == 0.0, 0] = 1.0  # straight overhead any level direction is correct
    level /= np.where(length == 0.0, 1.0, length)[:, None]
    return level if polarization == "h" else np.cross(toward_radar, level)


def _bessel(z: Floats) -> tuple[Floats, Floats]:
    """Spherical Bessel functions j0(z) and j1(z) / z, (M,), of small arguments: their series."""
    z2 = z * z
    zeroth = 1.0 - z2 / 6.0 * (1.0 - z2 / 20.0 * (1.0 - z2 / 42.0))
    return zeroth, (1.0 - z2 / 10.0 * (1.0 - z2 / 28.0 * (1.0 - z2 / 54.0))) / 3.0


def dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))
