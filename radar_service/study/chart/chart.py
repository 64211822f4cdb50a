"""The study of speed against accuracy: measure, judge, draw, write."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from radar_service.scene.error import SceneError
from radar_service.scene.world import Scene
from radar_service.study.chart.drawing import Panel, chart_sheet
from radar_service.study.chart.field_panel import field_points, task_for, turns_of
from radar_service.study.chart.point import Point, pareto
from radar_service.study.chart.power_panel import power_points, windows_of
from radar_service.study.chart.provenance import commit, machine
from radar_service.study.chart.reading import reading
from radar_service.study.chart.samplers import samplers
from radar_service.study.chart.scattering_panel import MODELS, scattering_points
from radar_service.study.chart.signal_chain import methods
from radar_service.study.chart.still import all_echoes, diffuse_alone, landscape_of, stopped
from radar_service.study.chart.surface_twin import SurfaceTwin, Window
from radar_service.study.chart.twin import twin_error_db

Floats = NDArray[np.float64]
Result = TypeVar("Result")
SURE = 0.05 * np.log(10.0) / 10.0  # 0.05 dB
FINER = 3  # times the lattice of a target is made finer
FAINTEST = 1e-300  # W


@dataclass(frozen=True)
class Effort:
    """How much is measured: echoes kept for errors, tiles of spokes timed, repeats of each time, targets, most draws of a
    sampler, CPU time [s] after which a panel repeats nothing, most rays to a box, directions across and up the lattice of
    the surfaces' twin, and turns of the bodies that scattering models are judged on."""

    echoes: int
    tiles: int
    repeats: int
    targets: int
    draws: int
    seconds: float
    rays: int
    lattice: tuple[int, int]
    turns: int


FULL = Effort(400, 3, 3, 8, 512, 60.0, 32_000, (128, 256), 16)  # a big scene then takes two minutes and a half in all
QUICK = Effort(40, 1, 2, 3, 4, 10.0, 2_000, (32, 64), 4)
PANELS = ("field", "power", "scattering")
MEAN_AND_SPREAD = "error of the mean and spread of one draw, dB"


@dataclass(frozen=True)
class Chart:
    """Points, and what else chart.json says."""

    scene: Scene
    points: tuple[Point, ...]
    facts: dict[str, Any]

    @property
    def real_time(self) -> float:
        """Seconds that one azimuth may take at the scene's rpm."""
        return self.scene.radar.spoke_period

    def as_dict(self) -> dict[str, Any]:
        """Plain data: every point, the front of each panel as indices, the reading, the machine and the commit."""
        fronts = {
            panel: [self.points.index(p) for p in pareto(q for q in self.points if q.panel == panel)] for panel in PANELS
        }
        return {
            "scene": self.scene.name, "commit": commit(), "machine": machine(),
            "real_time_seconds_per_azimuth": self.real_time,
            **self.facts, "reading": reading(self.points, self.real_time), "fronts": fronts,
            "points": [point.as_dict() for point in self.points],
        }  # fmt: skip


def measured(scene: Scene, seed: int = 0, effort: Effort = FULL, bar: bool = False) -> Chart:
    """All methods on one scene. bar: show progress on a terminal. Raises SceneError where there is nothing to compare."""
    still = stopped(scene)
    found, facts = [], {"seed": seed}
    for part in (_field, _power):
        points, said = part(still, seed, effort, bar)
        found += points
        facts |= said
    if not found:
        raise SceneError(
            f'scene "{scene.name}": it has neither an echo within its range nor a diffuse surface in sight, so nothing can be '
            "compared; add a body in sight"
        )  # fmt: skip
    models = _with_bar(
        "scattering models", effort.turns * MODELS, bar, lambda done: scattering_points(still, effort.turns, seed, done)
    )
    return Chart(scene, (*found, *models), facts)


def _field(scene: Scene, seed: int, effort: Effort, bar: bool) -> tuple[list[Point], dict[str, Any]]:
    """Points of the signal chain, none where there is no echo."""
    radar = scene.radar
    echoes = all_echoes(scene, seed)
    if not np.any(echoes.range < radar.range_max):
        return [], {}
    task, all_methods = task_for(radar, echoes, effort.echoes, effort.tiles, seed), methods(radar)
    points = _with_bar(
        "signal chain", turns_of(all_methods, effort.repeats), bar,
        lambda done: field_points(task, all_methods, effort.repeats, done, effort.seconds),
    )  # fmt: skip
    return points, {
        "field_echoes": len(echoes.range),
        "field_echoes_compared": len(task.thinned.range),
        "field_spokes_compared": len(task.turn),
        "field_twin_error_db": twin_error_db(radar),
    }


