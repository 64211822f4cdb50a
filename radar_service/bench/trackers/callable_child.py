"""The program in which a tracker in Python runs: `python -m radar_service.bench.trackers.callable_child module:callable`.

It reads and writes JSON Lines (docs/bench.md). What the tracker prints goes to its standard error.
"""

import importlib
import json
import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any, TextIO

from radar_service.bench.trackers.tracker import Tracker, TrackerInput
from radar_service.plots.plot import Plot


def serve(tracker: Tracker, lines: Iterable[str], answers: TextIO) -> None:
    """Answers each scan of some lines; the header is no scan."""
    for message in map(json.loads, lines):
        if message["type"] == "scan":
            tracks = [asdict(track) for track in tracker.update(scan_of(message))]
            print(json.dumps({"type": "tracks", "scan": message["scan"], "tracks": tracks}), file=answers, flush=True)


def scan_of(message: Mapping[str, Any]) -> TrackerInput:
    """Returns the scan that TrackerInput.as_dict has made plain."""
    fields = {name: value for name, value in message.items() if name != "type"}
    return TrackerInput(**{**fields, "plots": tuple(Plot(**_tuples(plot)) for plot in message["plots"])})


def _tuples(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(value) if isinstance(value, list) else value for name, value in fields.items()}


def main(name: str) -> None:
    """Serves `module:callable` on standard input and output."""
    module, _, attribute = name.partition(":")
    sys.path.append(os.getcwd())
    with os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8") as answers:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        serve(getattr(importlib.import_module(module), attribute)(), sys.stdin, answers)


if __name__ == "__main__":
    main(sys.argv[1])
