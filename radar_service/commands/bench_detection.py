"""The command `bench-detection`: compares detection by range with the radar equation."""

import argparse
from functools import partial
from pathlib import Path

from radar_service.batch.jobs import JobsFailed
from radar_service.bench.detection.report import criterion, summary, write_detection
from radar_service.bench.detection.study import detection_study
from radar_service.bench.scenario import ScenarioError, load_scenario
from radar_service.commands.shared_options import add_jobs, executor_of
from radar_service.terminal.arguments import UsageError, add_whole_number
from radar_service.terminal.output_files import make_folder
from radar_service.terminal.progress import progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument(
        "scenario", nargs="?", default="msc192-table2", metavar="SCENARIO",
        help="whose targets are points: a name of bench-tracker --list, or a .toml file (default msc192-table2)",
    )  # fmt: skip
    add_whole_number(parser, "--scans", 100, 40, 100_000, metavar="N", help="of each range (default 100)")
    add_whole_number(parser, "--ranges", 16, 2, 200, metavar="N", help="of each target (default 16)")
    add_whole_number(parser, "--seed", 0, 0, 2**32, metavar="N", help="default 0")
    add_jobs(parser)
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for detection.json and detection.html")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status: 1 where detection is not as predicted.

    Raises UsageError, SceneError and OSError, and JobsFailed for a fault of the program or of the tracker.
    """
    try:
        return _detection(options)
    except (ScenarioError, JobsFailed) as error:
        if isinstance(error, JobsFailed) and error.is_fault:
            raise
        raise UsageError(str(error)) from None


def _detection(options: argparse.Namespace) -> int:
    scenario = load_scenario(options.scenario)
    make_folder(options.out)  # refused now, not after the study
    shown = partial(progress, unit="parts", name=lambda part: part.job.name)
    with executor_of(options) as executor:
        study = detection_study(scenario, options.scans, options.ranges, executor, shown, options.seed)
    write_detection(study, options.out)
    print(f"{criterion(study)}\n{summary(study)}{options.out / 'detection.html'}")
    return 1 if any(target["word"] == "fail" for series in study["series"] for target in series["targets"]) else 0
