"""Samplers of diffuse surfaces: scatterers on the surface, rays weighted by solid angle, and the documented rays.

Each draw computes the echoes of the whole frozen scene on boresight, with its own random numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from radar_service.echo.echoes import Echoes
from radar_service.engine.documented import Solid, nearest
from radar_service.numerics.frames import body_rotation, direction, wrap_angle
from radar_service.numerics.random import CHART, generator
from radar_service.numerics.types import Floats, Indices
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.rays import RayCaster, RaySampledSurfaces
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.study.chart.frozen_scene import all_scatterers, echoes_of
from radar_service.study.chart.reference_surface import Window
from radar_service.trace.embree import TriangleScene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.trace.ray_sampling import BOX_BEAMWIDTHS, azimuth_offsets, elevation_offsets
from radar_service.world.scene import Scene

RAYS = {500: 24, 2000: 24, 8000: 16, 32000: 8}  # rays in a box of 3 x 3 beamwidths: number of draws
DOCUMENTED_DRAWS = 512  # of the documented rays, for all windows together
DENSITIES = (0.25, 1.0, 4.0, 16.0)
CALIBRATION_RANGE = 1000.0  # m; the documented level is relative and is calibrated here
FAMILIES = {"rays": "uniform rays", "stratified": "stratified rays", "sobol": "Sobol' rays"}

Powers = Floats  # (T,) of each window [W]


@dataclass(frozen=True)
class Sampler:
    """One sampler at one setting.

    family: name of the sampler;
    setting: the setting, for a reader;
    draw: maps a seed to the powers (T,) [W] in each window;
    azimuths: number of azimuths that one draw computes;
    draws: largest number of draws of a chart;
    preset: the preset that uses this setting, if any.
    """

    family: str
    setting: str
    draw: Callable[[int], Powers]
    azimuths: int
    draws: int
    preset: str | None = None


def samplers(scene: Scene, windows: list[Window], occlusion: OcclusionScene, max_rays: int) -> list[Sampler]:
    """Returns every sampler at every setting, up to `max_rays` rays in a box of 3 x 3 beamwidths.

    scene: a frozen one with diffuse surfaces only.
    """
    presets = {p.scatterers_per_cell: n for n, p in PRESETS.items() if p.engine == "corrected" and p.sampler == "scatterers"}
    azimuths = scene.radar.azimuths
    result = []
    for density in DENSITIES:
        draw = partial(scatterer_powers, scene, windows, occlusion, density)
        result.append(Sampler("scatterers", f"{density:g} per cell", draw, azimuths, 24, presets.get(density)))
    rays = {count: draws for count, draws in RAYS.items() if count <= max_rays}
    for sampler, family in FAMILIES.items():
        result += [
            Sampler(family, f"{n}", partial(ray_powers, scene, windows, occlusion, sampler, n), azimuths, count)
            for n, count in rays.items()
        ]
    documented, draws = DocumentedRays(scene, windows), max(8, DOCUMENTED_DRAWS // len(windows))
    names = {scene.radar.rays: "documented"}
    return result + [
        Sampler("documented rays", f"{n}", partial(documented.draw, n), len(windows), draws, names.get(n)) for n in rays
    ]


def powers_in(windows: list[Window], echoes: Echoes) -> Powers:
    """Returns the incoherent sum (T,) [W] of the echoes in each window."""
    power = np.abs(echoes.amplitude) ** 2
    return np.array([power[w.contains(echoes.azimuth, echoes.range)].sum() for w in windows])


def scatterer_powers(scene: Scene, windows: list[Window], occlusion: OcclusionScene, per_cell: float, seed: int) -> Powers:
    """Returns the powers (T,) [W] by scatterers, drawn anew on every body."""
    fidelity = replace(PRESETS["balanced"], scatterers_per_cell=per_cell)
    return powers_in(windows, echoes_of(scene, all_scatterers(scene, fidelity, seed), occlusion))


def ray_powers(scene: Scene, windows: list[Window], occlusion: OcclusionScene, sampler: str, rays: int, seed: int) -> Powers:
    """Returns the powers (T,) [W] by one scan of rays, each weighted by its solid angle."""
    radar = replace(scene.radar, rays=rays)
    caster = RayCaster(scene.bodies, radar, occlusion.earth_radius, sampler, seed)
    keys = np.arange(len(scene.bodies))
    surfaces = ScattererSet(scene.bodies, keys, (RaySampledSurfaces(keys, caster),))
    return powers_in(windows, echoes_of(scene, surfaces, occlusion))


class DocumentedRays:
    """The documented rays of one azimuth at a time: each hit has the power (R^-2)^2, over a flat earth.

    The documented level is relative and ignores the material. It is calibrated on a surface of any material at 1 km.
    """

    def __init__(self, scene: Scene, windows: list[Window]) -> None:
        self._scene, self._windows = scene, windows
        self._solids, gamma = [], []
        for body in scene.bodies:
            if body.mesh is not None:
                pose = body.motion.pose(0.0)
                heading = float(pose.heading[0])
                triangles = TriangleScene(body.mesh.vertices, body.mesh.faces)
                self._solids.append(Solid(triangles, pose.position[0], body_rotation(heading)))
                gamma.append(body.material.gamma)
        self._gamma = np.array(gamma)
        self._nearby = [self._in_ray_box(window) for window in windows]

    def _in_ray_box(self, window: Window) -> Indices:
        """Returns the bodies whose bounding sphere overlaps the box of rays; the documented engine traces no others."""
        antenna, solids = self._scene.antenna(0.0)[0], self._solids
        centre = np.array([s.position + s.rotation @ s.triangles.centre for s in solids]) - antenna
        radius, ground = np.array([s.triangles.radius for s in solids]), np.hypot(centre[:, 0], centre[:, 1])
        half = np.arcsin(np.minimum(radius / np.maximum(ground, radius), 1.0))
        off = wrap_angle(np.arctan2(centre[:, 0], centre[:, 1]) - window.azimuth - window.angle / 2.0)
        return np.flatnonzero((ground <= radius) | (np.abs(off) <= BOX_BEAMWIDTHS * self._scene.radar.beamwidth + half))

    def draw(self, rays: int, seed: int) -> Powers:
        """Returns the powers (T,) [W]; each window has one azimuth with its own rays."""
        return np.array([self._power(k, rays, generator(seed, CHART, 1, k)) for k in range(len(self._windows))])

    def _power(self, number: int, rays: int, random: np.random.Generator) -> float:
        window, nearby = self._windows[number], self._nearby[number]
        radar, antenna = self._scene.radar, self._scene.antenna(0.0)[0]
        azimuth = window.azimuth + window.angle / 2.0 + azimuth_offsets(random, rays, radar.beamwidth)
        elevation = radar.tilt + elevation_offsets(random, rays, radar.beamwidth_el)
        ray = direction(azimuth, elevation)
        each = np.array([nearest([self._solids[body]], antenna, ray) for body in nearby])
        first, body = each.min(axis=0), nearby[each.argmin(axis=0)]
        hit = np.isfinite(first) & (antenna[2] + first * np.sin(elevation) >= 0.0)
        hit &= window.contains(azimuth, np.where(np.isfinite(first), first, 0.0))
        box = (3.0 * radar.beamwidth) * (3.0 * radar.beamwidth_el) / rays
        gain = radar.pattern_el.gain(elevation[hit] - radar.tilt, radar.beamwidth_el)
        # The radar equation at 1 km
        level = received_amplitude(radar, np.full(1, CALIBRATION_RANGE))[0] * CALIBRATION_RANGE**3
        power = self._gamma[body[hit]] * box * (level * gain / (first[hit] ** 2 + 1.0)) ** 2
        return float(power.sum())
