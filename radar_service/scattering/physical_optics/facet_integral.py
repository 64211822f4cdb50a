"""Physical optics of flat triangles: the currents that a plane wave drives on them, summed in closed form.

Perfect conductor, exp(+j w t), waves exp(-j k r). What leaves toward the radar is a scattering amplitude [m], the root of
the cross-section with its phase at the triangle's centroid, for the radar's own polarization.
"""

import numpy as np
from numpy.typing import NDArray

from radar_service.kernels.library import KERNELS

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]

NEARLY_FLAT = 0.05  # rad of phase across a triangle; below it the series' next term is 0.05^4/720 = 9e-9 of the area
CURRENT = -2j * np.sqrt(np.pi)  # amplitude over current, surface and 1 / wavelength
SMALL = 0.3  # argument of a spherical Bessel function below which its series errs by less than 1e-9


def triangle_phases(corners: Floats, centre: Floats, gradient: Floats, wavenumber: float) -> Complexes:
    """Mean of exp(-j k g . (r - c)) over triangles, c their centroids: (M,), 1 where the wave fits the surface.

    corners: (M, 3, 3) [m]; centre: c (M, 3) [m]; gradient: g (M, 3), incident minus outgoing direction; wavenumber: k
    [rad/m].
    """
    phases = np.stack([-wavenumber * _dot(corners[:, i] - centre, gradient) for i in range(3)])
    return mean_phasor(phases)


def mean_phasor(phases: Floats) -> Complexes:
    """Mean of exp(j phi) over triangles (M,), phi linear, by its values at the corners (3, M) [rad].

    It is a divided difference of exp(j x) at the corners' phases (Hermite-Genocchi; de Boor 2005, Divided differences), which is
    Gordon's (1975) line integral without its poles.
    """
    low, middle, high = ordered = np.sort(phases, axis=0)
    flat = high - low <= NEARLY_FLAT
    gentle, steep = np.flatnonzero(flat), np.flatnonzero(~flat)
    around = middle[gentle]
    result = np.empty(len(low), dtype=np.complex128)
    result[gentle] = _flat_mean(low[gentle] - around, np.zeros(len(gentle)), high[gentle] - around) * np.exp(1j * around)
    (first, second, third), (begin, end, top) = ordered[:, steep], phasors(ordered[:, steep])
    lower, upper = _edge_mean(second - first, begin, end), _edge_mean(second - third, top, end)
    result[steep] = -2j * (upper - lower) / (third - first)
    return result


def phasors(phase: Floats) -> Complexes:
    """exp(j phase), of the same shape; half the time of numpy's complex exp."""
    result = np.empty(phase.size, dtype=np.complex128)
    KERNELS.phasors(phase.size, np.ascontiguousarray(phase).reshape(-1), result)
    return result.reshape(phase.shape)


def _edge_mean(rise: Floats, begin: Complexes, end: Complexes) -> Complexes:
    """Means of exp(j phi) over edges (M,) along which it rises by `rise`, by its values at their ends."""
    half = rise / 2.0
    z2, short = half * half, np.abs(rise) <= 2.0 * SMALL
    series = end * phasors(-half) * (1.0 - z2 / 6.0 * (1.0 - z2 / 20.0 * (1.0 - z2 / 42.0)))
    return np.asarray(np.where(short, series, -1j * (end - begin) / np.where(short, 1.0, rise)))


def _flat_mean(x: Floats, y: Floats, z: Floats) -> Complexes:
    """The linear mean by its series in the phases (M,): 1 + j p1/3 - (p1^2 + p2)/24 - j (p1^3 + 3 p1 p2 + 2 p3)/360, p_n the
    sums of powers."""
    p1, p2, p3 = x + y + z, x * x + y * y + z * z, x * x * x + y * y * y + z * z * z
    mean = np.empty(len(x), dtype=np.complex128)
    mean.real = 1.0 - (p1 * p1 + p2) / 24.0
    mean.imag = p1 / 3.0 - (p1 * p1 * p1 + 3.0 * p1 * p2 + 2.0 * p3) / 360.0
    return mean


def specular_reflection(direction: Floats, field: Floats, normal: Floats) -> tuple[Floats, Floats]:
    """Direction and electric field (M, 3) after specular reflection by a conductor: d - 2(n.d)n and 2(n.E)n - E."""
    turned = direction - 2.0 * _dot(normal, direction)[:, None] * normal
    return turned, 2.0 * _dot(normal, field)[:, None] * normal - field


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))
