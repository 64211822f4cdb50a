"""Targets with a known cross-section, on turntables about an antenna that does not turn: the test of scattering models.

The formulas are those of physical optics and geometrical optics, which a scattering model should reach. They share nothing
with the engine, which cuts meshes into facets and follows rays from facet to facet.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radar_service.radar.parameters import Radar
from radar_service.random import CHART, generator
from radar_service.scene.body import Body, Mesh, Scattering
from radar_service.scene.materials import material_from_name
from radar_service.scene.motion import Motion
from radar_service.scene.shapes import SHAPES
from radar_service.scene.world import Scene
from radar_service.types import Complexes, Floats, Indices

SIDE = 20.0  # wavelengths of plates, legs and heights: 0.6 m at X band, where edges and near fields matter little
RADIUS = 4.0  # wavelengths; the facets of built-in spheres and cylinders deviate by up to an eighth of one
CORNER_TURN = np.deg2rad(15.0)  # largest turn of a corner, either way
DISTANCE = 1000.0  # m from the antenna, far beyond twice SIDE^2 wavelengths


@dataclass(frozen=True)
class CanonicalTarget:
    """A target at the height of the antenna.

    max_turn: largest turn either way from facing the antenna [rad];
    cross_section: maps turns (K,) [rad] to cross-sections (K,) [m^2].
    """

    name: str
    mesh: Mesh
    max_turn: float
    cross_section: Callable[[Floats], Floats]


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
    upright = SHAPES["cylinder"](r, a)
    return [
        CanonicalTarget("sphere", SHAPES["sphere"](r), np.pi, constant(np.pi * r**2)),
        CanonicalTarget("cylinder", _lowered(upright, a / 2.0), np.pi, constant(2.0 * np.pi * r * a**2 / wavelength)),
        CanonicalTarget("plate", SHAPES["plate"](a, a), lobe, plate),
        CanonicalTarget("dihedral", SHAPES["dihedral"](a, a), CORNER_TURN, dihedral),
        CanonicalTarget("trihedral", SHAPES["trihedral"](a), CORNER_TURN, trihedral),
    ]


def trihedral_aperture(turn: float) -> float:
    """Returns the area [1] that a trihedral with unit legs reflects back, seen level, `turn` [rad] from its axis.

    Its faces are triangles. Source: Spencer 1944; Doerry, Reflectors for SAR performance testing (2014), eqs. 2 and 3.
    """
    legs = np.array(
        [[0.0, np.sqrt(1 / 3)], [np.sqrt(1 / 2), np.sqrt(1 / 3)], [-np.sqrt(1 / 2), np.sqrt(1 / 3)]]
    )  # horizontal parts
    small, middle, large = np.sort(legs @ np.array([np.sin(turn), np.cos(turn)]))
    total = small + middle + large
    return float(4.0 * small * middle / total if small + middle < large else total - 2.0 / total)


def _lowered(mesh: Mesh, height: float) -> Mesh:
    """Returns the mesh with its origin raised by `height` [m], so that its middle is at the height of the antenna."""
    return Mesh(mesh.vertices - (0.0, 0.0, height), mesh.faces)


def random_turns(targets: list[CanonicalTarget], draws: int, seed: int) -> Floats:
    """Returns random turns (S, T) [rad] of the targets from facing the antenna, one row a draw."""
    limits = np.array([target.max_turn for target in targets])
    return np.asarray(generator(seed, CHART, 2).uniform(-1.0, 1.0, (draws, len(targets))) * limits)


def turntable_scene(scene: Scene, targets: list[CanonicalTarget], turns: Floats, scattering: Scattering | None) -> Scene:
    """Returns the scene with its bodies replaced by steel targets about the antenna, over a flat earth.

    turns: (S, T) [rad]; row s holds at t = s [s]. scattering: the model of the targets; with None each target declares the
    cross-section that it has when it faces the antenna.
    """
    antenna = scene.antenna(0.0)[0]
    steel, step = material_from_name("steel", "chart"), 2.0 * np.pi / len(targets)
    bodies = []
    for k, target in enumerate(targets):
        bearing = (k + 0.5) * step
        position = antenna + DISTANCE * np.array([np.sin(bearing), np.cos(bearing), 0.0])
        time = np.arange(len(turns), dtype=np.float64)
        motion = Motion(time, np.tile(position, (len(turns), 1)), bearing + np.pi + turns[:, k])
        declared = None if scattering else float(target.cross_section(np.zeros(1))[0])
        size = float(np.ptp(target.mesh.vertices[:, 0])), float(np.ptp(target.mesh.vertices[:, 1]))
        bodies.append(Body(target.name, target.mesh, motion, steel, scattering or "rcs", declared, 0, None, *size))
    empty = replace(scene.environment, earth_factor=np.inf, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0)
    return scene.with_world(bodies=tuple(bodies), environment=empty)


def coherent_cross_sections(radar: Radar, antenna: Floats, position: Floats, amplitude: Complexes,
                            body: Indices, count: int) -> Floats:  # fmt: skip
    """Returns the cross-sections (count,) [m^2] of bodies whose echoes add with their phases.

    position: of the echoes (M, 3) [m]; amplitude: (M,) [m]; body: index of the body of each echo (M,).
    """
    excess = np.linalg.norm(position - antenna, axis=1) - DISTANCE
    echo = amplitude * np.exp(-4j * np.pi / radar.wavelength * excess)
    return np.asarray(np.abs(np.bincount(body, echo.real, count) + 1j * np.bincount(body, echo.imag, count)) ** 2)
