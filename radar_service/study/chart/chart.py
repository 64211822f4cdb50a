"""The study of speed against accuracy: `measure` runs every method on a scene, `write_chart` writes the results and on what."""

import json
import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.batch.jobs import Executor, Job, Progress, run
from radar_service.numerics import Floats, arithmetic
from radar_service.study.chart.field_panel import FLOOR_DB, field_points, workload_of
from radar_service.study.chart.figure import Panel, chart_figure, summary, summary_text
from radar_service.study.chart.frozen_scene import all_echoes, frozen, occlusion_of, only_diffuse
from radar_service.study.chart.point import Point, drawn_points, pareto
from radar_service.study.chart.power_panel import samplers, target_windows
from radar_service.study.chart.reference_surface import ReferenceSurface, Window
from radar_service.study.chart.scattering_panel import scattering_points
from radar_service.study.chart.signal_chain import methods
from radar_service.study.plotting import png_bytes, svg_text
from radar_service.terminal import progress as shown
from radar_service.terminal import write_file
from radar_service.world import Scene, SceneError

PanelResult = tuple[list[Point], dict[str, Any]]  # its points, and facts for chart.json
MeasurePanel = Callable[[Scene, int, "Effort"], PanelResult]
CONVERGED = 0.05 * np.log(10.0) / 10.0  # 0.05 dB
MAX_REFINEMENTS = 3  # of the lattice of rays on a target
MIN_POWER = 1e-300  # W


@dataclass(frozen=True)
class Effort:
    """How much a chart measures.

    echoes: for the field errors; blocks: of spokes that are timed; repeats: of each time; targets: of the samplers; draws: of a
    sampler, at most; seconds: CPU time after which a panel repeats nothing [s]; rays: in a box of 3 x 3 beamwidths, at most;
    lattice: columns and rows of the reference's rays; turns: of the canonical targets, at random."""

    echoes: int
    blocks: int
    repeats: int
    targets: int
    draws: int
    seconds: float
    rays: int
    lattice: tuple[int, int]
    turns: int


FULL = Effort(400, 3, 3, 8, 512, 60.0, 32_000, (128, 256), 16)  # two minutes for a big scene
QUICK = Effort(40, 1, 2, 3, 4, 10.0, 2_000, (32, 64), 4)
PANELS = ("field", "power", "scattering")


@dataclass(frozen=True)
class Chart:
    """The points of a scene, and facts about the measurement for chart.json."""

    scene: Scene
    points: tuple[Point, ...]
    facts: dict[str, Any]

    @property
    def real_time(self) -> float:
        """Time of one azimuth at the scene's rpm [s]."""
        return self.scene.radar.spoke_period

    def of_panel(self, panel: str) -> list[Point]:
        """Returns the points of a panel."""
        return [point for point in self.points if point.panel == panel]

    def as_dict(self) -> dict[str, Any]:
        """Returns plain data: all points, the front of each panel as indices, the summary, the machine and the version."""
        fronts = {panel: [self.points.index(p) for p in pareto(self.of_panel(panel))] for panel in PANELS}
        return {
            "scene": self.scene.name, "version": version("radar-service"),
            "machine": {"processor": _processor(), "cores": os.cpu_count() or 1, "arithmetic": arithmetic()},
            "real_time_seconds_per_azimuth": self.real_time,
            **self.facts, "summary": summary(self.points, self.real_time), "fronts": fronts,
            "points": [point.as_dict() for point in self.points],
        }  # fmt: skip


def measure(
    scene: Scene, seed: int = 0, effort: Effort = FULL, executor: Executor | None = None,
    progress: Progress = lambda outcomes, count: outcomes,
) -> Chart:  # fmt: skip
    """Returns the chart of all methods on a scene.

    executor, progress: of the panels, as `batch.jobs.run`; times are those of the machine that measures a panel. Raises
    SceneError if the scene has nothing to compare, and JobsFailed.
    """
    points: list[Point] = []
    facts: dict[str, Any] = {"seed": seed}
    for panels in ((_field, _power), (_scattering,)):
        jobs = [Job(f"{panel.__name__[1:]} panel", (panel, scene, seed, effort)) for panel in panels]
        for panel_points, panel_facts in run(_measured, jobs, executor, progress=progress):
            points += panel_points
            facts |= panel_facts
        if not points:
            raise SceneError(
                f'scene "{scene.name}": it has neither an echo within its range nor a diffuse surface in sight, so '
                "nothing can be compared; add a body in sight"
            )  # fmt: skip
    return Chart(scene, tuple(points), facts)


