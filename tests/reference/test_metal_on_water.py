"""The oracle of metal on the water: the sea, shadows, and light from below; the engine that meets it holds all else."""

import numpy as np
import pytest

from tests.propagation.test_two_ray_engine import reference_factor
from tests.reference import metal_on_water as oracle
from tests.reference.metal_on_water import Face, Screen, Setting, scattering_amplitude

WAVELENGTH = Setting().wavelength
FLAT = Setting(earth_radius=np.inf)


def at(faces: list[Face], east: float, north: float, up: float, heading: float = np.pi) -> list[Face]:
    """Faces placed on the map, their own +y to the antenna by default."""
    return [oracle.placed(face, np.array([east, north, up]), heading) for face in faces]


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("sea_state", [0, 3, 5])
@pytest.mark.parametrize("distance", [300.0, 1500.0, 6000.0])
def test_the_two_ray_factor_is_that_of_fermats_path(distance: float, sea_state: int, polarization: str) -> None:
    """Fresnel, roughness, divergence and lengths of another reference, which finds the path by search to a millimetre: 1e-5."""
    setting = Setting(polarization=polarization, sea_state=sea_state)
    factor = oracle.two_ray_field(np.array([[0.0, distance, 10.0]]), setting)[0] ** 2
    exact = reference_factor(distance, polarization, {0: 0.0, 3: 1.0445 / 4, 5: 2.9765 / 4}[sea_state])
    assert abs(factor - exact) < 1e-4 * 4.0


@pytest.mark.parametrize("sea", [True, False])
@pytest.mark.parametrize("share", [0.25, 0.6, 0.8])
def test_a_tall_wall_leaves_a_narrower_plate(share: float, sea: bool) -> None:
    """A wall half way hides a share of 1.7 m of plate on every path: what is left is a narrower plate. Elements of 1 %, cut by
    area, err by 1e-3; the row of the table is 20 log(1 - share)."""
    setting = Setting(sea=sea)
    wide = 1.7
    edge = (-wide / 2 + share * wide) / 2.0  # seen from the antenna, at half the distance
    wall = Screen(np.array([edge, 300.0, -5.0]), np.array([-50.0, 0, 0]), np.array([0.0, 0, 105.0]))
    r = oracle.slant_range(np.array([0.0, 600.0, 4.0]), setting)
    hidden = abs(scattering_amplitude(at(oracle.plate(wide, 1.0), 0.0, 600.0, 4.0), setting, r, [wall]))
    left = at(oracle.plate(wide * (1 - share), 1.0), wide * share / 2, 600.0, 4.0)
    assert hidden == pytest.approx(abs(scattering_amplitude(left, setting, r)), rel=3e-3)


def test_a_low_wall_covers_the_way_by_the_sea_first() -> None:
    """A wall of 4.3 m 30 m before a plate at 4 to 5 m, antenna at 15 m, 600 m off: the direct rays pass it at 4.5 m and more,
    the reflected ones at 4 m and less. Then only the direct path is left, and a wall of 20 m leaves nothing."""
    faces, r = at(oracle.plate(1.0, 1.0), 0.0, 600.0, 4.5), oracle.slant_range(np.array([0.0, 600.0, 4.5]), FLAT)
    low, high = (Screen(np.array([-50.0, 570.0, -5.0]), np.array([100.0, 0, 0]), np.array([0.0, 0, h])) for h in (9.3, 25.0))
    direct = abs(scattering_amplitude(faces, FLAT, r, ways=(0,)))
    assert abs(scattering_amplitude(faces, FLAT, r, [low])) == pytest.approx(direct, rel=1e-3)
    assert scattering_amplitude(faces, FLAT, r, [high]) == 0.0


@pytest.mark.sample(2)
@pytest.mark.parametrize("tall", [False, True])
@pytest.mark.parametrize("heading", [np.pi, np.pi + 0.4])
def test_quadrature_across_a_shadow_is_brute_force(tall: bool, heading: float) -> None:
    """The shadow of a wall cuts the plate on both ways; elements of lambda/8 give the same within 0.5 % of the plate's level,
    square on and 23 degrees off, where 0.5 % of the lit area is taken as that level."""
    setting = Setting(polarization="v", sea_state=2)
    faces, r = at(oracle.plate(2.0, 3.0), 0.0, 400.0, 2.5, heading), oracle.slant_range(np.array([0.0, 400.0, 2.5]), setting)
    wall = Screen(np.array([-50.0, 380.0, -5.0]), np.array([100.0, 0, 0]), np.array([0.0, 0, 7.0]))
    if tall:
        wall = Screen(np.array([0.3, 380.0, -5.0]), np.array([100.0, 0, 0]), np.array([0.0, 0, 105.0]))
    quick = scattering_amplitude(faces, setting, r, [wall])
    brute = scattering_amplitude(faces, setting, r, [wall], size=WAVELENGTH / 8)
    level = 2 * np.sqrt(np.pi) / WAVELENGTH * 6.0 * 5e-3
    assert abs(quick - brute) < 5e-3 * max(abs(brute), level)


def test_overhangs_are_lit_from_below() -> None:
    """A flare of 10 degrees, lower than the antenna: the direct ray grazes past its under side, the sea lights it."""
    flare = Face(np.array([(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), (0.5, -1.0, 0.2), (-0.5, -1.0, 0.2)]))
    faces = [oracle.placed(flare, np.array([0.0, 150.0, 1.0]), 0.0)]
    r = oracle.slant_range(np.array([0.0, 150.0, 1.0]), Setting(antenna_height=40.0))
    setting = Setting(antenna_height=40.0)
    assert scattering_amplitude(faces, setting, r, ways=(0, 1)) == 0.0
    assert abs(scattering_amplitude(faces, setting, r, ways=(2,))) > 0.0
