"""Bodies whose cross-section theory knows, on turntables about a stopped antenna: what scattering models are judged on.

Their formulas are those of physical optics and geometrical optics, which is what a scattering model is to reach; they share
nothing with the engine, which cuts meshes into facets and follows rays from one to the next.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from radar_service.radar.parameters import Radar
from radar_service.random import CHART, generator
from radar_service.scene.body import Body, Mesh, Scattering
from radar_service.scene.materials import material_from_name
from radar_service.scene.motion import Motion
from radar_service.scene.shapes import SHAPES
from radar_service.scene.world import Scene

Floats = NDArray[np.float64]
SIDE = 20.0  # wavelengths of plates, legs and heights: 0.6 m at X band, where edges and near fields matter little
ROUND = 4.0  # wavelengths of radii; the facets of built-in spheres and cylinders sag by up to an eighth, which their spread shows
CORNERS = np.deg2rad(15.0)  # how far corners are turned away, either way
AWAY = 1000.0  # m from the antenna, far beyond twice SIDE^2 wavelengths


@dataclass(frozen=True)
class Anchor:
    """A body as high as the antenna that turns at most `turned` [rad] either way from facing it; section: its cross-section
    [m^2] at turns (K,) [rad] from there."""

    name: str
    mesh: Mesh
    turned: float
    section: Callable[[Floats], Floats]


def anchors_for(wavelength: float) -> list[Anchor]:
    """Sphere, cylinder, plate, dihedral and trihedral, sized in wavelengths [m]."""
    a, r = SIDE * wavelength, ROUND * wavelength
    of_area = 4.0 * np.pi / wavelength**2

    def flat(turn: Floats) -> Floats:
        lobes = np.sinc(2.0 * a / wavelength * np.sin(turn))  # Balanis 2012, eq. 6-120
        return np.asarray(of_area * a**4 * np.cos(turn) ** 2 * lobes**2)

    def wedge(turn: Floats) -> Floats:
        across = 2.0 * np.sin(np.pi / 4.0 - np.abs(turn))  # twice the narrower plate (Knott 1993, section 6.4)
        return np.asarray(of_area * a**4 * across**2)

    def corner(turn: Floats) -> Floats:
        return np.array([of_area * (corner_aperture(t) * a**2) ** 2 for t in turn])

    def steady(section: float) -> Callable[[Floats], Floats]:
        return lambda turn: np.full(np.shape(turn), section)

    lobe = wavelength / (4.0 * a)  # half way from a plate's peak to its first null
    upright = SHAPES["cylinder"](r, a)
    return [
        Anchor("sphere", SHAPES["sphere"](r), np.pi, steady(np.pi * r**2)),
        Anchor("cylinder", _lowered(upright, a / 2.0), np.pi, steady(2.0 * np.pi * r * a**2 / wavelength)),
        Anchor("plate", SHAPES["plate"](a, a), lobe, flat),
        Anchor("dihedral", SHAPES["dihedral"](a, a), CORNERS, wedge),
        Anchor("trihedral", SHAPES["trihedral"](a), CORNERS, corner),
    ]


def corner_aperture(turn: float) -> float:
    """Area that a trihedral with unit legs and triangular faces mirrors back [1], seen level, `turn` [rad] from its axis.

    Source: Spencer 1944; Doerry, Reflectors for SAR performance testing (2014), eqs. 2 and 3.
    """
    legs = np.array(
        [[0.0, np.sqrt(1 / 3)], [np.sqrt(1 / 2), np.sqrt(1 / 3)], [-np.sqrt(1 / 2), np.sqrt(1 / 3)]]
    )  # level parts
    least, middle, most = np.sort(legs @ np.array([np.sin(turn), np.cos(turn)]))
    total = least + middle + most
    return float(4.0 * least * middle / total if least + middle < most else total - 2.0 / total)


def _lowered(mesh: Mesh, much: float) -> Mesh:
    """The mesh about another origin, so that its middle is at the antenna's height [m]."""
    return Mesh(mesh.vertices - (0.0, 0.0, much), mesh.faces)


def turns_of(anchors: list[Anchor], draws: int, seed: int) -> Floats:
    """Turns (S, T) [rad] of the anchors from facing the antenna, anew for each draw."""
    reach = np.array([anchor.turned for anchor in anchors])
    return np.asarray(generator(seed, CHART, 2).uniform(-1.0, 1.0, (draws, len(anchors))) * reach)


def turntables(scene: Scene, anchors: list[Anchor], turns: Floats, scattering: Scattering | None) -> Scene:
    """The scene with nothing in it but steel anchors about its antenna, over a flat earth; at t = s [s] each is turned as
    row s of turns (S, T) says. scattering: their model; None: each declares the cross-section that it faces with."""
    antenna = scene.antenna(0.0)[0]
    steel, step = material_from_name("steel", "chart"), 2.0 * np.pi / len(anchors)
    bodies = []
    for k, anchor in enumerate(anchors):
        bearing = (k + 0.5) * step
        place = antenna + AWAY * np.array([np.sin(bearing), np.cos(bearing), 0.0])
        time = np.arange(len(turns), dtype=np.float64)
        motion = Motion(time, np.tile(place, (len(turns), 1)), bearing + np.pi + turns[:, k])
        declared = None if scattering else float(anchor.section(np.zeros(1))[0])
        size = float(np.ptp(anchor.mesh.vertices[:, 0])), float(np.ptp(anchor.mesh.vertices[:, 1]))
        bodies.append(Body(anchor.name, anchor.mesh, motion, steel, scattering or "rcs", declared, 0, None, *size))
    empty = replace(scene.environment, earth_factor=np.inf, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0)
    return scene.with_world(bodies=tuple(bodies), environment=empty)


def seen_sections(radar: Radar, antenna: Floats, place: Floats, amplitude: NDArray[np.complex128], body: NDArray[np.int64],
                  count: int) -> Floats:  # fmt: skip
    """Cross-sections (T,) [m^2] of `count` bodies, their reflections at places (M, 3) added with their phases."""
    away = np.linalg.norm(place - antenna, axis=1) - AWAY
    turned = amplitude * np.exp(-4j * np.pi / radar.wavelength * away)
    return np.asarray(np.abs(np.bincount(body, turned.real, count) + 1j * np.bincount(body, turned.imag, count)) ** 2)
