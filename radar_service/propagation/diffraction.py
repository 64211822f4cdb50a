"""Diffraction over a smooth round sea: the residue series, joined to the two rays.

The field behind the horizon is a sum over modes that creep along the sea (van der Pol and Bremmer 1937; Fock, Electromagnetic
Diffraction and Propagation Problems, 1965, ch. 10). The series also holds in front of the horizon, where more modes count. There
it agrees with the two rays, and the field passes over.

Lengths are in natural units: x = m d / ae along the earth and y = k h / m in height, with m = (k ae / 2)^(1/3). At 9.41 GHz over
a 4/3 earth they are 9.0 km and 4.8 m.
"""

from functools import lru_cache

import numpy as np
from scipy.special import ai_zeros, airy

from radar_service.numerics import SPEED_OF_LIGHT, Complexes, Floats, effective_earth_radius
from radar_service.propagation.multipath import Site, TwoRays
from radar_service.propagation.sea_surface import sea_water_permittivity
from radar_service.radar import Radar
from radar_service.world import Environment

MIXED = (1.5, 2.0)  # m sin(grazing): below, the series alone (two rays err by 5 %); above, two rays alone (2.5 %)
NEAR = (0.05, 0.1)  # x: nearer, two rays alone, as the series needs ever more modes; only antennas below a metre have this
MODES, NEAR_MODES, FEW_MODES = 100, 400, 0.4  # modes that agree with thrice as many to 1e-7; many where x is below 0.4
MAX_HEIGHT = 30.0  # y: of the antenna and of targets; terms of higher ones cancel to more than double precision holds
PANEL, DEGREE = 2.0, 32  # y of a panel of height gains and degree of its Chebyshev series: rounding alone is left
PART = 2048  # echoes whose modes are computed together: 3 MB, or 13 MB of NEAR_MODES


def diffraction_height(radar: Radar, environment: Environment) -> float:
    """Height [m] up to which antennas and targets diffract: 30 natural units, 143 m in X band; 0 without diffraction."""
    if not environment.diffraction:
        return 0.0
    return MAX_HEIGHT * _natural_units(radar.wavelength, effective_earth_radius(environment.earth_factor))[1]


def with_diffraction(rays: TwoRays, site: Site, wavelength: float, earth_radius: float, polarization: str) -> TwoRays:
    """The rays with a ratio by which 1 + ratio exp(-jk (R1 + R2 - R)) is the field on either side of the horizon.

    rays: of any shape, at a `site` that broadcasts to it; wavelength, earth_radius: ae [m]; polarization: "h" or "v". The share
    of the two rays in the field falls smoothly from 1 to 0 over MIXED. It stays 1 above MAX_HEIGHT. The series has the elevation
    gain of the direct ray and a smooth sea.
    """
    distance, height, antenna = (np.broadcast_to(values, rays.gain.shape) for values in site)
    along, up, m = _natural_units(wavelength, earth_radius)
    share = _rise(m * np.sin(rays.geometry.grazing), *MIXED)
    share = 1.0 - (1.0 - share) * _rise(distance / along, *NEAR)
    share[np.maximum(height, antenna) >= MAX_HEIGHT * up] = 1.0
    some = np.nonzero(share < 1.0)
    field = series_field(
        distance[some], np.maximum(height[some], 0.0), antenna[some], wavelength, earth_radius, polarization
    )
    turned = (field - 1.0) * np.exp(2j * np.pi / wavelength * rays.geometry.excess[some])
    ratio = np.array(rays.ratio, dtype=np.complex128)
    ratio[some] = share[some] * ratio[some] + (1.0 - share[some]) * turned
    return rays._replace(ratio=ratio, share=share)


