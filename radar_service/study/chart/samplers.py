"""Samplers of diffuse surfaces: scatterers on them, rays with their solid angle, and the documented rays without it.

Each is asked for the echoes of the whole stopped scene, as boresight would hear them, again and again with other random
numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.resting import resting_echoes
from radar_service.echo.second_time_around import heard_reach
from radar_service.engine.documented import Solid, nearest
from radar_service.fidelity import PRESETS
from radar_service.frames import body_rotation, direction, wrap_angle
from radar_service.propagation.radar_equation import Echoes, received_amplitude
from radar_service.random import CHART, generator
from radar_service.scattering.rays import RayCaster, RaySampledSet
from radar_service.scattering.scatterer_set import build_scatterers
from radar_service.scene.world import Scene
from radar_service.study.chart.surface_twin import Window
from radar_service.trace.embree import TriangleScene
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.trace.ray_sampling import REACH, azimuth_offsets, elevation_offsets

Floats = NDArray[np.float64]
RAYS = {500: 24, 2000: 24, 8000: 16, 32000: 8}  # to a box of 3 x 3 beamwidths: how often they are drawn
LOOKS = 512  # of the documented rays, at all windows together
DENSITIES = (0.25, 1.0, 4.0, 16.0)
RIGHT_AT = 1000.0  # m: where the documented level, which is relative, is set right
WORDS = {"rays": "uniform rays", "stratified": "stratified rays", "sobol": "Sobol' rays"}

Powers = NDArray[np.float64]  # (T,) of each window [W]


@dataclass(frozen=True)
class Sampler:
    """One sampler at one setting: `draw(seed)` gives the powers (T,) that it finds in each window.

    azimuths: how many one draw works out; draws: how many a chart takes.
    """

    family: str
    setting: str
    draw: Callable[[int], Powers]
    azimuths: int
    draws: int
    preset: str | None = None


def samplers(scene: Scene, windows: list[Window], occlusion: OcclusionScene, most_rays: int) -> list[Sampler]:
    """Every sampler at every setting, up to `most_rays` rays to a box of 3 x 3 beamwidths. scene: stopped, and diffuse."""
    presets = {p.scatterers_per_cell: n for n, p in PRESETS.items() if p.engine == "corrected" and p.sampler == "scatterers"}
    turn = scene.radar.azimuths
    found = [
        Sampler("scatterers", f"{d:g} per cell", partial(scattered, scene, windows, occlusion, d), turn, 24, presets.get(d))
        for d in DENSITIES
    ]
    rays = {count: draws for count, draws in RAYS.items() if count <= most_rays}
    for sampler, words in WORDS.items():
        found += [
            Sampler(words, f"{n}", partial(cast, scene, windows, occlusion, sampler, n), turn, draws)
            for n, draws in rays.items()
        ]
    documented, looks = Documented(scene, windows), max(8, LOOKS // len(windows))
    names = {scene.radar.rays: "documented"}
    return found + [
        Sampler("documented rays", f"{n}", partial(documented.draw, n), len(windows), looks, names.get(n)) for n in rays
    ]


def powers_in(windows: list[Window], echoes: Echoes) -> Powers:
    """Power (T,) [W] of echoes in each window, phases apart."""
    power = np.abs(echoes.amplitude) ** 2
    return np.array([power[w.holds(echoes.azimuth, echoes.range)].sum() for w in windows])


def scattered(scene: Scene, windows: list[Window], occlusion: OcclusionScene, per_cell: float, seed: int) -> Powers:
    """Scatterers, laid anew on every body."""
    keys = range(len(scene.bodies))
    ensemble = build_scatterers(scene.bodies, scene.radar, scene.antenna(0.0)[0], per_cell, seed, keys)
    return powers_in(windows, resting_echoes(scene, ensemble, occlusion, heard_reach(scene.radar)).echoes)


def cast(scene: Scene, windows: list[Window], occlusion: OcclusionScene, sampler: str, rays: int, seed: int) -> Powers:
    """A turn of rays, each with its share of the sphere."""
    radar = replace(scene.radar, rays=rays)
    caster = RayCaster(scene.bodies, radar, occlusion.earth_radius, sampler, seed)
    none = build_scatterers([], radar, scene.antenna(0.0)[0], 1.0, seed, [])
    ensemble = RaySampledSet(scene.bodies, np.arange(len(scene.bodies)), none, caster)
    return powers_in(windows, resting_echoes(scene, ensemble, occlusion, heard_reach(scene.radar)).echoes)


class Documented:
    """The documented rays, thrown for one azimuth at a time and all alike: power as (R^-2)^2 a hit, over a flat earth.

    Its level is relative. It is set so that a surface 1 km away is right, whatever the material (which it does not know).
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
        self._near = [self._in_the_box(window) for window in windows]

    def _in_the_box(self, window: Window) -> NDArray[np.int64]:
        """The bodies whose bounding sphere reaches into the rays thrown at a window, as the documented chain asks no others."""
        antenna, solids = self._scene.antenna(0.0)[0], self._solids
        centre = np.array([s.position + s.rotation @ s.triangles.centre for s in solids]) - antenna
        radius, level = np.array([s.triangles.radius for s in solids]), np.hypot(centre[:, 0], centre[:, 1])
        half = np.arcsin(np.minimum(radius / np.maximum(level, radius), 1.0))
        off = wrap_angle(np.arctan2(centre[:, 0], centre[:, 1]) - window.azimuth - window.angle / 2.0)
        return np.flatnonzero((level <= radius) | (np.abs(off) <= REACH * self._scene.radar.beamwidth + half))

    def draw(self, rays: int, seed: int) -> Powers:
        """Powers (T,) [W], each window looked at by one azimuth with rays of its own."""
        return np.array([self._look(k, rays, generator(seed, CHART, 1, k)) for k in range(len(self._windows))])

    def _look(self, number: int, rays: int, random: np.random.Generator) -> float:
        window, near = self._windows[number], self._near[number]
        radar, antenna = self._scene.radar, self._scene.antenna(0.0)[0]
        azimuth = window.azimuth + window.angle / 2.0 + azimuth_offsets(random, rays, radar.beamwidth)
        elevation = radar.tilt + elevation_offsets(random, rays, radar.beamwidth_el)
        sight = direction(azimuth, elevation)
        each = np.array([nearest([self._solids[body]], antenna, sight) for body in near])
        first, body = each.min(axis=0), near[each.argmin(axis=0)]
        met = np.isfinite(first) & (antenna[2] + first * np.sin(elevation) >= 0.0)
        met &= window.holds(azimuth, np.where(np.isfinite(first), first, 0.0))
        box = (3.0 * radar.beamwidth) * (3.0 * radar.beamwidth_el) / rays
        gain = radar.pattern_el.gain(elevation[met] - radar.tilt, radar.beamwidth_el)
        level = received_amplitude(radar, np.full(1, RIGHT_AT))[0] * RIGHT_AT**3  # at 1 km as the radar equation has it
        power = self._gamma[body[met]] * box * (level * gain / (first[met] ** 2 + 1.0)) ** 2
        return float(power.sum())