def _power(scene: Scene, seed: int, effort: Effort, bar: bool) -> tuple[list[Point], dict[str, Any]]:
    """Points of the samplers, none where there is no diffuse surface in sight."""
    scene = diffuse_alone(scene)
    if not scene.bodies:
        return [], {}
    windows = windows_of(scene, all_echoes(scene, seed + 1), effort.targets)
    truth, coarse = _with_bar("reference", len(windows), bar, lambda done: _truth(scene, windows, effort.lattice, done))
    seen = np.flatnonzero((truth > 0.0) & (coarse > 0.0))
    if not len(seen):
        return [], {}
    kept = [windows[k] for k in seen]
    tried = samplers(scene, kept, landscape_of(scene), effort.rays)
    points = _with_bar(
        "samplers", sum(min(effort.draws, s.draws) for s in tried), bar,
        lambda done: power_points(tried, truth[seen], effort.draws, seed, done, effort.seconds),
    )  # fmt: skip
    doubt = float(np.abs(10.0 * np.log10(truth[seen] / coarse[seen])).max())
    return points, {"power_targets": len(kept), "power_twin_error_db": doubt}


def _truth(
    scene: Scene, windows: list[Window], lattice: tuple[int, int], done: Callable[[], object]
) -> tuple[Floats, Floats]:
    """Mean power (T,) [W] of each window from a lattice of rays, and from one half as fine, which says how sure it is: it is
    made finer until they differ by at most SURE, up to FINER times."""
    twin, found = SurfaceTwin(scene), np.zeros((2, len(windows)))
    for k, window in enumerate(windows):
        coarse, fine = (twin.power(window, lattice[0] >> step, lattice[1] >> step) for step in (1, 0))
        for step in range(1, FINER + 1):
            if abs(np.log(max(fine, FAINTEST) / max(coarse, FAINTEST))) <= SURE:
                break
            coarse, fine = fine, twin.power(window, lattice[0] << step, lattice[1] << step)
        found[:, k] = fine, coarse
        done()
    return found[0], found[1]


def _with_bar(words: str, total: int, wanted: bool, work: Callable[[Callable[[], object]], Result]) -> Result:
    with tqdm(total=total, desc=words, disable=None if wanted else True) as bar:
        return work(bar.update)


def write(chart: Chart, folder: Path) -> dict[str, Any]:
    """chart.svg, chart.png, chart.json and reading.txt into an existing folder; what chart.json says."""
    said = chart.as_dict()
    sheet = chart_sheet(
        f'Speed against accuracy on "{chart.scene.name}"', _subtitle(said), _panels(chart), chart.real_time, said["reading"]
    )
    (folder / "chart.svg").write_text(sheet.svg(said["reading"]), encoding="utf-8")
    (folder / "chart.png").write_bytes(sheet.png())
    (folder / "chart.json").write_text(json.dumps(said, indent=1), encoding="utf-8")
    (folder / "reading.txt").write_text(said["reading"] + "\n", encoding="utf-8")
    return said


def _panels(chart: Chart) -> list[Panel]:
    field, power, models = ([p for p in chart.points if p.panel == panel] for panel in PANELS)
    panels = [
        Panel("Signal chain: field against the closed form", "relative field error, dB", field, False, -120.0),
        Panel("Samplers: mean power of targets", MEAN_AND_SPREAD, power, True, 0.01),
        Panel("Scattering models: reflectors whose cross-section theory knows", MEAN_AND_SPREAD, models, True, 0.1),
    ]
    return [panel for panel in panels if panel.points]


def _subtitle(said: dict[str, Any]) -> str:
    where = said["machine"]
    return (
        f"lower left is better; grey band: Pareto front; hollow: time carried over from fewer echoes. "
        f"{where['processor']}, {_short(said['commit'])}"
    )


def _short(commit: str) -> str:
    return commit if commit.startswith("version") else f"commit {commit[:10]}"
