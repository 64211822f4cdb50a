"""The command `bench-detection`: detection by range against the radar equation, and its report."""

import argparse
from collections.abc import Iterable
from functools import partial

from radar_service.bench.detection.report import criterion, summary, write_detection
from radar_service.bench.detection.study import Counts, detection_study
from radar_service.bench.scenario import load_scenario
from radar_service.terminal.output_files import make_folder
from radar_service.terminal.progress import progress


def bench_detection(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status: 1 where detection is not as predicted. Raises ScenarioError, SceneError and
    OSError."""
    scenario = load_scenario(options.scenario)
    make_folder(options.out)  # refused now, not after the study
    study = detection_study(
        scenario, options.scans, options.ranges, options.jobs, partial(_progress, scenario.name, options.seed), options.seed
    )
    write_detection(study, options.out)
    print(f"{criterion(study)}\n{summary(study)}{options.out / 'detection.html'}")
    return 1 if any(one["word"] == "fail" for series in study["series"] for one in series["targets"]) else 0


def _progress(name: str, seed: int, parts: Iterable[Counts], count: int) -> Iterable[Counts]:
    return progress(parts, count, "parts", lambda part: f"{name}, seed {seed} on, {part.scans} scans")
