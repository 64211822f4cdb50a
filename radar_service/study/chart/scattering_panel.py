"""The third panel: cross-sections of canonical targets by each scattering model, at random turns."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.fidelity import PRESETS
from radar_service.scattering.model import Instant
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.scene.body import Scattering
from radar_service.scene.poses import BodyPoses, map_from_ordered_bodies
from radar_service.scene.world import Scene
from radar_service.study.chart.canonical_targets import (
    DISTANCE,
    CanonicalTarget,
    canonical_targets,
    coherent_cross_sections,
    random_turns,
    turntable_scene,
)
from radar_service.study.chart.frozen_scene import all_scatterers
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.power_panel import mean_and_spread
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Floats

BOUNCES = (1, 2, 3)
MODELS = 2 + len(BOUNCES)  # declared, diffuse, optics


@dataclass(frozen=True)
class Model:
    """One scattering model at one setting, prepared for the targets on their turntables."""

    family: str
    setting: str
    scatterers: ScattererSet
    occlusion: OcclusionScene
    scene: Scene
    preset: str | None

    def cross_sections(self, draw: int) -> Floats:
        """Returns the cross-sections (T,) [m^2] of all targets at the turns of a draw."""
        antenna, time = self.scene.antenna(0.0)[0], float(draw)
        echoes = self.scatterers.echoes(antenna, Instant(time, self.occlusion, 2.0 * DISTANCE))
        poses = BodyPoses(self.scatterers.bodies).each_at(time)
        position = map_from_ordered_bodies(echoes.position, echoes.body, poses)
        count = len(self.scatterers)
        return coherent_cross_sections(self.scene.radar, antenna, position, echoes.amplitude, echoes.body, count)


def scattering_models(scene: Scene, targets: list[CanonicalTarget], turns: Floats, seed: int) -> list[Model]:
    """Returns declared cross-sections, diffuse surfaces, and physical optics with one to three bounces."""
    presets: dict[int, list[str]] = {}
    for name, preset in PRESETS.items():
        if preset.engine == "corrected":
            presets.setdefault(preset.bounces, []).append(name)

    def model(
        family: str, setting: str, scattering: Scattering | None, bounces: int = 1, preset: str | None = None
    ) -> Model:
        turntables = turntable_scene(scene, targets, turns, scattering)
        scatterers = all_scatterers(turntables, replace(PRESETS["balanced"], bounces=bounces), seed)
        return Model(family, setting, scatterers, OcclusionScene(turntables.bodies, np.inf), turntables, preset)

    optics = [
        model("physical optics", f"{b} bounce{'s' * (b > 1)}", "optics", b, ", ".join(presets.get(b, [])) or None)
        for b in BOUNCES
    ]
    return [model("declared cross-section", "rcs", None), model("diffuse surface", "diffuse", "diffuse"), *optics]


def scattering_points(scene: Scene, draws: int, seed: int, done: Callable[[], object]) -> list[Point]:
    """Returns one point for each scattering model, from `draws` random turns of the targets.

    A model is evaluated once a scan, so each azimuth bears its share of the time. `done` is called after each evaluation.
    """
    targets = canonical_targets(scene.radar.wavelength)
    turns = random_turns(targets, draws, seed)
    models = scattering_models(scene, targets, turns, seed)
    theory = np.stack([target.cross_section(turns[:, k]) for k, target in enumerate(targets)], axis=1)
    for model in models:
        model.cross_sections(0)  # facets are cut once for a distance; that is not timed
    results: list[list[Floats]] = [[] for _ in models]

    def task(k: int) -> Callable[[], object]:
        return lambda: results[k].append(models[k].cross_sections(len(results[k])))

    times = time_interleaved([task(k) for k in range(len(models))], [draws] * len(models), done)
    azimuths = scene.radar.azimuths
    return [_point(m, t, np.stack(r), theory, azimuths) for m, t, r in zip(models, times, results, strict=True)]


def _point(model: Model, times: Sequence[float], result: Floats, theory: Floats, azimuths: int) -> Point:
    per_azimuth = tuple(t / azimuths for t in times)
    return Point(
        "scattering", model.family, model.setting, per_azimuth, False, *mean_and_spread(result, theory), model.preset
    )