def series_field(
    distance: Floats, height: Floats, antenna_height: Floats, wavelength: float, earth_radius: float, polarization: str
) -> Complexes:
    """One-way field (E,) over a smooth sea relative to that of the direct ray in free space, exp(+j w t): the residue series.

    distance: along the earth (E,) [m]; height, antenna_height: above the sea, not negative (E,) [m]; the field stays the same
    where they are exchanged. Beyond the horizon the direct ray goes through the earth, which gives a phase alone.
    """
    along, up, _ = _natural_units(wavelength, earth_radius)
    x, first, second = distance / along, antenna_height / up, height / up
    field = np.zeros(len(x), dtype=np.complex128)
    for count, group in ((MODES, x >= FEW_MODES), (NEAR_MODES, x < FEW_MODES)):
        which = np.flatnonzero(group)
        for part in np.array_split(which, -(-len(which) // PART)) if len(which) else ():
            field[part] = _series(x[part], first[part], second[part], (wavelength, earth_radius, polarization, count))
    return field


def _series(x: Floats, first: Floats, second: Floats, sea: tuple[float, float, str, int]) -> Complexes:
    """2 sqrt(j pi x) sum of q^2 / (t - q^2) w(t - y1) w(t - y2) / w'(t)^2 exp(j x t), turned back by the direct ray's phase."""
    modes, q = _modes(*sea)
    terms = np.exp(1j * x[:, None] * modes) * (q * q / (modes - q * q))
    terms *= _height_gains(first, sea) * _height_gains(second, sea)
    direct = (second - first) ** 2 / (4.0 * x) + x * (first + second) / 2.0 - x**3 / 12.0  # k (R - d)
    series = 2.0 * np.sqrt(np.pi * x) * np.exp(1j * (np.pi / 4.0 - direct)) * terms.sum(axis=1)
    return np.asarray(np.conj(series))  # Fock writes exp(-i w t)


def _height_gains(y: Floats, sea: tuple[float, float, str, int]) -> Complexes:
    """w(t - y) / w'(t) (E, N) of heights (E,) for each of N modes, by Chebyshev series in panels of height."""
    result = np.empty((len(y), sea[-1]), dtype=np.complex128)
    panel = np.floor(y / PANEL).astype(np.int64)
    for number in np.unique(panel).tolist():
        inside_panel = np.flatnonzero(panel == number)
        inside = 2.0 * (y[inside_panel] / PANEL - number) - 1.0
        result[inside_panel] = np.polynomial.chebyshev.chebvander(inside, DEGREE) @ _panel(number, sea)
    return result


@lru_cache(256)
def _panel(number: int, sea: tuple[float, float, str, int]) -> Complexes:
    """Chebyshev coefficients (DEGREE + 1, N) of the height gains of N modes in a panel."""
    modes, _ = _modes(*sea)
    angle = np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1)
    y = (number + (np.cos(angle) + 1.0) / 2.0) * PANEL
    gains = _airy_w(modes - y[:, None])[0] / _airy_w(modes)[1]
    weights = np.cos(np.arange(DEGREE + 1)[:, None] * angle) * 2.0 / (DEGREE + 1)
    weights[0] /= 2.0
    return np.asarray(weights @ gains)


@lru_cache(16)
def _modes(wavelength: float, earth_radius: float, polarization: str, count: int) -> tuple[Complexes, complex]:
    """The roots t (N,) of w'(t) = q w(t), and q = j m sqrt(e - 1), over e for vertical polarization (e the permittivity)."""
    permittivity = np.conj(sea_water_permittivity(SPEED_OF_LIGHT / wavelength))
    q = 1j * _natural_units(wavelength, earth_radius)[2] * np.sqrt(permittivity - 1.0)
    q = complex(q / permittivity if polarization == "v" else q)
    modes = -ai_zeros(count)[0] * np.exp(1j * np.pi / 3.0)
    modes = modes + 1.0 / q  # the sea almost conducts: q is above 40 from 1 GHz on
    for _ in range(8):  # Newton's method; two steps reach rounding
        value, slope = _airy_w(modes)
        modes = modes - (slope / q - value) / (modes * value / q - slope)
    return modes, q


def _airy_w(t: Complexes) -> tuple[Complexes, Complexes]:
    """Fock's w(t) = sqrt(pi) (Bi(t) + j Ai(t)) and its slope, of any shape."""
    turn = np.exp(2j * np.pi / 3.0)
    value, slope, _, _ = airy(t * turn)
    factor = 2.0 * np.sqrt(np.pi) * np.exp(1j * np.pi / 6.0)
    return factor * value, factor * turn * slope


def _natural_units(wavelength: float, earth_radius: float) -> tuple[float, float, float]:
    """The units of distance and of height [m], and m."""
    wavenumber = 2.0 * np.pi / wavelength
    m = float(np.cbrt(wavenumber * earth_radius / 2.0))
    return earth_radius / m, m / wavenumber, m


def _rise(values: Floats, start: float, stop: float) -> Floats:
    """From 0 at `start` to 1 at `stop` without a step in value or slope, any shape."""
    part = np.clip((values - start) / (stop - start), 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part))
