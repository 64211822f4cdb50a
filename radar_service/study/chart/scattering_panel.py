"""The third panel: cross-sections of bodies that theory knows as each scattering model has them, turn after turn."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.fidelity import PRESETS
from radar_service.scattering.scatterer_set import ScattererSet, build_scatterers, placed
from radar_service.scene.body import Scattering
from radar_service.scene.poses import BodyPoses
from radar_service.scene.world import Scene
from radar_service.study.chart.anchors import AWAY, Anchor, anchors_for, seen_sections, turns_of, turntables
from radar_service.study.chart.point import Point, in_turns
from radar_service.study.chart.power_panel import judged
from radar_service.trace.line_of_sight import OcclusionScene

Floats = NDArray[np.float64]
BOUNCES = (1, 2, 3)
MODELS = 2 + len(BOUNCES)  # declared, diffuse, optics


@dataclass(frozen=True)
class Model:
    """One scattering model at one setting, its bodies made ready on their turntables."""

    family: str
    setting: str
    ensemble: ScattererSet
    occlusion: OcclusionScene
    scene: Scene
    preset: str | None

    def sections(self, draw: int) -> Floats:
        """Cross-sections (T,) [m^2] of all anchors as they stand in a draw."""
        antenna, time = self.scene.antenna(0.0)[0], float(draw)
        seen = self.ensemble.reflections(self.occlusion, antenna, time, 2.0 * AWAY)
        place = placed(seen.position, seen.body, BodyPoses(self.ensemble.bodies).poses_at(time))
        return seen_sections(self.scene.radar, antenna, place, seen.amplitude, seen.body, len(self.ensemble))


def models_of(scene: Scene, anchors: list[Anchor], turns: Floats, seed: int) -> list[Model]:
    """Declared cross-sections, diffuse surfaces, and physical optics following up to three surfaces in a row."""
    presets: dict[int, list[str]] = {}
    for name, preset in PRESETS.items():
        if preset.engine == "corrected":
            presets.setdefault(preset.bounces, []).append(name)

    def made(family: str, setting: str, scattering: Scattering | None, bounces: int = 1, preset: str | None = None) -> Model:
        on_tables = turntables(scene, anchors, turns, scattering)
        keys, per_cell = range(len(anchors)), PRESETS["balanced"].scatterers_per_cell
        antenna = on_tables.antenna(0.0)[0]
        ensemble = build_scatterers(on_tables.bodies, scene.radar, antenna, per_cell, seed, keys, bounces)
        return Model(family, setting, ensemble, OcclusionScene(on_tables.bodies, np.inf), on_tables, preset)

    optics = [
        made("physical optics", f"{b} bounce{'s' * (b > 1)}", "optics", b, ", ".join(presets.get(b, [])) or None)
        for b in BOUNCES
    ]
    return [made("declared cross-section", "rcs", None), made("diffuse surface", "diffuse", "diffuse"), *optics]


def scattering_points(scene: Scene, draws: int, seed: int, done: Callable[[], object]) -> list[Point]:
    """Every scattering model as a point, from so many turns of the anchors; what is looked at once a turn of the antenna
    costs its share at every azimuth."""
    anchors = anchors_for(scene.radar.wavelength)
    turns = turns_of(anchors, draws, seed)
    models = models_of(scene, anchors, turns, seed)
    truth = np.stack([anchor.section(turns[:, k]) for k, anchor in enumerate(anchors)], axis=1)
    for model in models:
        model.sections(0)  # what is cut once for a distance is not timed
    found: list[list[Floats]] = [[] for _ in models]

    def work(k: int) -> Callable[[], object]:
        return lambda: found[k].append(models[k].sections(len(found[k])))

    times = in_turns([work(k) for k in range(len(models))], [draws] * len(models), done)
    return [_point(m, t, np.stack(f), truth, scene.radar.azimuths) for m, t, f in zip(models, times, found, strict=True)]


def _point(model: Model, times: Sequence[float], found: Floats, truth: Floats, azimuths: int) -> Point:
    each = tuple(t / azimuths for t in times)
    return Point("scattering", model.family, model.setting, each, False, *judged(found, truth), model.preset)
