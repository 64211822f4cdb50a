"""The table of docs/accuracy.md#load: python -m tests.measurements.load_table [--seconds 20] [--rows plain,fine,...].

Service, clients and bare server are processes of their own, on loopback. The first line says how busy the machine was: with
others on it latencies are theirs as well. It exits with 1 where a row is beyond its limits.
"""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tests.measurements.fanout import compared

SECONDS = 20.0


@dataclass(frozen=True)
class Case:
    """Clients of a replayed radar, or of the engine with a scene. limits: of what is measured, at most."""

    what: str
    clients: int
    azimuths: int  # at 24 rpm
    bins: int
    limits: dict[str, float]
    stalled: int = 0
    scene: str = ""


STRICT = {"lost": 0, "holes": 0}
CASES = {
    "plain": Case("100 clients x 1638 spokes/s x 1 KiB", 100, 4096, 1024, STRICT | {"p99_ms": 10.0, "cores": 0.4}),
    "fine": Case("100 x 3277/s x 4 KiB", 100, 8192, 4096, STRICT | {"p99_ms": 20.0}),
    "many": Case("500 x 819/s x 1 KiB", 500, 2048, 1024, STRICT | {"p99_ms": 30.0}),
    "stalled": Case(
        "90 of 100 while 10 read nothing", 100, 4096, 1024,
        STRICT | {"p99_ms": 10.0, "mib_each": 2.0, "stale_mb": 0.6, "stalled_holes": 0}, stalled=10,
    ),
    "engine": Case(
        "100 x 1638/s x 1 KiB with the engine at work (harbour)", 100, 4096, 1024,
        STRICT | {"p99_ms": 10.0, "schedule_p99_ms": 5.0, "slips": 0}, scene="harbour",
    ),
}  # fmt: skip
RATIOS = {"large": (65_536, 0.6), "small": (1024, 0.45)}  # bytes of a message, of a bare server's rate at least


@contextlib.contextmanager
def replaying(case: Case, reported: dict[str, Any]) -> Iterator[tuple[str, str, int]]:
    """Host, port and process of the radar of a case; afterwards `told` has what it says of itself."""
    command = [sys.executable, "-m", "tests.measurements.replay", str(case.azimuths), str(case.bins), case.scene]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        host, _, port = process.stdout.readline().split("open http://")[1].strip(" /\n").partition(":")
        try:
            yield host, port, process.pid
        finally:
            process.send_signal(signal.SIGTERM)
            out, _ = process.communicate(timeout=60)
            reported |= json.loads(out.splitlines()[-1])


def memory(process: int) -> int:
    """Resident bytes of a process."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def loaded(case: Case, seconds: float) -> dict[str, Any]:
    """A case played for so long [s]: what its clients and its radar say."""
    reported: dict[str, Any] = {}
    with replaying(case, reported) as (host, port, process):
        before, began = memory(process), time.monotonic()
        query = f"encoding=u8&bins={case.bins}"
        command = [
            sys.executable,
            "-m",
            "tests.measurements.load",
            host,
            port,
            str(case.clients),
            str(seconds),
            str(case.stalled),
        ]
        result: dict[str, Any] = json.loads(
            subprocess.run([*command, query], capture_output=True, text=True, check=True).stdout
        )
        grown, wall = memory(process) - before, time.monotonic() - began
    result |= reported | {"cores": round(reported["processor_s"] / wall, 2), "grown_mib": round(grown / 2**20, 1)}
    if case.stalled:
        others = loaded(replace(case, clients=case.clients - case.stalled, stalled=0), seconds)
        result["mib_each"] = round((result["grown_mib"] - others["grown_mib"]) / case.stalled, 2)
        result["stale_mb"] = round(result["stale_bytes"] / 1e6, 2)
    return result


def broken(result: dict[str, Any], limits: dict[str, float]) -> list[str]:
    """What is beyond its limit."""
    return [f"{name} {result[name]} > {maximum:g}" for name, maximum in limits.items() if result[name] > maximum]


def row(name: str, seconds: float) -> tuple[str, list[str]]:
    """A line of the table, and what in it is beyond its limit."""
    if name in RATIOS:
        size, minimum = RATIOS[name]
        fanout = compared(size, seconds)
        figures = (
            f"{fanout.ratio:.2f} of a bare server ({fanout.feed:.0f} of {fanout.raw:.0f} messages/s), "
            f"{fanout.ratio_core:.2f} in processor time"
        )
        faults = [] if fanout.ratio >= minimum else [f"ratio {fanout.ratio:.2f} < {minimum}"]
        return f"| 100 lossless clients, {size // 1024} KiB messages | {figures} | at least {minimum} |", faults
    case = CASES[name]
    result = loaded(case, seconds)
    figures = ", ".join(f"{WORDS[key]} {result[key]}" for key in dict.fromkeys([*case.limits, *MORE]) if key in result)
    limits = ", ".join(f"{WORDS[key]} {maximum:g}" for key, maximum in case.limits.items())
    return f"| {case.what} | {figures} | {limits} |", broken(result, case.limits)


WORDS = {
    "lost": "lost", "holes": "unannounced", "p50_ms": "p50 [ms]", "p99_ms": "p99 [ms]", "max_ms": "worst [ms]", "cores": "cores",
    "own_cores": "cores of the clients",
    "schedule_p99_ms": "schedule p99 [ms]", "slips": "slips", "mib_each": "MiB each", "stale_mb": "stale MB",
    "stalled_holes": "unannounced to the stalled", "stalled_lost": "lost by a stalled one",
}  # fmt: skip
MORE = ("p50_ms", "max_ms", "cores", "own_cores", "schedule_p99_ms", "slips", "stalled_lost")


def main() -> int:
    """Print the table; 1 where something is beyond its limit."""
    parser = argparse.ArgumentParser(prog="python -m tests.measurements.load_table", description=__doc__)
    names = [*CASES, *RATIOS]
    parser.add_argument("--seconds", type=float, default=SECONDS, help=f"of each row (default {SECONDS:g})")
    parser.add_argument("--rows", default=",".join(names), help=f"of {','.join(names)}")
    requested = parser.parse_args()
    print(f"{requested.seconds:g} s each, {os.cpu_count()} cores, load average before: {os.getloadavg()[0]:.1f}\n")
    print("| load | measured | at most |\n|---|---|---|")
    faults = []
    for name in requested.rows.split(","):
        line, wrong = row(name, requested.seconds)
        print(line, flush=True)
        faults += [f"{name}: {text}" for text in wrong]
    print(f"\nload average after: {os.getloadavg()[0]:.1f}", *faults, sep="\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
