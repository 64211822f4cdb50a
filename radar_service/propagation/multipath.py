"""What the path does to an echo: attenuation by gas and rain, and the sea-reflected ray beside the direct one.

Places are as in `frames`: a distance along the earth and a height above the sea, with the surface falling away as
z = -d^2 / (2 ae). Phases follow exp(+j w t): a path of length R turns the field by exp(-j k R).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.propagation.sea_surface import ament, fresnel, miller_brown, sea_water_permittivity

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Gain = Callable[[Floats], Floats]  # one-way power gain at an elevation from horizontal [rad]
Roughness = Callable[[Floats, float, float], Floats]  # grazing angle, rms wave height, wavelength -> factor

_TINY = 1e-300  # m^2: lets a target on the very foot of the antenna pass without 0 / 0
LOWEST_GAIN = 1e-12  # -120 dB: below it the direct gain no longer divides, so a null of the beam stays finite


def wavelength(frequency: float) -> float:
    """Free-space wavelength [m] of a frequency [Hz], 0.03186 m at 9.41 GHz. Source: seed eq. 1."""
    return SPEED_OF_LIGHT / frequency  # eq. 1


def printed_atmosphere(range: Floats | float, db_per_km: float = 0.01) -> Floats:
    """Two-way POWER loss exactly as printed, which the specification multiplies onto the amplitude (DESIGN row 3).

    range: slant range, any shape [m]; db_per_km: one way. Source: seed eq. 10.
    """
    loss: Floats = 10.0 ** (-db_per_km * 2.0 * np.asarray(range, dtype=np.float64) / (10.0 * 1000.0))  # eq. 10
    return loss


def gas_amplitude(range: Floats | float, db_per_km: float) -> Floats:
    """Two-way AMPLITUDE factor 10^(-gamma 2R / 20 000) of a uniform attenuation, gas or rain (DESIGN row 3).

    range: slant range, any shape [m]; db_per_km: one way; the sum where several act.
    """
    factor: Floats = 10.0 ** (-db_per_km * 2.0 * np.asarray(range, dtype=np.float64) / 20_000.0)
    return factor


class _RainFit(NamedTuple):
    """Curve sum a exp(-((x - b) / c)^2) + m x + c0 over x = log10 of the frequency in GHz (P.838-3 eqs. 2, 3)."""

    a: tuple[float, ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    slope: float
    offset: float

    def at(self, x: float) -> float:
        bumps = (a * np.exp(-(((x - b) / c) ** 2)) for a, b, c in zip(self.a, self.b, self.c, strict=True))
        return float(sum(bumps)) + self.slope * x + self.offset


# Tables 1 to 4 of Rec. ITU-R P.838-3 (2005): log10 k and alpha by polarization.
_RAIN_LOG_K = {
    "h": _RainFit(
        (-5.33980, -0.35351, -0.23789, -0.94158),
        (-0.10008, 1.26970, 0.86036, 0.64552),
        (1.13098, 0.45400, 0.15354, 0.16817),
        -0.18961,
        0.71147,
    ),
    "v": _RainFit(
        (-3.80595, -3.44965, -0.39902, 0.50167),
        (0.56934, -0.22911, 0.73042, 1.07319),
        (0.81061, 0.51059, 0.11899, 0.27195),
        -0.16398,
        0.63297,
    ),
}
_RAIN_ALPHA = {
    "h": _RainFit(
        (-0.14318, 0.29591, 0.32177, -5.37610, 16.1721),
        (1.82442, 0.77564, 0.63773, -0.96230, -3.29980),
        (-0.55187, 0.19822, 0.13164, 1.47828, 3.43990),
        0.67849,
        -1.95537,
    ),
    "v": _RainFit(
        (-0.07771, 0.56727, -0.20238, -48.2991, 48.5833),
        (2.33840, 0.95545, 1.14520, 0.791669, 0.791459),
        (-0.76284, 0.54039, 0.26809, 0.116226, 0.116479),
        -0.053739,
        0.83433,
    ),
}


def rain_db_per_km(rain_mm_h: float, polarization: str, frequency: float) -> float:
    """One-way specific attenuation of rain [dB/km], k R^alpha on a level path (Rec. ITU-R P.838-3, 2005, eq. 1).

    rain_mm_h: 0 and up; polarization: "h" or "v"; frequency: 1e9 to 1000e9 [Hz]. Raises ValueError outside.
    """
    if polarization not in _RAIN_LOG_K:
        raise ValueError(f'polarization: "{polarization}" is not one of {", ".join(_RAIN_LOG_K)}')
    if not 1e9 <= frequency <= 1e12:
        raise ValueError(f"frequency: {frequency:g} Hz is outside the 1e9 to 1e12 Hz of ITU-R P.838-3")
    if not rain_mm_h >= 0:
        raise ValueError(f"rain_mm_h: {rain_mm_h:g} is not allowed; 0 mm/h or more")
    x = np.log10(frequency / 1e9)
    return float(10.0 ** _RAIN_LOG_K[polarization].at(x) * rain_mm_h ** _RAIN_ALPHA[polarization].at(x))


class SpecularGeometry(NamedTuple):
    """The ray by way of the sea, arrays of one shape; lengths [m], angles [rad], elevations from horizontal.

    excess is R1 + R2 - R; grazing is negative, and the rest without meaning, where the target lies below the horizon.
    """

    direct: Floats  # R, length of the direct ray
    first: Floats  # R1, antenna to sea
    second: Floats  # R2, sea to target
    excess: Floats
    grazing: Floats
    divergence: Floats  # D of the curved surface, 1 on a flat one
    elevation_direct: Floats
    elevation_reflected: Floats


def specular_geometry(
    distance: Floats | float, height: Floats | float, antenna_height: float, earth_radius: float = np.inf
) -> SpecularGeometry:
    """Geometry of the specular reflection between an antenna and targets over a flat sea or over z = -d^2 / (2 ae).

    distance: along the earth, any shape [m]; height: of the target above the sea, below it counts as on it [m];
    antenna_height: above the sea, positive [m]; earth_radius: effective radius ae [m], inf for flat. The reflection point
    solves the cubic of Kerr (Propagation of Short Radio Waves, 1951, ch. 2); by Fermat its error enters in second order.
    """
    d, h = np.broadcast_arrays(np.asarray(distance, np.float64), np.maximum(np.asarray(height, np.float64), 0.0))
    x = _reflection_point(d, h, antenna_height, earth_radius)
    far = d - x
    rise_1 = antenna_height + x**2 / (2.0 * earth_radius)
    drop = d**2 / (2.0 * earth_radius)
    rise_2 = h - drop + x**2 / (2.0 * earth_radius)
    z = h - drop - antenna_height
    direct, first, second = np.hypot(d, z), np.hypot(x, rise_1), np.hypot(far, rise_2)
    above_tangent = antenna_height - x**2 / (2.0 * earth_radius)
    grazing = np.arctan2(above_tangent, x)
    # R1 + R2 - R without subtracting kilometres from kilometres: it is millimetres, and k of it must be good to 1e-6 rad
    cross = (x * rise_2) ** 2 + (far * rise_1) ** 2 + (rise_1 * rise_2) ** 2
    gap = 2.0 * (rise_1 * rise_2 + cross / (first * second + x * far + _TINY))
    excess = gap / (first + second + direct)
    return SpecularGeometry(
        direct, first, second, excess, grazing, divergence(x, far, grazing, earth_radius),
        np.arctan2(z, d), np.arctan2(-rise_1, x),
    )  # fmt: skip


def divergence(first: Floats, second: Floats, grazing: Floats, earth_radius: float) -> Floats:
    """Divergence factor D of a ray reflected by the curved sea, from 1 (flat) to 0 at the horizon.

    first, second: ground distances from antenna and target to the reflection point [m]; grazing: [rad], D is 0 where it is
    not positive; earth_radius: ae [m], inf for flat. D = (1 + 2 d1 d2 / (ae d sin psi))^-1/2 (Kerr 1951, ch. 5).
    """
    d = first + second
    sine = np.sin(grazing)
    lit = sine > 0
    split = np.divide(first * second, d * sine, out=np.zeros_like(d), where=lit & (d > 0))
    factor: Floats = np.where(lit, 1.0 / np.sqrt(1.0 + 2.0 * split / earth_radius), 0.0)
    return factor


def two_ray_factor(
    distance: Floats | float,
    height: Floats | float,
    antenna_height: float,
    wavelength: float,
    *,
    earth_radius: float = np.inf,
    polarization: str = "h",
    wave_height: float = 0.0,
    elevation_gain: Gain | None = None,
    roughness: Roughness = miller_brown,
) -> Complexes:
    """Field at each target over that of the direct ray alone, F; an echo's amplitude is multiplied by F^2, phase included.

    distance: along the earth, any shape [m]; height: above the sea [m]; antenna_height, wavelength: [m]; earth_radius: ae
    [m]; polarization: "h" or "v"; wave_height: rms of the sea [m]; elevation_gain: one-way power gain at an elevation from
    horizontal (None: the same everywhere; its root is taken as positive, so sidelobes of opposite sign are not told apart).
    F = 1 + Gamma rho_s D exp(-jk (R1 + R2 - R)) R / (R1 + R2) sqrt(G(reflected) / G(direct)): Kerr 1951, ch. 2, seed
    eq. 12 with its sign mended (DESIGN row 5). Beyond the horizon F is 0, the shadow of ray optics: diffraction is not
    modelled, so F drops from 1 to 0 there.
    """
    geometry = specular_geometry(distance, height, antenna_height, earth_radius)
    mirror = reflected_field_ratio(geometry, wavelength, polarization, wave_height, roughness)
    if elevation_gain is not None:
        direct = np.maximum(elevation_gain(geometry.elevation_direct), LOWEST_GAIN)
        mirror = mirror * np.sqrt(elevation_gain(geometry.elevation_reflected) / direct)
    factor: Complexes = np.where(geometry.grazing > 0, 1.0 + mirror, 0.0)
    return factor


def printed_two_ray_factor(
    distance: Floats | float,
    height: Floats | float,
    antenna_height: float,
    wavelength: float,
    *,
    earth_radius: float = np.inf,
    polarization: str = "h",
    wave_height: float = 0.0,
) -> Complexes:
    """F exactly as printed, on a flat earth and blind to the beam; the specification multiplies |F|^2 onto the amplitude.

    Arguments as `two_ray_factor`; earth_radius enters D alone. Gamma, rho_s (Ament) and D are computed. Seed eq. 12.
    """
    geometry = specular_geometry(distance, height, antenna_height)
    first, second = geometry.first * np.cos(geometry.grazing), geometry.second * np.cos(geometry.grazing)
    geometry = geometry._replace(divergence=divergence(first, second, geometry.grazing, earth_radius))
    return 1.0 + reflected_field_ratio(geometry, wavelength, polarization, wave_height, ament)  # eq. 12


def reflected_field_ratio(
    geometry: SpecularGeometry, wavelength: float, polarization: str, wave_height: float, roughness: Roughness
) -> Complexes:
    """The reflected field over the direct one, antenna aside: Gamma rho_s D exp(-jk dR) R / (R1 + R2)."""
    permittivity = sea_water_permittivity(SPEED_OF_LIGHT / wavelength)
    surface = fresnel(geometry.grazing, permittivity, polarization) * roughness(geometry.grazing, wave_height, wavelength)
    spread = geometry.direct / (geometry.first + geometry.second)
    mirror: Complexes = surface * geometry.divergence * np.exp(-2j * np.pi / wavelength * geometry.excess) * spread
    return mirror


def _reflection_point(d: Floats, h: Floats, antenna_height: float, earth_radius: float) -> Floats:
    """Distance from the antenna to where the ray meets the sea [m]: 2x^3 - 3dx^2 + (d^2 - 2ae(h1 + h2))x + 2ae h1 d = 0."""
    flat: Floats = d * antenna_height / (antenna_height + h)
    if np.isinf(earth_radius):
        return flat
    p = 2.0 / np.sqrt(3.0) * np.sqrt(earth_radius * (antenna_height + h) + d**2 / 4.0)
    sine = np.clip(2.0 * earth_radius * d * (h - antenna_height) / p**3, -1.0, 1.0)
    x: Floats = d / 2.0 - p * np.sin(np.arcsin(sine) / 3.0)
    return np.clip(x, 0.0, d)
