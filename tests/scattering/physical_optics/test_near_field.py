"""A large plate near by, where it is no plane wave's target any more."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import fresnel

from tests.scattering.physical_optics.meshes import WAVELENGTH, cross_section, decibels, loaded, optical, plate

K = 2 * np.pi / WAVELENGTH
SIDE = 5.0


def fresnel_section(distance: float, aside: float, up: float) -> float:
    """Cross-section [m^2] of a square plate seen from (aside, distance, up) over its middle: the product of two
    Fresnel integrals of exp(-j k (x - x0)^2 / R), the two-way path to second order (Born and Wolf, 1999, section
    8.8.1)."""
    scale = np.sqrt(2 * K / (np.pi * distance))

    def strip(offset: float) -> complex:
        s, c = fresnel(scale * (np.array([-SIDE / 2, SIDE / 2]) - offset))
        return complex(((c[1] - c[0]) - 1j * (s[1] - s[0])) / scale)

    return float(4 * np.pi / WAVELENGTH**2 * abs(strip(aside) * strip(up)) ** 2)


def summed_section(distance: float, aside: float, up: float) -> float:
    """The same by adding a million small patches at their exact distances."""
    x: NDArray[np.float64] = (np.arange(1000) + 0.5) / 1000 * SIDE - SIDE / 2
    r = np.sqrt(distance**2 + (x[:, None] - aside) ** 2 + (x - up) ** 2)
    origin = np.sqrt(distance**2 + aside**2 + up**2)
    field = np.sum(distance / r * (origin / r) ** 2 * np.exp(-2j * K * (r - origin))) * (SIDE / 1000) ** 2
    return float(4 * np.pi / WAVELENGTH**2 * abs(field) ** 2)


@pytest.mark.sample(5)
@pytest.mark.parametrize("distance", [100.0, 200.0, 400.0, 1000.0])
@pytest.mark.parametrize("aside, up", [(0.0, 0.0), (1.0, 0.3), (2.4, -0.5)])
def test_five_metres_of_plate_from_100_to_1000_m(tmp_path: Path, distance: float, aside: float, up: float) -> None:
    """Within 0.5 dB of the Fresnel integrals and of brute force, in front of the plate, where it is brightest; its far field
    begins at 3.1 km only. Both references agree to 0.05 dB where path differences of fourth order stay below 0.1 rad."""
    exact = summed_section(distance, aside, up)
    assert decibels(fresnel_section(distance, aside, up) / exact) == pytest.approx(0.0, abs=0.05)
    for n in (1, 4):
        body = optical(loaded(tmp_path, plate(SIDE, SIDE, n)))
        computed = cross_section(body, np.array([aside, distance, up]))
        assert decibels(computed / exact) == pytest.approx(0.0, abs=0.5)


def test_near_limit_is_the_mirror_image(tmp_path: Path) -> None:
    """So near that the plate spans many Fresnel zones it is a mirror: pi R^2, within the ripple of its edges (1 dB at
    20 m)."""
    body = optical(loaded(tmp_path, plate(SIDE, SIDE, 1)))
    assert decibels(cross_section(body, np.array([0.4, 20.0, 0.3]))) == pytest.approx(decibels(np.pi * 400), abs=1.0)
