"""What elements of an aperture receive beside a structure, one by one: behind a black strip, and behind a metal cylinder.

Slow and independent of radar_service/radar: elements stand where they are on the map, the antenna turns, and waves are those of
two dimensions without small angles. Phases are exp(j w t). Source of the series: Ruck et al., Radar Cross Section Handbook,
1970, 4.1.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import h1vp, hankel1, hankel2, jv, jvp

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
POINTS_PER_WAVE = 12


def direction(bearing: Floats | float) -> Floats:
    """East and north of bearings (N,): (N, 2)."""
    return np.stack([np.sin(bearing), np.cos(bearing)], axis=-1)


def elements(length: float, count: int, boresight: float) -> tuple[Floats, Floats]:
    """Places of elements (M, 2) [m] around the middle of an antenna, and how far each is to the right of it (M,) [m]."""
    along = ((np.arange(count) + 0.5) / count - 0.5) * length
    return along[:, None] * direction(boresight + np.pi / 2.0), along


def past_strip(
    target: float, bearing: float, distance: float, radius: float, points: Floats, wavelength: float
) -> Complexes:
    """Field (M,) of a plane wave from bearing `target` at points (M, 2), behind a black strip that is upright to the wave.

    Rayleigh and Sommerfeld's integral over the strip, which is what it takes: -j k / 2 cos(theta) H1(2)(k r) for each source.
    """
    k, ahead = 2.0 * np.pi / wavelength, direction(target)
    count = int(np.ceil(2.0 * radius / wavelength * POINTS_PER_WAVE)) + 1
    offset = ((np.arange(count) + 0.5) / count - 0.5) * 2.0 * radius
    sources = distance * direction(bearing) + offset[:, None] * direction(target + np.pi / 2.0)
    way = sources[:, None] - points
    r = np.hypot(way[..., 0], way[..., 1])
    kernel = -0.5j * k * (way @ ahead) / r * hankel2(1, k * r)
    incident = np.exp(1j * k * (sources @ ahead))
    free: Complexes = np.exp(1j * k * (points @ ahead))
    return free - (incident[:, None] * kernel).sum(axis=0) * 2.0 * radius / count


def past_cylinder(
    target: float, bearing: float, distance: float, radius: float, points: Floats, wavelength: float, polarization: str
) -> Complexes:
    """Field (M,) of a plane wave from bearing `target` at points (M, 2), beside an upright metal cylinder, by its series."""
    k, ahead = 2.0 * np.pi / wavelength, direction(target)
    place = points - distance * direction(bearing)
    r, angle = np.hypot(place[:, 0], place[:, 1]), np.arctan2(place @ direction(target + np.pi / 2.0), place @ ahead)
    order = np.arange(int(k * radius + 12.0 * (k * radius) ** (1 / 3) + 12))[:, None]
    if polarization == "v":  # along the cylinder
        ratio = jv(order, k * radius) / hankel1(order, k * radius)
    else:
        ratio = jvp(order, k * radius) / h1vp(order, k * radius)
    terms = np.where(order == 0, 1.0, 2.0) * (-1j) ** order * ratio * hankel1(order, k * r) * np.cos(order * angle)
    scattered = np.conj(terms.sum(axis=0))  # exp(-j w t), a wave towards -x: to exp(j w t)
    phase = np.exp(1j * k * distance * (direction(bearing) @ ahead))
    free: Complexes = np.exp(1j * k * (points @ ahead))
    return free - phase * scattered


def received(field: Complexes, along: Floats, length: float, weights: dict[float, float]) -> complex:
    """What an antenna makes of the field at its elements (M,), over a plane wave on boresight; weights: of cosines by cycles."""
    lit = sum(weight * np.cos(2.0 * np.pi * cycles * along / length) for cycles, weight in weights.items())
    return complex((field * lit).sum() / np.sum(lit))