def _measured(panel: MeasurePanel, scene: Scene, seed: int, effort: Effort) -> PanelResult:
    """Measures one panel, wherever an executor has it done."""
    return panel(scene, seed, effort)


def _field(scene: Scene, seed: int, effort: Effort) -> PanelResult:
    """Returns the points and facts of the signal chain, none if there is no echo."""
    scene = frozen(scene)
    echoes = all_echoes(scene, seed)
    if not np.any(echoes.range < scene.radar.range_max):
        return [], {}
    workload = workload_of(scene.radar, echoes, effort.echoes, effort.blocks, seed)
    return field_points(workload, methods(scene.radar), effort.repeats, effort.seconds), {
        "field_echoes": len(echoes.range),
        "field_echoes_compared": len(workload.subset.range),
        "field_spokes_compared": len(workload.scan),
    }


def _power(scene: Scene, seed: int, effort: Effort) -> PanelResult:
    """Returns the points and facts of the samplers, none if there is no diffuse surface in sight."""
    scene = only_diffuse(frozen(scene))
    if not scene.bodies:
        return [], {}
    windows = target_windows(scene, all_echoes(scene, seed + 1), effort.targets)
    truth, coarse = _reference_powers(scene, windows, effort.lattice)
    visible = np.flatnonzero((truth > 0.0) & (coarse > 0.0))
    if not len(visible):
        return [], {}
    compared = samplers(scene, [windows[k] for k in visible], occlusion_of(scene), effort.rays)
    points = drawn_points("power", compared, truth[visible], effort.draws, seed, effort.seconds)
    uncertainty = float(np.abs(10.0 * np.log10(truth[visible] / coarse[visible])).max())
    return points, {"power_targets": len(visible), "reference_surface_error_db": uncertainty}


def _scattering(scene: Scene, seed: int, effort: Effort) -> PanelResult:
    """Returns the points of the scattering models."""
    return scattering_points(frozen(scene), effort.turns, seed), {}


def _reference_powers(scene: Scene, windows: list[Window], lattice: tuple[int, int]) -> tuple[Floats, Floats]:
    """Returns the mean powers (T,) [W] of the windows from a lattice of rays, and from one half as fine.

    The lattice is refined until the two differ by at most CONVERGED, up to MAX_REFINEMENTS times.
    """
    surface, powers = ReferenceSurface(scene), np.zeros((2, len(windows)))
    for k, window in enumerate(shown(windows, len(windows), "windows", lambda _: "power panel, reference", within=True)):
        coarse, fine = (surface.power(window, lattice[0] >> step, lattice[1] >> step) for step in (1, 0))
        for step in range(1, MAX_REFINEMENTS + 1):
            if abs(np.log(max(fine, MIN_POWER) / max(coarse, MIN_POWER))) <= CONVERGED:
                break
            coarse, fine = fine, surface.power(window, lattice[0] << step, lattice[1] << step)
        powers[:, k] = fine, coarse
    return powers[0], powers[1]


def write_chart(chart: Chart, folder: Path) -> dict[str, Any]:
    """Writes chart.svg, chart.png, chart.json and summary.txt to an existing folder; returns the data of chart.json."""
    data = chart.as_dict()
    figure = chart_figure(chart.scene.name, _machine_text(data), _panels(chart, data["summary"]), chart.real_time)
    write_file(folder / "chart.svg", svg_text(figure))
    write_file(folder / "chart.png", png_bytes(figure))
    write_file(folder / "chart.json", json.dumps(data, indent=1))
    write_file(folder / "summary.txt", summary_text(data["summary"]))
    return data


def _panels(chart: Chart, notes: dict[str, list[str]]) -> list[Panel]:
    field_error, power_error = "relative field error [dB]", "error of mean and spread [dB]"
    axes = {
        "field": ("Signal chain: field against the closed form", field_error, FLOOR_DB, False),
        "power": ("Samplers: mean power of diffuse targets", power_error, 0.01, True),
        "scattering": ("Scattering models: targets of known cross-section", power_error, 0.1, True),
    }
    return [
        Panel(title, ylabel, chart.of_panel(panel), lowest, notes[panel], log)
        for panel, (title, ylabel, lowest, log) in axes.items()
        if chart.of_panel(panel)
    ]


def _machine_text(data: dict[str, Any]) -> str:
    return f"{data['machine']['processor']}, version {data['version']}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
