"""Multipath: the ray that the sea reflects, beside the direct one.

Positions are as in `frames`: a distance along the earth and a height above the sea, whose surface is z = -d^2 / (2 ae).
Phases follow exp(+j w t): a path of length R multiplies the field by exp(-j k R).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.propagation.sea_surface import ament, fresnel, miller_brown, sea_water_permittivity
from radar_service.types import Complexes, Floats, Gain

Roughness = Callable[[Floats, float, float], Floats]  # grazing angle, rms wave height, wavelength -> factor

_TINY = 1e-300  # m^2: avoids 0 / 0 for a target at the foot of the antenna
MIN_GAIN = 1e-12  # -120 dB: a lower direct gain counts as this one, so that the ratio stays finite in a null of the beam


def wavelength(frequency: float) -> float:
    """Free-space wavelength [m] of a frequency [Hz], 0.03186 m at 9.41 GHz. Source: docs/specification.md eq. 1."""
    return SPEED_OF_LIGHT / frequency  # eq. 1


class SpecularGeometry(NamedTuple):
    """Direct and reflected ray, arrays of one shape; elevations are from horizontal, at the antenna.

    direct: R, length of the direct ray [m].
    first: R1, from antenna to sea [m].
    second: R2, from sea to target [m].
    excess: R1 + R2 - R [m].
    grazing: angle at the sea [rad]; negative below the horizon, where the other fields have no meaning.
    divergence: factor D of the curved surface, 1 on a flat one.
    elevation_direct: of the direct ray [rad].
    elevation_reflected: of the reflected ray [rad].
    """

    direct: Floats
    first: Floats
    second: Floats
    excess: Floats
    grazing: Floats
    divergence: Floats
    elevation_direct: Floats
    elevation_reflected: Floats


def specular_geometry(
    distance: Floats | float, height: Floats | float, antenna_height: float, earth_radius: float = np.inf
) -> SpecularGeometry:
    """Geometry of the specular reflection between an antenna and targets over a flat sea or over z = -d^2 / (2 ae).

    distance: along the earth, any shape [m]; height: of the target above the sea, negative ones count as 0 [m];
    antenna_height: above the sea, positive [m]; earth_radius: effective radius ae [m], inf for flat. The reflection point
    solves the cubic of Kerr (Propagation of Short Radio Waves, 1951, ch. 2); by Fermat its error enters in second order.
    """
    d, h = np.broadcast_arrays(np.asarray(distance, np.float64), np.maximum(np.asarray(height, np.float64), 0.0))
    x = _reflection_point(d, h, antenna_height, earth_radius)
    beyond = d - x
    rise_1 = antenna_height + x**2 / (2.0 * earth_radius)
    drop = d**2 / (2.0 * earth_radius)
    rise_2 = h - drop + x**2 / (2.0 * earth_radius)
    z = h - drop - antenna_height
    direct, first, second = np.hypot(d, z), np.hypot(x, rise_1), np.hypot(beyond, rise_2)
    above_tangent = antenna_height - x**2 / (2.0 * earth_radius)
    grazing = np.arctan2(above_tangent, x)
    # R1 + R2 - R without the difference of large lengths: it is millimetres, and k times it must be accurate to 1e-6 rad
    cross = (x * rise_2) ** 2 + (beyond * rise_1) ** 2 + (rise_1 * rise_2) ** 2
    gap = 2.0 * (rise_1 * rise_2 + cross / (first * second + x * beyond + _TINY))
    excess = gap / (first + second + direct)
    return SpecularGeometry(
        direct, first, second, excess, grazing, divergence(x, beyond, grazing, earth_radius),
        np.arctan2(z, d), np.arctan2(-rise_1, x),
    )  # fmt: skip


def divergence(first: Floats, second: Floats, grazing: Floats, earth_radius: float) -> Floats:
    """Divergence factor D of a ray reflected by the curved sea, from 1 (flat) to 0 at the horizon.

    first, second: ground distances from antenna and target to the reflection point [m]; grazing: [rad], D is 0 where it is
    not positive; earth_radius: ae [m], inf for flat. D = (1 + 2 d1 d2 / (ae d sin psi))^-1/2 (Kerr 1951, ch. 5).
    """
    d = first + second
    sine = np.sin(grazing)
    above = sine > 0
    split = np.divide(first * second, d * sine, out=np.zeros_like(d), where=above & (d > 0))
    factor: Floats = np.where(above, 1.0 / np.sqrt(1.0 + 2.0 * split / earth_radius), 0.0)
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
    """Field at each target relative to that of the direct ray alone, F; the amplitude of an echo gets the complex factor F^2.

    distance: along the earth, any shape [m]; height: above the sea [m]; antenna_height, wavelength: [m]; earth_radius: ae
    [m]; polarization: "h" or "v"; wave_height: rms of the sea [m]; elevation_gain: one-way power gain at an elevation from
    horizontal; None: isotropic; its root counts as positive, so the sign of sidelobes is lost.
    F = 1 + Gamma rho_s D exp(-jk (R1 + R2 - R)) R / (R1 + R2) sqrt(G(reflected) / G(direct)): Kerr 1951, ch. 2,
    docs/specification.md eq. 12 with corrected sign (docs/specification.md, errata row 5). Beyond the horizon F is 0, the
    shadow of ray optics: diffraction is not modelled.
    """
    geometry = specular_geometry(distance, height, antenna_height, earth_radius)
    reflected = reflected_field_ratio(geometry, wavelength, polarization, wave_height, roughness)
    if elevation_gain is not None:
        direct = np.maximum(elevation_gain(geometry.elevation_direct), MIN_GAIN)
        reflected = reflected * np.sqrt(elevation_gain(geometry.elevation_reflected) / direct)
    factor: Complexes = np.where(geometry.grazing > 0, 1.0 + reflected, 0.0)
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
    """F exactly as printed, on a flat earth and without the beam; the specification multiplies the amplitude by |F|^2.

    Arguments as `two_ray_factor`; earth_radius affects D alone. Gamma, rho_s (Ament) and D are computed.
    docs/specification.md eq. 12.
    """
    geometry = specular_geometry(distance, height, antenna_height)
    first, second = geometry.first * np.cos(geometry.grazing), geometry.second * np.cos(geometry.grazing)
    geometry = geometry._replace(divergence=divergence(first, second, geometry.grazing, earth_radius))
    return 1.0 + reflected_field_ratio(geometry, wavelength, polarization, wave_height, ament)  # eq. 12


def reflected_field_ratio(
    geometry: SpecularGeometry, wavelength: float, polarization: str, wave_height: float, roughness: Roughness
) -> Complexes:
    """The reflected field over the direct one, without antenna gains: Gamma rho_s D exp(-jk dR) R / (R1 + R2)."""
    permittivity = sea_water_permittivity(SPEED_OF_LIGHT / wavelength)
    surface = fresnel(geometry.grazing, permittivity, polarization) * roughness(geometry.grazing, wave_height, wavelength)
    spreading = geometry.direct / (geometry.first + geometry.second)
    phase = np.exp(-2j * np.pi / wavelength * geometry.excess)
    ratio: Complexes = surface * geometry.divergence * phase * spreading
    return ratio


def _reflection_point(d: Floats, h: Floats, antenna_height: float, earth_radius: float) -> Floats:
    """Distance from the antenna to the reflection point [m]: 2x^3 - 3dx^2 + (d^2 - 2ae(h1 + h2))x + 2ae h1 d = 0."""
    flat: Floats = d * antenna_height / (antenna_height + h)
    if np.isinf(earth_radius):
        return flat
    p = 2.0 / np.sqrt(3.0) * np.sqrt(earth_radius * (antenna_height + h) + d**2 / 4.0)
    sine = np.clip(2.0 * earth_radius * d * (h - antenna_height) / p**3, -1.0, 1.0)
    x: Floats = d / 2.0 - p * np.sin(np.arcsin(sine) / 3.0)
    return np.clip(x, 0.0, d)
