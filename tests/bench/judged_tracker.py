"""Good trackers of the tests as programs, so that `bench-tracker` judges them by its verdicts: in the checkout

    radar-service bench-tracker msc192-table3-1 --seeds 1000 --tracker "python -m tests.bench.judged_tracker Kalman" -o judged

Each is tuned by the data sheet of the header alone, and tracks relative to own ship.
"""

import json
import sys
from collections.abc import Iterable
from typing import TextIO

from radar_service.bench.trackers.callable_child import serve
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import DataSheet
from tests.bench import known_trackers as known

TRACKERS: dict[str, type[known.Imm]] = {"Imm": known.Imm, "Kalman": known.Kalman, "StraightLine": known.StraightLine}


def answer(name: str, lines: Iterable[str], answers: TextIO) -> None:
    """Answers the header and the scans of a run."""
    lines = iter(lines)
    serve(ReckonedTracker(TRACKERS[name](DataSheet(**json.loads(next(lines))["radar"]))), lines, answers)


if __name__ == "__main__":
    answer(sys.argv[1], sys.stdin, sys.stdout)
