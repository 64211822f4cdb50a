"""Targets with a known cross-section, the test of scattering models: in the far field of free space, and plates where that is not
enough: over the sea, behind a screen, near by and turning.

The formulas are those of physical optics and geometrical optics, which a scattering model should reach. Those of plates are
closed forms and one quadrature. They share nothing with the engine, which cuts meshes into facets and follows rays from facet to
facet, but the permittivity of sea water.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import fresnel

from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.numerics.types import Complexes, Floats
from radar_service.propagation.sea_surface import sea_water_permittivity
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.world.body import Mesh
from radar_service.world.shapes import SHAPES, shape_mesh

SIDE = 20.0  # wavelengths of plates, legs and heights: 0.6 m at X band, where edges and near fields matter little
RADIUS = 4.0  # wavelengths
CORNER_TURN = np.deg2rad(15.0)  # largest turn of a corner, either way
DISTANCE = 1000.0  # m from the antenna, far beyond twice SIDE^2 wavelengths
LONG = 100.0  # wavelengths: 3.2 m at X band, three lobes of multipath at 1 km
NEAR, NEAREST = 3000.0, 50.0  # wavelengths, and m: a long plate's near field reaches to 20 000 wavelengths
NEAR_TURN = np.deg2rad(2.5)  # off the normal, either way
ANTENNA_HEIGHT = 15.0  # m over the sea
HIDDEN = 0.4  # of the width of the plate behind a screen
SCREEN_AT = 0.5  # of the distance
SCREEN = 10.0  # width and height of the screen over those of the plate
RATE = np.deg2rad(3.0)  # rad/s of the turning plate
HEIGHTS = 400  # of the quadrature, by Gauss and Legendre


@dataclass(frozen=True)
class CanonicalTarget:
    """A target at the height of the antenna, or on the sea.

    max_turn: largest turn either way from facing the antenna [rad].
    cross_section: maps turns (K,) [rad] to cross-sections (K,) [m^2].
    facing: the cross-section that it has facing the antenna in the far field of free space [m^2].
    distance: from the antenna [m].
    over_sea: whether it stands on a smooth sea that reflects.
    rate: at which it turns while it is observed [rad/s].
    screen: mesh of a screen before it, at which share of the distance, and how far to the right of the line of sight [m].
    """

    name: str
    mesh: Mesh
    max_turn: float
    cross_section: Callable[[Floats], Floats]
    facing: float
    distance: float = DISTANCE
    over_sea: bool = False
    rate: float = 0.0
    screen: tuple[Mesh, float, float] | None = None


def canonical_targets(wavelength: float) -> list[CanonicalTarget]:
    """Returns a sphere, a cylinder, a plate, a dihedral and a trihedral, sized by the wavelength [m]."""
    a, r = SIDE * wavelength, RADIUS * wavelength
    per_area = 4.0 * np.pi / wavelength**2

    def plate(turn: Floats) -> Floats:
        lobes = np.sinc(2.0 * a / wavelength * np.sin(turn))  # Balanis 2012, eq. 6-120
        return np.asarray(per_area * a**4 * np.cos(turn) ** 2 * lobes**2)

    def dihedral(turn: Floats) -> Floats:
        across = 2.0 * np.sin(np.pi / 4.0 - np.abs(turn))  # twice the narrower plate (Knott 1993, section 6.4)
        return np.asarray(per_area * a**4 * across**2)

    def trihedral(turn: Floats) -> Floats:
        return np.array([per_area * (trihedral_aperture(t) * a**2) ** 2 for t in turn])

    def constant(cross_section: float) -> Callable[[Floats], Floats]:
        return lambda turn: np.full(np.shape(turn), cross_section)

    def target(name: str, mesh: Mesh, max_turn: float, cross_section: Callable[[Floats], Floats]) -> CanonicalTarget:
        return CanonicalTarget(name, mesh, max_turn, cross_section, float(cross_section(np.zeros(1))[0]))

    lobe = wavelength / (4.0 * a)  # half way from a plate's peak to its first null
    upright = shape_mesh("cylinder", {"radius_m": r, "height_m": a}, PhysicalOptics.shape_sag("cylinder", wavelength))
    ball = shape_mesh("sphere", {"radius_m": r}, PhysicalOptics.shape_sag("sphere", wavelength))
    return [
        target("sphere", ball, np.pi, constant(np.pi * r**2)),
        target("cylinder", lowered(upright, a / 2.0), np.pi, constant(2.0 * np.pi * r * a**2 / wavelength)),
        target("plate", SHAPES["plate"](a, a), lobe, plate),
        target("dihedral", SHAPES["dihedral"](a, a), CORNER_TURN, dihedral),
        target("trihedral", SHAPES["trihedral"](a), CORNER_TURN, trihedral),
    ]


def trihedral_aperture(turn: float) -> float:
    """Returns the area [1] that a trihedral with unit legs reflects back, seen level, `turn` [rad] from its axis.

    Its faces are triangles. Source: Spencer 1944; Doerry, Reflectors for SAR performance testing (2014), eqs. 2 and 3.
    """
    edges = np.array(
        [[0.0, np.sqrt(1 / 3)], [np.sqrt(1 / 2), np.sqrt(1 / 3)], [-np.sqrt(1 / 2), np.sqrt(1 / 3)]]
    )  # horizontal parts
    small, middle, large = np.sort(edges @ np.array([np.sin(turn), np.cos(turn)]))
    total = small + middle + large
    return float(4.0 * small * middle / total if small + middle < large else total - 2.0 / total)


def lowered(mesh: Mesh, height: float) -> Mesh:
    """Returns the mesh with its origin raised by `height` [m]."""
    return Mesh(mesh.vertices - (0.0, 0.0, height), mesh.faces)


def plates(wavelength: float, polarization: str) -> list[CanonicalTarget]:
    """Returns the four plates, sized by the wavelength [m]."""
    a, long = SIDE * wavelength, LONG * wavelength
    lobe, near = wavelength / (4.0 * a), max(NEAR * wavelength, NEAREST)
    square, tall, wide = SHAPES["plate"](a, a), lowered(SHAPES["plate"](a, long), -long / 2.0), SHAPES["plate"](long, a)
    screen = SHAPES["plate"](SCREEN * a, SCREEN * a)
    aside = -(SCREEN / 2.0 + SCREEN_AT * (0.5 - HIDDEN)) * a

    def facing(width: float, height: float) -> float:
        return 4.0 * np.pi * (width * height / wavelength) ** 2

    standing = up_the_sea(long, wavelength, polarization)

    def over_sea(turn: Floats) -> Floats:
        return np.asarray(np.abs(across(turn, a, wavelength) * standing) ** 2 * facing(1.0, 1.0))

    def partly_hidden(turn: Floats) -> Floats:
        edge = (HIDDEN - 0.5) * a / np.cos(turn)  # the shadow's edge stays on one line of sight
        field = near_across(turn, edge, a / 2.0, DISTANCE, wavelength) * near_across(
            0.0, -a / 2.0, a / 2.0, DISTANCE, wavelength
        )
        return np.asarray(np.abs(field) ** 2 * facing(1.0, 1.0))

    def long_at(distance: float) -> Callable[[Floats], Floats]:
        upright = near_across(0.0, -a / 2.0, a / 2.0, distance, wavelength)
        field = partial(near_across, low=-long / 2.0, high=long / 2.0, distance=distance, wavelength=wavelength)
        return lambda turn: np.abs(field(turn) * upright) ** 2 * facing(1.0, 1.0)

    return [
        CanonicalTarget("plate over the sea", tall, lobe, over_sea, facing(a, long), over_sea=True),
        CanonicalTarget(
            "plate behind a screen", square, lobe, partly_hidden, facing(a, a), screen=(screen, SCREEN_AT, aside)
        ),
        CanonicalTarget("plate near by", wide, NEAR_TURN, long_at(near), facing(a, long), distance=near),
        CanonicalTarget("turning plate", wide, lobe * SIDE / LONG, long_at(DISTANCE), facing(a, long), rate=RATE),
    ]


def across(turn: Floats, width: float | Floats, wavelength: float) -> Floats:
    """Returns the integral [m] over the width [m] of a distant plate at turns (K,) [rad] (Balanis 2012, eq. 6-120)."""
    return np.asarray(width * np.cos(turn) * np.sinc(2.0 * width / wavelength * np.sin(turn)))


def near_across(turn: Floats | float, low: Floats | float, high: float, distance: float, wavelength: float) -> Complexes:
    """Returns the same integrals (K,) [m] from `low` to `high` right of the middle [m], of a plate at a distance [m].

    The phase of the way out and back is 2k (R - u sin t + (u cos t)^2 / 2R), so these are Fresnel integrals.
    """
    k, bend = 2.0 * np.pi / wavelength, np.cos(turn) ** 2
    shift, scale = -np.sin(turn) * distance / bend, np.sqrt(2.0 * k * bend / (np.pi * distance))
    ends = (fresnel(scale * (end + shift)) for end in (high, low))
    last, first = (cosine - 1j * sine for sine, cosine in ends)
    phase = k * np.sin(turn) ** 2 * distance / bend
    return np.asarray(np.cos(turn) * (last - first) / scale * np.exp(1j * phase))


def up_the_sea(height: float, wavelength: float, polarization: str) -> complex:
    """Returns the integral [m] of F^2 exp(-2jk (R - R0)) over an upright line of this height [m] that stands on a flat sea.

    Four paths: F adds the way by the smooth sea to the direct one, out and back (Kerr 1951, ch. 2).
    """
    k = 2.0 * np.pi / wavelength
    node, weight = np.polynomial.legendre.leggauss(HEIGHTS)
    z = 0.5 * height * (node + 1.0)
    direct, by_sea = np.hypot(DISTANCE, z - ANTENNA_HEIGHT), np.hypot(DISTANCE, z + ANTENNA_HEIGHT)
    reflection = _reflection((z + ANTENNA_HEIGHT) / by_sea, wavelength, polarization)
    field = np.exp(-1j * k * (direct - DISTANCE)) / direct + reflection * np.exp(-1j * k * (by_sea - DISTANCE)) / by_sea
    return complex(0.5 * height * np.sum(weight * (DISTANCE * field) ** 2))


def _reflection(sine: Floats, wavelength: float, polarization: str) -> Complexes:
    """Returns Fresnel's coefficients (Z,) of the sea at sines of grazing angles (Z,)."""
    permittivity = sea_water_permittivity(SPEED_OF_LIGHT / wavelength)
    root = np.sqrt(permittivity - 1.0 + sine**2)
    first = sine if polarization == "h" else permittivity * sine
    return np.asarray((first - root) / (first + root))
