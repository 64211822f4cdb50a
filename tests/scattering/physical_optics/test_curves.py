"""Built-in spheres and cylinders by physical optics against closed forms: 0.2 dB over sizes, aspects, ranges and wavelengths.

The closed forms are those of physical optics itself, at any size.
"""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import jv, struve

import radar_service as rs
from tests.scattering.physical_optics.meshes import cross_section, decibels, optical

Floats = NDArray[np.float64]
LIGHT = 299_792_458.0
TOLERANCE = 0.2  # dB: required
SHARE = 10.0 ** (TOLERANCE / 20.0) - 1.0  # the same of an amplitude
DRAWS = [*range(8), *(pytest.param(seed, marks=pytest.mark.study) for seed in range(8, 16))]


def sphere_section(radius: float, wavelength: float) -> float:
    """Cross-section [m^2] of a sphere: the integral of physical optics over the lit half, which tends to pi a^2."""
    x = 4.0 * np.pi * radius / wavelength
    integral = 2.0 * np.pi * radius**2 * (np.exp(1j * x) / (1j * x) + (np.exp(1j * x) - 1.0) / x**2)
    return float(4.0 * np.pi / wavelength**2 * abs(integral) ** 2)


def broadside_section(radius: float, height: float, wavelength: float) -> float:
    """Cross-section [m^2] of an upright cylinder, level aspect: the integral of physical optics over the lit half.

    It holds Bessel's and Struve's functions (Abramowitz and Stegun 1964, 12.1.7) and tends to 2 pi a h^2 / lambda.
    """
    x = 4.0 * np.pi * radius / wavelength
    around = np.pi * radius * (2.0 / np.pi - struve(1, x) + 1j * jv(1, x))
    return float(4.0 * np.pi / wavelength**2 * abs(height * around) ** 2)


def seen_from(frequency: float, antenna: Floats, **body: Any) -> float:
    """Cross-section [m^2] of a built-in shape toward an antenna in the body's frame."""
    made = {"name": "b", "scattering": "optics", "position_m": [0, 1000, 0], **body}
    return cross_section(optical(rs.load_scene({"radar": {"frequency_hz": frequency}, "body": [made]}), 1), antenna)


def around(bearing: float, elevation: float, distance: float) -> Floats:
    level = distance * math.cos(elevation)
    return np.array([level * math.sin(bearing), level * math.cos(bearing), distance * math.sin(elevation)])


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", DRAWS)
def test_a_sphere_has_its_cross_section_from_anywhere(seed: int) -> None:
    """Radius 10 to 30 wavelengths at 3 to 35 GHz, elevation up to 30 degrees, 2 to 20 km."""
    rng = np.random.default_rng([8, seed])
    frequency = math.exp(rng.uniform(math.log(3e9), math.log(35e9)))
    radius = math.exp(rng.uniform(math.log(10), math.log(30))) * LIGHT / frequency
    antenna = around(rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-0.5, 0.5), rng.uniform(2e3, 2e4))
    section = seen_from(frequency, antenna, shape="sphere", radius_m=radius)
    assert decibels(section / sphere_section(radius, LIGHT / frequency)) == pytest.approx(0.0, abs=TOLERANCE)


@pytest.mark.parametrize("seed", DRAWS)
def test_a_cylinder_has_its_cross_section_broadside(seed: int) -> None:
    """Radius 5 to 200 wavelengths, height 2 to 60 wavelengths, any bearing; the phase bends by 0.06 rad over the height."""
    rng = np.random.default_rng([9, seed])
    frequency = math.exp(rng.uniform(math.log(3e9), math.log(35e9)))
    wavelength = LIGHT / frequency
    radius, height = (math.exp(rng.uniform(math.log(low), math.log(high))) * wavelength for low, high in ((5, 200), (2, 60)))
    antenna = around(rng.uniform(0.0, 2.0 * np.pi), 0.0, 2e5 * wavelength) + (0.0, 0.0, height / 2.0)
    section = seen_from(frequency, antenna, shape="cylinder", radius_m=radius, height_m=height)
    near = radius / (2e5 * wavelength)  # the wave is cylindrical by so much: at most 0.01 dB
    exact = broadside_section(radius, height, wavelength) * (1.0 + near)
    assert decibels(section / exact) == pytest.approx(0.0, abs=TOLERANCE)


@pytest.mark.sample(4)
@pytest.mark.parametrize("seed", DRAWS)
def test_a_cylinder_has_its_pattern_off_broadside(seed: int) -> None:
    """Elevations up to the third sidelobe. Near nulls the error is one of the rms over a lobe, which falls off as 1 / (pi u)."""
    rng = np.random.default_rng([10, seed])
    wavelength = LIGHT / 9.41e9
    radius, height, u = rng.uniform(0.1, 5.0), rng.uniform(1.0, 3.0), rng.uniform(0.0, 3.5)
    elevation = math.asin(u * wavelength / (2.0 * height))
    antenna = around(rng.uniform(0.0, 2.0 * np.pi), elevation, 2e4) + (0.0, 0.0, height / 2.0)
    section = seen_from(9.41e9, antenna, shape="cylinder", radius_m=radius, height_m=height)
    peak = math.sqrt(broadside_section(radius, height, wavelength)) * math.cos(elevation) ** 0.5
    lobe = math.sqrt(0.5) / (math.pi * max(u, 0.5))
    error = abs(math.sqrt(section) / peak - abs(np.sinc(u)))
    assert error < SHARE * max(abs(np.sinc(u)), lobe)
