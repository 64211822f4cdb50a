"""The oracle of metal on the water against closed forms, and against itself with finer elements."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import fresnel

from tests.propagation.test_two_ray_engine import reference_factor
from tests.reference import metal_on_water as oracle
from tests.reference.metal_on_water import EARTH, Face, Screen, Setting, scattering_amplitude

FREE = Setting(sea=False, earth_radius=np.inf)
WAVELENGTH, K = FREE.wavelength, FREE.wavenumber
FLAT = Setting(earth_radius=np.inf)
MIRROR = -1e12j  # permittivity of a sea that reflects all


def at(faces: list[Face], east: float, north: float, up: float, heading: float = np.pi) -> list[Face]:
    """Faces placed on the map, their own +y to the antenna by default."""
    return [oracle.placed(face, np.array([east, north, up]), heading) for face in faces]


def facing(faces: list[Face], distance: float, up: float, setting: Setting, **options: object) -> float:
    """Cross-section [m^2] of faces to the north at a height."""
    r = oracle.slant_range(np.array([0.0, distance, up]), setting)
    return abs(scattering_amplitude(at(faces, 0.0, distance, up), setting, r, **options)) ** 2  # type: ignore[arg-type]


@pytest.mark.parametrize("size", [None, WAVELENGTH / 8])
@pytest.mark.parametrize("polarization", ["h", "v"])
def test_a_plate_square_on(polarization: str, size: float | None) -> None:
    """4 pi A^2 / lambda^2; at 10 km the wave bends by k D^2 / 2R = 0.02 rad over 1 m, whose square is 4e-4."""
    setting = Setting(sea=False, earth_radius=np.inf, polarization=polarization)
    result = facing(oracle.plate(1.0, 0.6), 10_000.0, 15.0, setting, size=size)
    assert result == pytest.approx(4 * np.pi * 0.36 / WAVELENGTH**2, rel=1e-3)


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("aspect_deg", [0.5, 1.7, 5.0, 30.0, 75.0])
def test_the_pattern_of_a_plate(polarization: str, aspect_deg: float) -> None:
    """4 pi A^2 / lambda^2 cos^2 sinc^2(k D sin) of Knott, Shaeffer, Tuley; at 100 km the near field is 1e-5 of the peak's
    amplitude."""
    aspect, width = np.deg2rad(aspect_deg), 0.503
    setting = Setting(sea=False, earth_radius=np.inf, polarization=polarization)
    faces = at(oracle.plate(width, 0.4), 0.0, 1e5, 15.0, np.pi + aspect)
    result = abs(scattering_amplitude(faces, setting, 1e5))
    peak = 2 * np.sqrt(np.pi) / WAVELENGTH * width * 0.4
    exact = peak * np.cos(aspect) * abs(np.sinc(K * width * np.sin(aspect) / np.pi))
    assert result == pytest.approx(exact, abs=2e-5 * peak)


def test_the_near_field_of_a_plate() -> None:
    """Born and Wolf's product of Fresnel integrals, to second order: 5 m at 200 m err by k D^4 / 64 R^3 = 2e-4 rad."""

    def strip(offset: float) -> complex:
        scale = np.sqrt(2 * K / (np.pi * 200.0))
        s, c = fresnel(scale * (np.array([-2.5, 2.5]) - offset))
        return complex(((c[1] - c[0]) - 1j * (s[1] - s[0])) / scale)

    for aside in (0.0, 1.0, 2.4):
        faces = at(oracle.plate(5.0, 5.0), aside, 200.0, 15.0)
        exact = 2 * np.sqrt(np.pi) / WAVELENGTH * abs(strip(aside) * strip(0.0))
        assert abs(scattering_amplitude(faces, FREE, 200.0)) == pytest.approx(
            exact, rel=3e-3
        )  # spreading, obliquity: D^2/R^2


