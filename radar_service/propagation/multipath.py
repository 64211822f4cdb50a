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
