"""Targets of known cross-section, against textbook values."""

import numpy as np
import pytest

from radar_service.propagation.sea_surface import sea_water_permittivity
from radar_service.study.chart.canonical_targets import (
    ANTENNA_HEIGHT,
    DISTANCE,
    HIDDEN,
    LONG,
    NEAR,
    SIDE,
    CanonicalTarget,
    across,
    canonical_targets,
    near_across,
    plates,
)
from tests.reference import metal_on_water as oracle
from tests.reference.metal_on_water import LIGHT, Face, Screen, Setting


def test_cross_sections_of_the_canonical_targets() -> None:
    """Textbook values in wavelengths, r = 4, a = 20: pi r^2; 2 pi r a^2; 4 pi a^4; 8 pi a^4; 4 pi a^4 / 3, of lambda^2."""
    targets = canonical_targets(0.03)
    facing = {target.name: float(target.cross_section(np.zeros(1))[0]) for target in targets}
    textbook = {"sphere": np.pi * 16, "cylinder": np.pi * 3200, "plate": 4 * np.pi * 160_000, "dihedral": 8 * np.pi * 160_000,
                "trihedral": 4 * np.pi * 160_000 / 3}  # fmt: skip
    assert facing == {name: pytest.approx(value * 0.0009, rel=1e-9) for name, value in textbook.items()}
    assert facing == {target.name: target.facing for target in targets}


FREE = Setting(sea=False, earth_radius=np.inf)
WAVELENGTH = FREE.wavelength
SIDE_M, LONG_M = SIDE * WAVELENGTH, LONG * WAVELENGTH
SHARES = np.array([-1.0, -0.6, 0.0, 0.3, 1.0])  # of a target's largest turn


def target(name: str, polarization: str = "h") -> CanonicalTarget:
    return next(plate for plate in plates(WAVELENGTH, polarization) if plate.name == name)


def summed(plate: list[Face], turn: float, distance: float, middle: float, setting: Setting, *screens: Screen) -> float:
    """Cross-section [m^2] of a plate to the north."""
    faces = [oracle.placed(face, np.array([0.0, distance, middle]), np.pi + turn) for face in plate]
    return abs(oracle.scattering_amplitude(faces, setting, distance, screens)) ** 2


@pytest.mark.parametrize("polarization", ["h", "v"])
def test_a_plate_that_stands_on_the_sea(polarization: str) -> None:
    """1e-3: rays rise by up to 0.018 rad, whose square is 3e-4."""
    plate, permittivity = target("plate over the sea", polarization), sea_water_permittivity(LIGHT / WAVELENGTH)
    setting = Setting(
        antenna_height=ANTENNA_HEIGHT, polarization=polarization, permittivity=permittivity, earth_radius=np.inf
    )
    turns = SHARES * plate.max_turn
    exact = [summed(oracle.plate(SIDE_M, LONG_M), t, DISTANCE, LONG_M / 2, setting) for t in turns]
    np.testing.assert_allclose(plate.cross_section(turns), exact, rtol=1e-3)
    assert plate.cross_section(np.zeros(1))[0] < 0.8 * plate.facing * 16.0  # lobes: not four times the field everywhere


def test_a_plate_behind_a_screen() -> None:
    """1e-4: the shadow's edge moves by 1e-6 of the width, and so do the cubes of small lengths over the distance."""
    plate = target("plate behind a screen")
    assert plate.screen is not None
    mesh, share, aside = plate.screen
    size = np.ptp(mesh.vertices, axis=0)
    assert size[2] > 2 * SIDE_M * share  # higher than the plate as the antenna sees it: the wall below may be any higher
    low = np.array([aside - size[0] / 2, share * DISTANCE, 0.0])  # east is to the right
    screen = Screen(low, np.array([size[0], 0.0, 0.0]), np.array([0.0, 0.0, 2 * oracle.UPRIGHT]))
    turns = SHARES * plate.max_turn
    exact = [summed(oracle.plate(SIDE_M, SIDE_M), t, DISTANCE, FREE.antenna_height, FREE, screen) for t in turns]
    np.testing.assert_allclose(plate.cross_section(turns), exact, rtol=1e-3)
    assert plate.cross_section(np.zeros(1))[0] == pytest.approx((1.0 - HIDDEN) ** 2 * plate.facing, rel=1e-2)


@pytest.mark.parametrize(("name", "distance"), [("plate near by", NEAR * WAVELENGTH), ("turning plate", DISTANCE)])
def test_a_long_plate_near_by_and_far_off(name: str, distance: float) -> None:
    """1e-3 of the strongest: obliquity changes by 0.02 rad, times a turn of 0.04, along the near plate."""
    plate = target(name)
    turns = SHARES * plate.max_turn
    exact = np.array([summed(oracle.plate(LONG_M, SIDE_M), t, distance, FREE.antenna_height, FREE) for t in turns])
    np.testing.assert_allclose(plate.cross_section(turns), exact, atol=2e-3 * exact.max())
    assert plate.distance == distance and (plate.rate > 0.0) == (name == "turning plate")


def test_far_off_the_fresnel_integrals_are_a_sinc() -> None:
    """1e-5: k W^2 / 4R."""
    turn = np.array([0.0, 0.01, -0.05])
    result = near_across(turn, -0.5, 0.5, 1e7, WAVELENGTH)
    np.testing.assert_allclose(np.abs(result), np.abs(across(turn, 1.0, WAVELENGTH)), atol=1e-5)
