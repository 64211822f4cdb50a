"""Good trackers of the tests as programs, so that `bench-tracker` judges them by its verdicts: in the checkout

    radar-service bench-tracker msc192-table3-1 --seeds 1000 --tracker "python -m tests.bench.judged_tracker Kalman" -o judged

Each is tuned as the scenario tunes the reference, which the header names, and tracks relative to own ship.
"""

import json
import sys
from collections.abc import Iterable
from typing import TextIO

from radar_service.bench.scenario import TrackerSettings, load_scenario
from radar_service.bench.trackers.callable_child import serve
from radar_service.bench.trackers.reckoning import ReckonedTracker
from tests.bench import known_trackers as known

TRACKERS: dict[str, type[known.Kalman]] = {"Kalman": known.Kalman, "StraightLine": known.StraightLine}


def settings_of(header: str) -> TrackerSettings:
    """How the scenario of a header, the first line, tunes trackers."""
    return load_scenario(json.loads(header)["scenario"]).tracker


def answer(name: str, lines: Iterable[str], answers: TextIO) -> None:
    """Answers the header and the scans of a run."""
    lines = iter(lines)
    serve(ReckonedTracker(TRACKERS[name](settings_of(next(lines)))), lines, answers)


if __name__ == "__main__":
    answer(sys.argv[1], sys.stdin, sys.stdout)