@pytest.mark.parametrize("earth_radius", [EARTH, np.inf])
@pytest.mark.parametrize("height", [0.5, 3.0, 25.0])
@pytest.mark.parametrize("distance", [60.0, 700.0, 4000.0])
def test_the_sea_reflects_at_the_shortest_path(distance: float, height: float, earth_radius: float) -> None:
    """Fermat: equal angles give the least length; found by search to 1e-10 of it."""
    setting = Setting(earth_radius=earth_radius)

    def length(x: float) -> float:
        foot, top = -(x**2) / (2 * earth_radius), height - distance**2 / (2 * earth_radius)
        return float(np.hypot(x, 15.0 - foot) + np.hypot(distance - x, top - foot))

    shortest = minimize_scalar(length, bounds=(0.0, distance), method="bounded", options={"xatol": 1e-6}).fun
    found = oracle.sea_rays(np.array([[0.0, distance, height]]), setting).length[0]
    assert found == pytest.approx(shortest, rel=1e-10)


def test_bessel_is_scipys() -> None:
    from scipy.special import i0e

    x = np.geomspace(1e-3, 1e4, 200)
    assert np.abs(oracle.scaled_bessel(x) / i0e(x) - 1).max() < 1e-7  # the series' next term at 50


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("sea_state", [0, 3, 5])
@pytest.mark.parametrize("distance", [300.0, 1500.0, 6000.0])
def test_the_two_ray_factor_is_that_of_fermats_path(distance: float, sea_state: int, polarization: str) -> None:
    """Fresnel, roughness, divergence and lengths of another reference, which finds the path by search to a millimetre: 1e-5."""
    setting = Setting(polarization=polarization, sea_state=sea_state)
    factor = oracle.two_ray_field(np.array([[0.0, distance, 10.0]]), setting)[0] ** 2
    exact = reference_factor(distance, polarization, {0: 0.0, 3: 1.0445 / 4, 5: 2.9765 / 4}[sea_state])
    assert abs(factor - exact) < 1e-4 * 4.0


def test_half_power_of_the_vertical_beam() -> None:
    """The one-way power gain is a half at half the beamwidth, so the way there has root half."""
    setting = Setting(beamwidth_el=np.deg2rad(20.0))
    assert oracle.vertical_gain(np.deg2rad(np.array([0.0, 10.0, -10.0])), setting) == pytest.approx([1, 0.5**0.5, 0.5**0.5])


@pytest.mark.parametrize("polarization", ["h", "v"])
def test_a_small_plate_has_the_square_of_the_two_ray_factor(polarization: str) -> None:
    """F = 1 - exp(-jk dR) R / R' over a flat sea that reflects all; a plate of 1 cm at 15 m from 1 km turns x by 2e-3 rad. With
    vertical polarization the sea's coefficient is +1 there."""
    setting = Setting(earth_radius=np.inf, permittivity=MIRROR, polarization=polarization)
    for up in (2.3, 8.0, 14.9):
        r, mirrored = np.hypot(1000.0, up - 15.0), np.hypot(1000.0, up + 15.0)
        sign = -1.0 if polarization == "h" else 1.0
        factor = 1.0 + sign * np.exp(-1j * K * (mirrored - r)) * r / mirrored
        ratio = facing(oracle.plate(0.01, 0.01), 1000.0, up, setting) / facing(oracle.plate(0.01, 0.01), 1000.0, up, FREE)
        assert np.sqrt(ratio) == pytest.approx(
            abs(factor) ** 2, abs=2e-3
        )  # 4 x (1 - cos 0.03): directions differ by 30 mrad


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("size", [None, WAVELENGTH / 8])
def test_a_plate_on_a_perfect_sea_is_a_dihedral(polarization: str, size: float | None) -> None:
    """By images: 2 W (H -+ sin(2kH sin psi) / (2k sin psi)) cos psi, with - for horizontal; 1 m wide, 2 m high, far away."""
    distance, height = 20_000.0, 400.0
    setting = Setting(antenna_height=height, earth_radius=np.inf, permittivity=MIRROR, polarization=polarization)
    slope = height / np.hypot(distance, height)
    integral = 2.0 - np.sin(4.0 * K * slope) / (2 * K * slope) * (1.0 if polarization == "h" else -1.0)
    exact = 2 * np.sqrt(np.pi) / WAVELENGTH * 0.5 * 2.0 * integral * np.sqrt(1 - slope**2)
    result = np.sqrt(facing(oracle.plate(0.5, 2.0), distance, 1.0, setting, size=size))
    assert result == pytest.approx(exact, rel=2e-3)  # near field: (k H^2 / R)^2 / 12


