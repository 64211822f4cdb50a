"""The command `bench-detection`: detection by range against the radar equation, and its report."""

import argparse
from collections.abc import Iterable
from typing import Any

from tqdm import tqdm

from radar_service.tracking.detection_report import criterion, summary, write_detection
from radar_service.tracking.detection_study import detection_study
from radar_service.tracking.scenario import load_scenario


def bench_detection(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status: 1 where detection is not as predicted. Raises ScenarioError, SceneError and
    OSError."""
    scenario = load_scenario(options.scenario)
    study = detection_study(scenario, options.scans, options.ranges, options.jobs, _progress, options.seed)
    write_detection(study, options.out)
    print(f"{criterion(study)}\n{summary(study)}{options.out / 'detection.html'}")
    return 1 if any(one["word"] == "fail" for series in study["series"] for one in series["targets"]) else 0


def _progress(parts: Iterable[Any], count: int) -> Iterable[Any]:
    bar: Iterable[Any] = tqdm(parts, total=count, unit="parts", disable=None)
    return bar
