"""The command `plots`: extracts plots, and tells by labels what each is of."""

import argparse
import json
import sys
from collections.abc import Iterable
from functools import partial

from radar_service.commands.shared_options import add_radar, add_scene, add_simulation, simulator_options
from radar_service.display.units import add_unit
from radar_service.plots import PFA, PlotExtractor, PlotReport, Threshold, in_clutter, labelled_plots, threshold
from radar_service.scans import Scan
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.terminal import (
    UsageError,
    add_overwrite,
    add_whole_number,
    file_ending,
    number_between,
    prepare,
    progress,
    write_file,
)
from radar_service.trace import LandMask
from radar_service.world import Scene

NEVER = "-"
GUARD, WINDOW = 100.0, 300.0  # m
MAX_PLOTS = 10_000  # of a scan: the strongest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    add_simulation(parser)
    add_radar(parser)
    add_scene(parser)
    add_whole_number(parser, "--scans", 10, 1, 10_000, help="revolutions (default 10)")
    choices, usual = ["known", "ca", "os", "marine"], "default marine in sea, rain and land, else ca"
    parser.add_argument("--threshold", choices=choices, help=f"see docs/plots.md ({usual})")
    probability = partial(number_between, lower=0.0, upper=1.0, allowed="a probability between 0 and 1, as 1e-4")
    length = partial(number_between, lower=0.0, upper=1e6, allowed="a length above 0 m, as 100")
    parser.add_argument("--pfa", type=probability, help="false alarms per cell (default 1e-4; of marine 5e-6)")
    parser.add_argument("--nearest-m", default=0.0, type=length, metavar="M", help="plots nearer are left out")
    parser.add_argument("-o", "--out", type=partial(file_ending, suffix=".json"), help="file.json to write")
    parser.add_argument("--png", type=partial(file_ending, suffix=".png"), help="file.png to write: the plots on the PPI")
    add_unit(parser, "--png")
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises SceneError, UsageError, MissingExtra and OSError."""
    if options.fidelity == "documented":
        raise UsageError("--fidelity: documented has no labels; choose another fidelity")
    try:
        return _plots(options)
    except ValueError as error:
        raise UsageError(str(error)) from None


def _plots(options: argparse.Namespace) -> int:
    prepare((options.out, options.png), options.overwrite)
    if options.png:
        from radar_service.plots.picture import write_picture  # an extra that is missing is told first
    make = simulator_options(options, options.threads, labels=True)
    simulator = make(load_scene(options.scene).for_radar(options.radar))
    tell = partial(print, file=sys.stderr, flush=True)
    scene = simulator.scene
    extractor = PlotExtractor(
        scene.radar, _threshold(options, scene), max_plots=MAX_PLOTS, nearest=options.nearest_m, tell=tell,
        land=LandMask.of(scene.bodies),
    )  # fmt: skip
    report = labelled_plots(simulator, extractor, options.scans, partial(_progress, simulator))
    print(table(report), end="")
    if options.out:
        write_file(options.out, json.dumps(report.as_dict(), indent=1, allow_nan=False))
    if options.png:
        write_picture(options.png, report, options.unit)
    return 0


def _threshold(options: argparse.Namespace, scene: Scene) -> Threshold:
    kind = options.threshold or ("marine" if in_clutter(scene) else "ca")
    pfa = options.pfa or (PFA if kind == "marine" else 1e-4)
    return threshold(kind, scene.radar, pfa, GUARD, WINDOW)


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
