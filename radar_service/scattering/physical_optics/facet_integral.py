"""Physical optics of flat triangles: the currents that a plane wave drives on them, summed in closed form.

Perfect conductor, exp(+j w t), waves exp(-j k r). What leaves toward the radar is a scattering amplitude [m], the root of
the cross-section with its phase at the triangle's centroid, for the radar's own polarization.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

NEARLY_FLAT = 0.05  # rad of phase across a triangle; below it the series' next term is 0.05^4/720 = 9e-9 of the area


def triangle_phases(corners: Floats, centre: Floats, gradient: Floats, wavenumber: float) -> Complexes:
    """Mean of exp(-j k g . (r - c)) over triangles, c their centroids: (M,), 1 where the wave fits the surface.

    corners: (M, 3, 3) [m]; centre: c (M, 3) [m]; gradient: g (M, 3), incident minus outgoing direction; wavenumber: k
    [rad/m].
    The integral over a simplex of exp(j phi) with phi linear is a divided difference of exp(j x) at the corners' phases
    (Hermite-Genocchi; de Boor 2005, Divided differences), which is Gordon's (1975) line integral without its poles.
    """
    x, y, z = (-wavenumber * _dot(corners[:, i] - centre, gradient) for i in range(3))
    lower, upper = np.minimum(x, y), np.maximum(x, y)
    # A divided difference does not depend on the order; the widest step is the most accurate divisor
    low, high, middle = np.minimum(lower, z), np.maximum(upper, z), np.maximum(lower, np.minimum(upper, z))
    result = _flat_mean(x, y, z)
    steep = np.flatnonzero(high - low > NEARLY_FLAT)
    a, b, c = low[steep], middle[steep], high[steep]
    result[steep] = -2.0 * (_first_difference(b, c) - _first_difference(a, b)) / (c - a)
    return result


def _first_difference(a: Floats, b: Floats) -> Complexes:
    """(exp(j b) - exp(j a)) / (b - a), stable where they meet."""
    middle, level = (a + b) / 2.0, np.sinc((b - a) / (2.0 * np.pi))
    difference = np.empty(len(a), dtype=np.complex128)
    difference.real, difference.imag = -np.sin(middle) * level, np.cos(middle) * level
    return difference


def _flat_mean(x: Floats, y: Floats, z: Floats) -> Complexes:
    """The same mean by its series in the phases (M,), whose sum is 0: 1 - p2/24 - j p3/180, p_n the sums of powers."""
    x2, y2, z2 = x * x, y * y, z * z
    mean = np.empty(len(x), dtype=np.complex128)
    mean.real, mean.imag = 1.0 - (x2 + y2 + z2) / 24.0, (x2 * x + y2 * y + z2 * z) / -180.0
    return mean


def scattering_amplitude(
    incident: Floats,
    field: Floats,
    received: Floats,
    normal: Floats,
    surface: Complexes,
    wavelength: float,
) -> Complexes:
    """Scattering amplitude [m] (M,) of conducting facets toward the radar, received with a polarization.

    incident: unit direction of travel (M, 3); field: electric field there over that at the radar's own first facet
    (M, 3); received: unit polarization (M, 3); normal: unit, on the lit side (M, 3); surface: area times the
    mean phase [m^2]. J = 2 n x H (Knott, Shaeffer, Tuley 1985, physical optics), so
    a = -j 2 sqrt(pi) / lambda [(p . d)(n . E) - (p . E)(n . d)] S, which at normal incidence is |a|^2 = 4 pi A^2 / lambda^2.
    """
    along, facing = _dot(received, incident), _dot(normal, incident)
    current = along * _dot(normal, field) - _dot(received, field) * facing
    return np.asarray(-2j * np.sqrt(np.pi) / wavelength * current * surface)


def specular_reflection(direction: Floats, field: Floats, normal: Floats) -> tuple[Floats, Floats]:
    """Direction and electric field (M, 3) after specular reflection by a conductor: d - 2(n.d)n and 2(n.E)n - E."""
    turned = direction - 2.0 * _dot(normal, direction)[:, None] * normal
    return turned, 2.0 * _dot(normal, field)[:, None] * normal - field


def polarization_of(toward_radar: Floats, polarization: str) -> Floats:
    """Unit electric field (M, 3) of "h" (level) or "v" (upright) waves to or from the radar in unit directions (M, 3)."""
    level = np.stack([-toward_radar[:, 1], toward_radar[:, 0], np.zeros(len(toward_radar))], axis=1)
    length = np.hypot(level[:, 0], level[:, 1])
    level[length == 0.0, 0] = 1.0  # straight overhead any level direction is correct
    level /= np.where(length == 0.0, 1.0, length)[:, None]
    return level if polarization == "h" else np.cross(toward_radar, level)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))
