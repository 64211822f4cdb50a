"""The command `bench-detection`: compares detection by range with the radar equation, or measures it in sea and rain."""

import argparse
from functools import partial
from pathlib import Path

import numpy as np

from radar_service.bench import Scenario, load_scenario
from radar_service.bench.detection.clutter import BANDS, ClutterCase, clutter_study, clutter_summary
from radar_service.bench.detection.report import criterion, summary, write_detection
from radar_service.bench.detection.study import detection_study
from radar_service.bench.scenario import CLUTTER
from radar_service.commands.shared_options import add_jobs, workers_of
from radar_service.numerics import NAUTICAL_MILE
from radar_service.scene_file import load_scene
from radar_service.terminal import UsageError, add_whole_number, make_folder, progress

NEAREST = 0.25  # NM


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument(
        "scenario", nargs="?", default="msc192-table2", metavar="SCENARIO",
        help="whose targets are points: a name of bench-tracker --list, or a .toml file (default msc192-table2)",
    )  # fmt: skip
    add_whole_number(parser, "--scans", 100, 40, 100_000, metavar="N", help="of each range (default 100)")
    add_whole_number(parser, "--ranges", 16, 2, 200, metavar="N", help="of each target (default 16)")
    add_whole_number(parser, "--seed", 0, 0, 2**32, metavar="N", help="default 0")
    sea = parser.add_argument_group("in sea and rain")
    sea.add_argument("--sea-state", type=_numbers, metavar="S,S", help="seas, as 1,2.5,4 (default the scenario's)")
    sea.add_argument("--rain-mm-h", type=_numbers, metavar="R", help="default the scenario's")
    sea.add_argument("--at-nm", type=_numbers, metavar="NM,NM", help="ranges (default --ranges of them from 0.25 NM)")
    sea.add_argument("--pfa", default=1e-4, type=float, help="false alarms per cell (default 1e-4)")
    sea.add_argument("--looks", default="1/1", metavar="M/N", help="scans of N that must detect, as 8/10 (default 1/1)")
    sea.add_argument("--swerling", type=int, choices=range(5), help="of all targets (default the scenario's)")
    sea.add_argument("--band", choices=[*BANDS], help="X or S (default the scenario's frequency)")
    sea.add_argument("--polarization", choices=["h", "v"], help="default the scenario's")
    add_jobs(parser)
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for detection.json and detection.html")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status: 1 where detection is not as predicted.

    Raises UsageError, SceneError and OSError, and JobsFailed for a fault of the program.
    """
    scenario = load_scenario(options.scenario)
    make_folder(options.out)  # refused now, not after the study
    shown = partial(progress, unit="parts", name=lambda part: part.job.name)
    air = scenario.scene.get("environment", {})
    if options.sea_state or options.rain_mm_h or any(map(air.get, CLUTTER)):
        cases = _cases(options, scenario)
        with workers_of(options) as (executor, _):
            study = clutter_study(scenario, cases, options.scans, executor, shown, options.seed)
        write_detection(study, options.out)
        print(f"{clutter_summary(study)}{options.out / 'detection.html'}")
        return 0
    with workers_of(options) as (executor, _):
        study = detection_study(scenario, options.scans, options.ranges, executor, shown, options.seed)
    write_detection(study, options.out)
    print(f"{criterion(study)}\n{summary(study)}{options.out / 'detection.html'}")
    return 1 if any(target["word"] == "fail" for series in study["series"] for target in series["targets"]) else 0


def _cases(options: argparse.Namespace, scenario: Scenario) -> list[ClutterCase]:
    """The cases of the options. Raises UsageError."""
    scene = load_scene(scenario.scene_for(0))
    air, farthest = scene.environment, scene.radar.range_max / NAUTICAL_MILE
    usual = np.geomspace(NEAREST, max(0.9 * farthest, NEAREST), options.ranges).tolist()
    ranges = tuple(distance * NAUTICAL_MILE for distance in options.at_nm or usual)
    needed, _, of = options.looks.partition("/")
    try:
        return [
            ClutterCase(
                state, rain, ranges, options.pfa, int(needed), int(of), options.swerling, options.band, options.polarization
            )
            for state in options.sea_state or [air.sea_state]
            for rain in options.rain_mm_h or [air.rain_mm_h]
        ]  # fmt: skip
    except ValueError as error:
        raise UsageError(f"--looks, --pfa: {error}") from None


def _numbers(text: str) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = [-1.0]
    if not all(0.0 <= value < 1e6 for value in values):
        raise argparse.ArgumentTypeError(f"{text:.40} is not allowed; numbers of 0 and more with commas between, as 1,2.5")
    return values
