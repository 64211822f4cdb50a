"""Targets with a known cross-section in the far field of free space: the test of scattering models.

The formulas are those of physical optics and geometrical optics. They share nothing with the engine.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.model import PhysicalOptics
from radar_service.world.body import Mesh
from radar_service.world.shapes import SHAPES, shape_mesh

SIDE = 20.0  # wavelengths of plates, legs and heights: 0.6 m at X band, where edges and near fields matter little
RADIUS = 4.0  # wavelengths
CORNER_TURN = np.deg2rad(15.0)  # largest turn of a corner, either way


@dataclass(frozen=True)
class CanonicalTarget:
    """A target at the height of the antenna.

    max_turn: largest turn either way from facing the antenna [rad].
    cross_section: maps turns (K,) [rad] to cross-sections (K,) [m^2].
    """

    name: str
    mesh: Mesh
    max_turn: float
    cross_section: Callable[[Floats], Floats]

    @property
    def facing(self) -> float:
        """The cross-section of the target that faces the antenna [m^2]."""
        return float(self.cross_section(np.zeros(1))[0])


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

    lobe = wavelength / (4.0 * a)  # half way from a plate's peak to its first null
    upright = shape_mesh("cylinder", {"radius_m": r, "height_m": a}, PhysicalOptics.shape_sag("cylinder", wavelength))
    ball = shape_mesh("sphere", {"radius_m": r}, PhysicalOptics.shape_sag("sphere", wavelength))
    return [
        CanonicalTarget("sphere", ball, np.pi, constant(np.pi * r**2)),
        CanonicalTarget("cylinder", _lowered(upright, a / 2.0), np.pi, constant(2.0 * np.pi * r * a**2 / wavelength)),
        CanonicalTarget("plate", SHAPES["plate"](a, a), lobe, plate),
        CanonicalTarget("dihedral", SHAPES["dihedral"](a, a), CORNER_TURN, dihedral),
        CanonicalTarget("trihedral", SHAPES["trihedral"](a), CORNER_TURN, trihedral),
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


def _lowered(mesh: Mesh, height: float) -> Mesh:
    """Returns the mesh with its origin raised by `height` [m]."""
    return Mesh(mesh.vertices - (0.0, 0.0, height), mesh.faces)
