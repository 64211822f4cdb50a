"""The command `plots`: the plots of a scene, told apart by their sources."""

import argparse
import json
from collections.abc import Callable, Iterable
from functools import partial

from radar_service.bench.run import threshold_of
from radar_service.bench.scenario import PlotSettings
from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.labelled_plots import PlotReport, labelled_plots
from radar_service.plots.picture import write_picture
from radar_service.scans.scan import Scan
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from radar_service.terminal.output_files import prepare
from radar_service.terminal.progress import progress
from radar_service.world.scene import Scene

NEVER = "-"


def plots(options: argparse.Namespace, make: Callable[[Scene], Simulator]) -> int:
    """Runs the command; returns the exit status. make: makes the simulator, with labels. Raises SceneError, ValueError and
    OSError."""
    prepare((options.out, options.png), options.overwrite)
    simulator = make(load_scene(options.scene).for_radar(options.radar))
    radar = simulator.scene.radar
    settings = PlotSettings(threshold=options.threshold, pfa=options.pfa, guard_m=options.guard_m, window_m=options.window_m)
    extractor = PlotExtractor(radar, threshold_of(settings, radar), max_plots=options.max_plots)
    report = labelled_plots(simulator, extractor, options.scans, partial(_progress, simulator))
    print(table(report), end="")
    if options.out:
        options.out.write_text(json.dumps(report.as_dict(), indent=1, allow_nan=False), encoding="utf-8")
    if options.png:
        write_picture(options.png, report, options.unit)
    return 0


def _progress(simulator: Simulator, scans: Iterable[Scan], count: int) -> Iterable[Scan]:
    return progress(scans, count, "scans", lambda scan: f"{simulator.scene.name}, seed {simulator.seed}, scan {scan.number}")


def table(report: PlotReport) -> str:
    """Returns the report as text."""
    lines = [
        f"{report.scene}: {report.scans} scans, {len(report.plots)} plots", "",
        f"{'kind':14}{'cells':>12}{'detected':>12}{'share':>11}{'plots per scan':>16}",
    ]  # fmt: skip
    for kind in report.kinds:
        lines.append(f"{kind.kind:14}{kind.cells:12}{kind.detected:12}{_number(kind.share):>11}{kind.plots_per_scan:16.1f}")
    lines += ["", f"{'body':32}{'kind':6}{'range':>9}{'crossings':>11}{'with cells':>12}{'with plot':>11}{'Pd':>7}"]
    for body in report.bodies:
        distance = NEVER if body.range is None else f"{body.range:.0f} m"
        lines.append(
            f"{body.name[:31]:32}{body.kind:6}{distance:>9}{body.crossings:11}{body.with_cells:12}{body.with_plot:11}"
            f"{_number(body.pd):>7}"
        )
    lines += ["", f"remark: {report.remark}"] if report.remark else []
    return "\n".join(lines) + "\n"


def _number(value: float | None) -> str:
    return NEVER if value is None else f"{value:.3g}"
