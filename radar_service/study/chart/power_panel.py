"""The second panel: the mean power of targets by each sampler, the spread of one draw, and the share of missed targets.

Each draw computes the echoes of the whole frozen scene on boresight, with its own random numbers.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from radar_service.echo import Echoes
from radar_service.engine.documented import Solid, nearest
from radar_service.numerics import (
    CHART,
    EARTH_RADIUS,
    SPEED_OF_LIGHT,
    Floats,
    Indices,
    body_rotation,
    direction,
    generator,
    polar_from_map,
    wrap_angle,
)
from radar_service.propagation import received_amplitude
from radar_service.records import PRESETS
from radar_service.scattering import RayCaster, RaySampledSurfaces, ScattererSet
from radar_service.study.chart.frozen_scene import all_scatterers, echoes_of, is_diffuse
from radar_service.study.chart.point import Sampler
from radar_service.study.chart.reference_surface import Window
from radar_service.trace import BOX_BEAMWIDTHS, OcclusionScene, TriangleScene, azimuth_offsets, elevation_offsets
from radar_service.world import Body, Scene

RAYS = {500: 24, 2000: 24, 8000: 16, 32000: 8}  # rays in a box of 3 x 3 beamwidths: number of draws
DOCUMENTED_DRAWS = 512  # of the documented rays, for all windows together
DENSITIES = (0.25, 1.0, 4.0, 16.0)
CALIBRATION_RANGE = 1000.0  # m; the documented level is relative and is calibrated here
FAMILIES = {"rays": "uniform rays", "stratified": "stratified rays", "sobol": "Sobol' rays"}

Powers = Floats  # (T,) of each window [W]
DEPTH = 20  # range bins of a patch of an extended surface; it is one beamwidth wide
MIN_STRENGTH = 1e-3  # of the strongest patch, after removal of 1/R^4; weaker ones are no targets


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


def target_windows(scene: Scene, pilot: Echoes, limit: int) -> list[Window]:
    """Returns windows of up to `limit` targets of a frozen scene.

    First come its compact diffuse bodies, up to half of them; then patches of extended surfaces, evenly from near to far,
    among the strong ones by the `pilot` echoes.
    """
    radar = scene.radar
    compact = [window for body in scene.bodies if (window := _body_window(scene, body)) is not None][: max(1, limit // 2)]
    depth, width = DEPTH * radar.range_step, 2.0 * np.pi / np.ceil(2.0 * np.pi / radar.beamwidth)
    free = (pilot.range < radar.range_max) & (pilot.range > max(radar.range_min, depth))
    for window in compact:
        free &= ~window.contains(pilot.azimuth, pilot.range)
    if not free.any() or len(compact) >= limit:
        return compact
    sector = np.floor(pilot.azimuth[free] % (2.0 * np.pi) / width).astype(np.int64)
    ring = np.floor(pilot.range[free] / depth).astype(np.int64)
    patch, index = np.unique(np.stack([ring, sector], axis=1), axis=0, return_inverse=True)
    strength = np.bincount(index.ravel(), np.abs(pilot.amplitude[free]) ** 2) * (patch[:, 0] + 0.5) ** 4
    strong = patch[strength > MIN_STRENGTH * strength.max()]
    chosen = strong[np.unique(np.linspace(0, len(strong) - 1, limit - len(compact)).astype(np.int64))]
    return compact + [Window(float(s * width), float(width), float(r * depth), float((r + 1) * depth)) for r, s in chosen]


def _body_window(scene: Scene, body: Body) -> Window | None:
    """Returns the window around a diffuse body that is smaller than a beamwidth and than DEPTH bins, or None."""
    if not is_diffuse(body) or body.mesh is None:
        return None
    radar, pose = scene.radar, body.motion.pose(0.0)
    polar = polar_from_map(pose.position[0], scene.antenna(0.0)[0], scene.environment.earth_factor * EARTH_RADIUS)
    size = float(np.linalg.norm(body.mesh.vertices, axis=1).max()) + SPEED_OF_LIGHT * 1e-9
    if 2.0 * size > min(radar.beamwidth * float(polar.range), DEPTH * radar.range_step):
        return None
    half = size / float(polar.distance)
    start = float(polar.azimuth) - half
    return Window(float(wrap_angle(np.array(start))), 2.0 * half, float(polar.range) - size, float(polar.range) + size)
