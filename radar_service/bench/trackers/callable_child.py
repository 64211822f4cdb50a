"""The program in which a tracker in Python runs: `python -m radar_service.bench.trackers.callable_child module:callable`.

It writes READY where the callable has made a tracker, then reads and writes JSON Lines (docs/bench.md). What the tracker prints
goes to its standard error.
"""

import importlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from typing import Any, TextIO

from radar_service.bench.trackers.tracker import AisTarget, DataSheet, Tracker, TrackerInput, begin_run
from radar_service.plots import Plot
from radar_service.strict_json import tupled

READY = "ready"
FOLDER = "RADAR_SERVICE_FOLDER"  # in the environment: that of the command, where the program has another one


def serve(maker: Callable[[], Tracker], lines: Iterable[str], answers: TextIO) -> None:
    """Answers each scan of some lines, by one tracker for each header; tells one that has `begin_run` the data sheet."""
    waiting = [tracker := maker()]
    print(READY, file=answers, flush=True)
    for message in map(json.loads, lines):
        if message["type"] == "header":
            tracker = waiting.pop() if waiting else maker()
        if "radar" in message:
            begin_run(tracker, DataSheet(**message["radar"]))
        if message["type"] == "scan":
            tracks = [asdict(track) for track in tracker.update(scan_of(message))]
            answer = {"type": "tracks", "scan": message["scan"], "again": True, "tracks": tracks}
            print(json.dumps(answer), file=answers, flush=True)


def scan_of(message: Mapping[str, Any]) -> TrackerInput:
    """Returns the scan that TrackerInput.as_dict, or a file, has made plain."""
    ais, plots = message.get("ais"), tuple(Plot(**tupled(plot)) for plot in message["plots"])
    fields = {name: value for name, value in message.items() if name != "type"}
    reports = None if ais is None else tuple(AisTarget(**report) for report in ais)
    orders = tuple(message.get("orders") or ()) or None
    return TrackerInput(**fields | {"plots": plots, "ais": reports, "orders": orders})


def callable_of(name: str) -> Callable[[], Tracker]:
    """Returns the callable of `module:callable`. Ends the program with a sentence where there is none."""
    module, _, attribute = name.partition(":")
    try:
        imported = importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise  # the module is there, and one that it imports is not
        sys.exit(f"there is no module {error.name!r}, neither installed nor in {os.environ.get(FOLDER, os.getcwd())}")
    maker: Callable[[], Tracker] | None = getattr(imported, attribute, None)
    if not callable(maker):
        there = [key for key, value in vars(imported).items() if callable(value) and not key.startswith("_")]
        sys.exit(f"module {module!r} has no callable {attribute!r}; it has {', '.join(there[:10]) or 'none'}")
    return maker


def main(name: str) -> None:
    """Serves `module:callable` on standard input and output."""
    sys.path.append(os.getcwd())
    with os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8") as answers:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        serve(callable_of(name), sys.stdin, answers)


if __name__ == "__main__":
    main(sys.argv[1])
