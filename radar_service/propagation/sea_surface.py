"""Reflection by the sea: permittivity of sea water, Fresnel coefficients, roughness, wave height by sea state."""

from functools import lru_cache

import numpy as np
from scipy.special import i0e

from radar_service.numerics import Complexes, Floats
from radar_service.world import significant_wave_height

# exp(-x) I0(x) sqrt(1 + x) at even steps of x / (1 + x), between which it is linear within 2e-9 of itself; and its rises
_STEPS = 2**14
_LESS = np.arange(_STEPS) / (_STEPS - np.arange(_STEPS))
_BESSEL = np.append(i0e(_LESS) * np.sqrt(1.0 + _LESS), 1.0 / np.sqrt(2.0 * np.pi))
_RISE = np.append(np.diff(_BESSEL), 0.0)


def rms_wave_height(sea_state: float) -> float:
    """Standard deviation of the surface [m] for a sea state of 0 to 9: a quarter of H_1/3; else ValueError."""
    return significant_wave_height(sea_state) / 4.0


@lru_cache(maxsize=16)  # a radar asks for its own frequency at each block of azimuths
def sea_water_permittivity(frequency: float, temperature_c: float = 15.0, salinity: float = 35.0) -> complex:
    """Complex relative permittivity e' - j e'' of sea water, exp(+j w t).

    frequency: up to 400e9 [Hz]; temperature_c: -2 to 34 [degrees C]; salinity: 0 to 40 [parts per thousand]. Two Debye
    relaxations and conductivity: Meissner and Wentz, IEEE TGRS 42 (2004), its salinity terms as revised in TGRS 50 (2012).
    """
    t, s, f = temperature_c, salinity, frequency / 1e9
    static = (3.70886e4 - 82.168 * t) / (421.854 + t) * np.exp(-3.33330e-3 * s + 4.74868e-6 * s**2)
    middle = (5.7230 + 2.2379e-2 * t - 7.1237e-4 * t**2) * np.exp(-6.28908e-3 * s + 1.76032e-4 * s**2 - 9.22144e-5 * s * t)
    high = (3.6143 + 2.8841e-2 * t) * (1.0 + s * (-2.04265e-3 + 1.57883e-4 * t))
    shift = 1.0 + s * np.polyval((8.9795e-9, -3.5594e-7, 3.6764e-6, -7.9208e-5, 2.3232e-3), min(t, 30.0))
    first = (45.0 + t) / (5.0478 - 7.0315e-2 * t + 6.0059e-4 * t**2) * shift
    second = (45.0 + t) / (0.13652 + 1.4825e-3 * t + 2.4166e-4 * t**2)
    second *= 1.0 + s * (-1.99723e-2 + 0.5 * 1.81176e-4 * (t + 30.0))
    conduction = _conductivity(t, s) * 17.97510 / f  # 1 / (2 pi e0) [GHz m / S]
    debye = (static - middle) / (1.0 + 1j * f / first) + (middle - high) / (1.0 + 1j * f / second)
    return complex(debye + high - 1j * conduction)


def _conductivity(t: float, s: float) -> float:
    """Conductivity of sea water [S/m] at t [degrees C] and salinity s (Stogryn et al. 1995, as Meissner and Wentz 2004)."""
    at_35 = np.polyval((4.3047e-9, -2.9910e-6, 4.738817e-4, 8.60700e-2, 2.903602), t)
    at_15_c = s * (37.5109 + 5.45216 * s + 1.4409e-2 * s**2) / (1004.75 + 182.283 * s + s**2)
    alpha0 = (6.9431 + 3.2841 * s - 9.9486e-2 * s**2) / (84.850 + 69.024 * s + s**2)
    alpha1 = 49.843 - 0.2276 * s + 1.98e-3 * s**2
    return float(at_35 * at_15_c * (1.0 + (t - 15.0) * alpha0 / (alpha1 + t)))


def fresnel(grazing: Floats | float, permittivity: Floats | complex, polarization: str) -> Complexes:
    """Complex reflection coefficient of a smooth plane, exp(+j w t): near -1 at grazing for both polarizations.

    grazing: any shape, 0 to pi/2 [rad]; permittivity: e' - j e''; polarization: "h" or "v", else ValueError. V is
    the field component normal to the ray in the plane of incidence (Kerr 1951, ch. 5).
    """
    sine = np.sin(np.asarray(grazing, dtype=np.float64))
    square = permittivity - (1.0 - sine * sine) + 0j
    real = np.sqrt((np.abs(square) + square.real) / 2.0)  # a complex root takes three times as long
    refracted = real + 0.5j * square.imag / np.where(real > 0.0, real, 1.0)
    if polarization == "h":
        reflected: Complexes = (sine - refracted) / (sine + refracted)
    elif polarization == "v":
        reflected = (permittivity * sine - refracted) / (permittivity * sine + refracted)
    else:
        raise ValueError(f'polarization: "{polarization}" is not one of h, v')
    return reflected


def ament(grazing: Floats | float, wave_height: Floats | float, wavelength: float) -> Floats:
    """Specular roughness factor exp(-g^2 / 2), g = 4 pi sigma_h sin(psi) / lambda (W. S. Ament, 1953).

    grazing: any shape [rad]; wave_height: rms [m]; wavelength: [m]. From 1 (smooth) to 0; too low for g above about 1.5.
    """
    return np.exp(-0.5 * _rayleigh_roughness(grazing, wave_height, wavelength) ** 2)


def miller_brown(grazing: Floats | float, wave_height: Floats | float, wavelength: float) -> Floats:
    """Specular roughness factor exp(-g^2 / 2) I0(g^2 / 2): Ament corrected for real seas (Miller, Brown, Vegh 1984).

    Arguments as `ament`. From 1 (smooth) to 0, always at least Ament's.
    """
    x = 0.5 * _rayleigh_roughness(grazing, wave_height, wavelength) ** 2
    step = x * _STEPS / (1.0 + x)
    entry = step.astype(np.intp)
    return np.asarray((_BESSEL.take(entry) + (step - entry) * _RISE.take(entry)) / np.sqrt(1.0 + x))


def _rayleigh_roughness(grazing: Floats | float, wave_height: Floats | float, wavelength: float) -> Floats:
    return 4.0 * np.pi * wave_height * np.sin(np.asarray(grazing, dtype=np.float64)) / wavelength