def test_both_orders_over_the_sea_are_the_dihedral() -> None:
    """The paths by the sea one way alone return 4 pi (2 W H cos psi)^2 / lambda^2, as two plates at a right angle do."""
    setting = Setting(antenna_height=400.0, earth_radius=np.inf, permittivity=MIRROR)
    result = facing(oracle.plate(0.5, 2.0), 20_000.0, 1.0, setting, ways=(1,))
    assert result == pytest.approx(4 * np.pi * (2 * 0.5 * 2.0) ** 2 / WAVELENGTH**2, rel=2e-3)  # cos^2 psi = 1 - 4e-4


def bodies(seed: int) -> tuple[list[Face], Setting, np.ndarray]:
    """A random body of about 1 m, placed, and what looks at it."""
    rng = np.random.default_rng(seed)
    kind = seed % 4
    if kind == 0:
        faces = oracle.plate(rng.uniform(0.3, 1.0), rng.uniform(0.3, 1.5), rng.uniform(-0.2, 0.2))
    elif kind == 1:
        faces = oracle.prism((0.6, 0.4), (0.6, 0.4), rng.uniform(0.3, 1.0))
    elif kind == 2:
        faces = oracle.prism((0.3, 0.4), (0.5, 0.6), 0.7)
    else:
        faces = oracle.prism((0.2, 0.2), (0.1, 0.1), rng.uniform(1.0, 3.0))
    setting = Setting(
        antenna_height=rng.uniform(5, 40), polarization="hv"[seed // 2 % 2], sea_state=seed % 6, beamwidth_el=np.deg2rad(25)
    )
    position = np.array([0.0, rng.uniform(100, 2000), rng.uniform(-0.2, 2.0)])
    heading = rng.uniform(0, 2 * np.pi) if seed % 2 else np.pi + rng.uniform(-0.05, 0.05)
    return at(faces, *position, heading), setting, position


@pytest.mark.sample(3)
@pytest.mark.parametrize("seed", range(8))
def test_quadrature_is_brute_force(seed: int) -> None:
    """Elements of lambda/8 and Gauss-Legendre nodes: within 1 % of what the body returns where it is loud; lambda/16 is
    closer, by four, as equal elements err with the square of their size."""
    faces, setting, position = bodies(seed)
    r = oracle.slant_range(position, setting)
    exact, eighth, sixteenth = (
        scattering_amplitude(faces, setting, r, size=size) for size in (None, WAVELENGTH / 8, WAVELENGTH / 16)
    )
    lit = 2 * np.sqrt(np.pi) / WAVELENGTH * 0.02  # what 0.02 m^2 of plate returns
    level = max(abs(exact), lit)
    assert abs(eighth - exact) < 0.02 * level
    assert abs(sixteenth - exact) < max(0.4 * abs(eighth - exact), 1e-4 * level)


@pytest.mark.parametrize("lean", [0.0, 0.1])
def test_a_plate_in_the_water_is_the_part_above(lean: float) -> None:
    """3 m of plate whose middle is 0.7 m under water, and a plate of its part that ends at the water."""
    whole = facing(oracle.plate(2.0, 3.0, lean), 600.0, -0.7, FLAT)
    top, edge = 1.5 * np.cos(lean) - 0.7, 0.7 / np.cos(lean)
    part = oracle.plate(2.0, 1.5 - edge, lean)
    middle = (top) / 2
    shift = -(edge + (1.5 - edge) / 2) * np.sin(lean)  # along the normal's foot: the part leans back from there
    faces = at(part, 0.0, 600.0 - shift, middle)
    r = oracle.slant_range(np.array([0.0, 600.0, -0.7]), FLAT)
    assert abs(scattering_amplitude(faces, FLAT, r)) ** 2 == pytest.approx(whole, rel=1e-6)


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
