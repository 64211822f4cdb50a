"""The third panel: cross-sections of canonical targets by each scattering model, at random turns."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.records.fidelity import PRESETS
from radar_service.study.chart.canonical_targets import CanonicalTarget, canonical_targets, plates
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.power_panel import mean_and_spread
from radar_service.study.chart.turntables import Turntables, random_turns, turntables
from radar_service.world.scene import Scene

BOUNCES = (1, 2, 3)
MODELS = 2 + len(BOUNCES)  # declared, diffuse, optics


@dataclass(frozen=True)
class Model:
    """One scattering model at one setting, prepared for the targets on their turntables."""

    family: str
    setting: str
    tables: tuple[Turntables, ...]
    preset: str | None

    def cross_sections(self, draw: int) -> Floats:
        """Returns the cross-sections (T,) [m^2] of all targets at the turns of a draw."""
        return np.concatenate([table.cross_sections(draw) for table in self.tables])


def all_targets(wavelength: float, polarization: str) -> list[list[CanonicalTarget]]:
    """Returns all targets, those together that share a scene: at rest in free space, over the sea, and turning."""
    each = [*canonical_targets(wavelength), *plates(wavelength, polarization)]
    at_rest = [target for target in each if not target.over_sea and not target.rate]
    return [at_rest, [target for target in each if target.over_sea], [target for target in each if target.rate]]


def scattering_models(scene: Scene, groups: list[list[CanonicalTarget]], turns: Floats, seed: int) -> list[Model]:
    """Returns declared cross-sections, diffuse surfaces, and physical optics with one to three bounces.

    groups: targets that share a scene; turns: (S, T) [rad] of all of them.
    """
    presets: dict[int, list[str]] = {}
    for name, preset in PRESETS.items():
        if preset.engine == "corrected":
            presets.setdefault(preset.bounces, []).append(name)
    columns = np.split(turns, np.cumsum([len(group) for group in groups])[:-1], axis=1)

    def model(family: str, setting: str, scattering: str | None, bounces: int = 1, preset: str | None = None) -> Model:
        fidelity = replace(PRESETS["balanced"], bounces=bounces)
        tables = (
            turntables(scene, *targets_and_turns, scattering, fidelity, seed)
            for targets_and_turns in zip(groups, columns, strict=True)
        )
        return Model(family, setting, tuple(tables), preset)

    optics = [
        model("physical optics", f"{b} bounce{'s' * (b > 1)}", "optics", b, ", ".join(presets.get(b, [])) or None)
        for b in BOUNCES
    ]
    return [model("declared cross-section", "rcs", None), model("diffuse surface", "diffuse", "diffuse"), *optics]


def scattering_points(scene: Scene, draws: int, seed: int, done: Callable[[], object]) -> list[Point]:
    """Returns one point for each scattering model, from `draws` random turns of the targets.

    A model is evaluated once a scan, so each azimuth bears its share of the time. `done` is called after each evaluation.
    """
    groups = all_targets(scene.radar.wavelength, scene.radar.polarization)
    targets = [target for group in groups for target in group]
    turns = random_turns(targets, draws, seed)
    models = scattering_models(scene, groups, turns, seed)
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
