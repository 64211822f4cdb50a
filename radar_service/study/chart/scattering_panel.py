"""The third panel: cross-sections of canonical targets by each scattering model, at random turns.

The cross-sections are those of physical optics and geometrical optics. They share nothing with the engine.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from radar_service.numerics import CHART, Floats, generator, polar_from_map
from radar_service.propagation import two_way_phase
from radar_service.radar import Sinc2
from radar_service.records import PRESETS
from radar_service.scattering import BodyEchoes, Instant, PhysicalOptics, ScattererSet
from radar_service.study.chart.frozen_scene import all_scatterers, occlusion_of
from radar_service.study.chart.point import Point, Sampler, drawn_points
from radar_service.trace import OcclusionScene
from radar_service.world import SHAPES, Body, BodyPoses, Mesh, Motion, Scene, map_from_bodies, material_from_name, shape_mesh

SIDE = 20.0  # wavelengths of plates, legs and heights: 0.6 m at X band, where edges and near fields matter little
RADIUS = 4.0  # wavelengths
CORNER_TURN = np.deg2rad(15.0)  # largest turn of a corner, either way
DISTANCE = 1000.0  # m from the antenna, far beyond twice the square of a target's size over the wavelength
MAX_RANGE = 2.0 * DISTANCE
BOUNCES = (1, 2, 3)


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


def random_turns(targets: Sequence[CanonicalTarget], draws: int, seed: int) -> Floats:
    """Returns random turns (S, T) [rad] of the targets from facing the antenna, one row a draw."""
    limits = np.array([target.max_turn for target in targets])
    return np.asarray(generator(seed, CHART, 2).uniform(-1.0, 1.0, (draws, len(targets))) * limits)


def cross_sections(scene: Scene, scatterers: ScattererSet, occlusion: OcclusionScene, draw: int) -> Floats:
    """Returns the cross-sections (T,) [m^2] of all targets at the turns of a draw."""
    time, antenna = _time(draw, scene), scene.antenna(0.0)[0]
    echoes = scatterers.echoes(antenna, Instant(time, occlusion, MAX_RANGE))
    poses = BodyPoses(scatterers.bodies).at(np.array([time]))
    position = map_from_bodies(echoes.position, echoes.body, poses.position[0], poses.heading[0])
    return coherent_cross_sections(scene, position, echoes)


def coherent_cross_sections(scene: Scene, position: Floats, echoes: BodyEchoes) -> Floats:
    """Returns the cross-sections (T,) [m^2] of the bodies of a scene, whose echoes add with their phases.

    position: of the echoes (M, 3) on the map [m].
    """
    distance, count = polar_from_map(position, scene.antenna(0.0)[0], np.inf).range, len(scene.bodies)
    echo = echoes.amplitude * (DISTANCE / distance) ** 2 * two_way_phase(distance - DISTANCE, scene.radar.wavelength)
    total = np.bincount(echoes.body, echo.real, count) + 1j * np.bincount(echoes.body, echo.imag, count)
    return np.asarray(np.abs(total) ** 2)


def _time(draw: int, scene: Scene) -> float:
    return draw * scene.radar.rotation_period


def targets_scene(scene: Scene, targets: Sequence[CanonicalTarget], turns: Floats, scattering: str | None) -> Scene:
    """Returns the scene with steel targets about the antenna in place of its bodies, in free space over a flat earth.

    turns: (S, T) [rad], one row a scan. scattering: a model of scene files; None: each target declares the cross-section that it
    has when it faces the antenna.
    """
    scene = replace(scene, radar=replace(scene.radar, beamwidth_el=np.pi, tilt=0.0, pattern_el=Sinc2()))
    antenna, time = scene.antenna(0.0)[0], np.array([_time(draw, scene) for draw in range(len(turns))])
    bodies = []
    for k, target in enumerate(targets):
        bearing = (k + 0.5) * (2.0 * np.pi / len(targets))
        place = antenna + DISTANCE * np.array([np.sin(bearing), np.cos(bearing), 0.0])
        motion = Motion(time, np.tile(place, (len(time), 1)), bearing + np.pi + turns[:, k], turning=True)
        size = float(np.ptp(target.mesh.vertices[:, 0])), float(np.ptp(target.mesh.vertices[:, 1]))
        steel, declared = material_from_name("steel", "chart"), None if scattering else target.facing
        bodies.append(Body(target.name, target.mesh, motion, steel, scattering or "rcs", declared, 0, None, *size))
    environment = replace(
        scene.environment, earth_factor=np.inf, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0, sea_state=0
    )
    return scene.with_world(bodies=tuple(bodies), environment=environment)


def scattering_models(scene: Scene, targets: Sequence[CanonicalTarget], turns: Floats, seed: int) -> list[Sampler]:
    """Returns declared cross-sections, diffuse surfaces, and physical optics with one to three bounces.

    turns: (S, T) [rad] of the targets. A model is evaluated once a scan, so each azimuth bears its share of the time.
    """
    balanced, declared, presets = PRESETS["balanced"], "declared cross-section", dict[int, list[str]]()
    for name, preset in PRESETS.items():
        if preset.engine == "corrected":
            presets.setdefault(preset.bounces, []).append(name)

    def model(family: str, setting: str, scattering: str | None, bounces: int = balanced.bounces) -> Sampler:
        turntables, names = targets_scene(scene, targets, turns, scattering), presets.get(bounces, [])
        scatterers = all_scatterers(turntables, replace(balanced, bounces=bounces), seed)
        draw = partial(cross_sections, turntables, scatterers, occlusion_of(turntables))
        preset = ", ".join(names) if names and scattering == "optics" else None
        return Sampler(family, setting, draw, scene.radar.azimuths, len(turns), preset)

    optics = [model("physical optics", f"{b} bounce{'s' * (b > 1)}", "optics", b) for b in BOUNCES]
    return [model(declared, "rcs", None), model("diffuse surface", "diffuse", "diffuse"), *optics]


def scattering_points(scene: Scene, draws: int, seed: int) -> list[Point]:
    """Returns one point for each scattering model, from `draws` random turns of the targets."""
    targets = canonical_targets(scene.radar.wavelength)
    turns = random_turns(targets, draws, seed)
    models = scattering_models(scene, targets, turns, seed)
    theory = np.stack([target.cross_section(turns[:, k]) for k, target in enumerate(targets)], axis=1)
    for model in models:
        model.draw(0)  # facets are cut once for a distance; that is not timed
    return drawn_points("scattering", models, theory, draws)
