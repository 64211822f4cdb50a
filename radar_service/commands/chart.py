"""The command `chart`: measures speed and accuracy of every method on a scene."""

import argparse
from functools import partial
from pathlib import Path

from radar_service.commands.shared_options import add_scene, add_scheduler, workers_of
from radar_service.scene_file import load_scene
from radar_service.terminal import add_whole_number, make_folder, progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    add_scene(parser)
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for chart.svg, .png, .json and summary.txt")
    add_whole_number(parser, "--seed", 0, 0, 2**63 - 1, help="default 0")
    add_scheduler(parser)
    parser.add_argument("--quick", action="store_true", help="take seconds instead of minutes, with fewer samples")


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status.

    Raises SceneError, UsageError, MissingExtra and OSError, and JobsFailed for a fault.
    """
    from radar_service.study.chart import chart  # here: it needs an extra, and `--help` does not
    from radar_service.study.chart.figure import summary_text

    make_folder(options.out)
    shown = partial(progress, unit="panels", name=lambda outcome: outcome.job.name)
    effort, scene = chart.QUICK if options.quick else chart.FULL, load_scene(options.scene)
    with workers_of(options) as (executor, _):
        measured = chart.measure(scene, options.seed, effort, executor, shown)
    data = chart.write_chart(measured, options.out)
    print(summary_text(data["summary"]), end="")
    return 0
