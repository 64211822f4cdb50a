"""What structures reflect against closed forms, and against the series of a metal cylinder for each element of the aperture."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.radar.aperture import Aperture, aperture_of
from radar_service.radar.patterns import PATTERNS
from radar_service.stages.structures.reflection import LitStructure, near_field, ray_by
from radar_service.stages.structures.structure import Structure
from tests.reference.cylinder_shadow import direction, elements, past_cylinder, received

WAVELENGTH, BEAMWIDTH = 0.03186, np.radians(0.95)
WAVENUMBER = 2.0 * np.pi / WAVELENGTH
MAST, FUNNEL = Structure("mast", 0.3, 2.5, 0.15), Structure("funnel", 0.3, 10.0, 1.5)


def aperture(pattern: str = "cosine") -> Aperture:
    made = aperture_of(PATTERNS[pattern], BEAMWIDTH, WAVELENGTH)
    assert made is not None
    return made


@pytest.mark.parametrize("turned", np.radians([0.0, 4.0]))
@pytest.mark.parametrize("aside", np.radians([40.0, 90.0, -130.0, 180.0]))
def test_the_ray_is_the_shortest_by_the_cylinder(aside: float, turned: float) -> None:
    """Fermat: of all ways along the beam and by points of its near side the ray is the shortest; its detour is that to a target
    1e6 m off (d^2 / R, 0.1 mm)."""
    boresight = FUNNEL.bearing + turned
    target = boresight + aside
    ray = ray_by(FUNNEL, np.array([target]), np.array([boresight]))
    around = np.linspace(0.0, 2.0 * np.pi, 200_001)
    points = FUNNEL.distance * direction(FUNNEL.bearing) + FUNNEL.radius * direction(around)
    facing = (direction(around) @ direction(boresight) < 0) & (direction(around) @ direction(target) > 0)
    ahead, right = direction(boresight), direction(boresight + np.pi / 2.0)
    length = points @ ahead - points @ direction(target)
    best = np.flatnonzero(facing)[np.argmin(length[facing])]
    specular = ray.along[0] * ahead + ray.across[0] * right
    np.testing.assert_allclose(points[best], specular, atol=2e-4)
    detour = ray.along[0] + np.linalg.norm(1e6 * direction(target) - specular) - 1e6
    assert ray.detour[0] == pytest.approx(detour, abs=2e-4)


def test_right_behind_the_antenna_a_funnel_is_twice_its_distance_away() -> None:
    ray = ray_by(FUNNEL, np.array([FUNNEL.bearing + np.pi]), np.array([FUNNEL.bearing]))
    assert ray.detour[0] == pytest.approx(2.0 * (FUNNEL.distance - FUNNEL.radius), abs=1e-9)
    assert ray.half[0] == 1.0 and ray.across[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("distance", [2.5, 10.0, 3000.0])
def test_the_near_field_is_that_of_elements(distance: float) -> None:
    """Of a cosine aperture, by cylindrical waves of 800 elements: 2 % of its most; paraxial, and all distances count as one."""
    made = aperture()
    across = np.array([0.0, 0.3, -0.6, 1.0]) if distance < 100 else distance * np.radians([0.0, 0.3, -0.6, 1.0])
    place = ((np.arange(800) + 0.5) / 800 - 0.5) * made.length
    way = np.hypot(distance, across[:, None] - place)
    waves = np.exp(-1j * WAVENUMBER * (way - distance)) * np.sqrt(distance / way)
    slow = (waves * made.illumination(place)).mean(axis=1)
    fast = near_field(made, WAVELENGTH, distance, across)
    assert np.abs(fast - slow).max() < 0.02 * np.abs(slow).max()


def test_the_tube_of_a_uniform_aperture_carries_its_power() -> None:
    """On boresight the square of the near field is lambda d / D^2, and far off it is the pattern."""
    uniform = Aperture(2.0, (0.0,), (1.0,))
    middle = np.abs(near_field(uniform, WAVELENGTH, 4.0, np.linspace(-0.5, 0.5, 201))) ** 2
    assert middle.mean() == pytest.approx(WAVELENGTH * 4.0 / 4.0, rel=0.02)  # ripples of the edges average out
    offset = np.radians([0.0, 0.4, 1.3])
    far = np.abs(near_field(uniform, WAVELENGTH, 1e5, 1e5 * np.sin(offset)))
    np.testing.assert_allclose(far, np.abs(uniform.pattern(2.0 / WAVELENGTH * np.sin(offset))), atol=2e-3)


def scattered(structure: Structure, target: float, boresight: float, polarization: str) -> complex:
    """What elements receive of a plane wave by a metal cylinder alone, one by one."""
    made = aperture()
    points, along = elements(made.length, 80, boresight)
    taken = target, structure.bearing, structure.distance, structure.radius, points, WAVELENGTH, polarization
    field = past_cylinder(*taken) - np.exp(1j * WAVENUMBER * (points @ direction(target)))
    return received(field, along, made.length, {0.5: 1.0})


@pytest.mark.sample(2)
@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("structure, offsets", [(MAST, (0.0, -5.0)), (FUNNEL, (0.0, 2.0, 5.0))], ids=["mast", "funnel"])
def test_it_reflects_as_a_metal_cylinder(structure: Structure, offsets: tuple[float, ...], polarization: str) -> None:
    """To targets abeam and farther round, where it is within 10 dB of its most: 0.5 dB one way, 0.3 rad (1.5 mm of way)."""
    reflector, compared = LitStructure(structure, aperture(), WAVELENGTH, polarization), 0
    for aside in np.radians([90.0, 130.0, 179.0]):
        for offset in np.radians(offsets):
            target, boresight = structure.bearing + aside, structure.bearing + offset
            field, _ = reflector.field(np.array([[target]]), np.array([boresight]))
            if abs(field[0, 0]) < 10.0 ** (-10.0 / 20.0) * reflector.max_field:
                continue
            ratio = field[0, 0] / scattered(structure, target, boresight, polarization)
            assert abs(20.0 * np.log10(abs(ratio))) < 0.5, (aside, offset)
            assert abs(np.angle(ratio)) < 0.3, (aside, offset)
            compared += 1
    assert compared >= 4


def test_the_level_is_that_of_the_radar_equation() -> None:
    """A cylinder in the far field (a post 300 m off) has the width pi a cos(b / 2): power a cos(b / 2) / (2 d)."""
    post = Structure("post", 0.0, 300.0, 0.1)
    reflector = LitStructure(post, aperture(), WAVELENGTH, "h")
    target = np.radians([[100.0]])
    field, _ = reflector.field(target, np.zeros(1))
    width = np.pi * post.radius * np.sin(np.radians(50.0))
    assert abs(field[0, 0]) ** 2 == pytest.approx(width / (2.0 * np.pi * post.distance), rel=0.06)  # D^2 / lambda is 150 m


def test_reflection_top_and_darkness() -> None:
    """Half the reflection is half the field; a top at the antenna's height leaves half; unlit it reflects nothing."""
    target, boresight = np.array([[FUNNEL.bearing + 2.5]]), np.array([FUNNEL.bearing])

    def field(*changes: float, at: Floats = boresight) -> complex:
        structure = Structure("funnel", FUNNEL.bearing, FUNNEL.distance, FUNNEL.radius, *changes)
        return complex(LitStructure(structure, aperture(), WAVELENGTH, "h").field(target, at)[0][0, 0])

    full = field()
    assert field(np.inf, 0.5) == pytest.approx(0.5 * full)
    assert field(0.0) == pytest.approx(0.5 * full)
    assert field(at=boresight + 1.0) == 0.0 and field(at=boresight + np.pi) == 0.0
    reflector = LitStructure(FUNNEL, aperture(), WAVELENGTH, "v")
    assert reflector.is_lit(boresight).all() and not reflector.is_lit(boresight + 1.2).any()
    assert reflector.field(target, boresight)[0][0, 0] == pytest.approx(-full)
