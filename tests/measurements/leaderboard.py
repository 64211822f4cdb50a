"""Runs the trackers of docs/leaderboard.md on its scenarios, records the worst event of each, and writes the table.

    pip install motpy && nice python -m tests.measurements.leaderboard FOLDER [SEEDS]

FOLDER keeps plots and runs. The row of the ARPA comes from FOLDER/arpa, which `.ci/witnesses FOLDER` makes.
Twenty minutes at first.
"""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.reference.docs_tables import DOCS, table, write_measured

SCENARIOS = ("crossing-cpa-500", "overtaking", "late", "target-manoeuvre")
TRACKERS = {
    "GNN": "gnn", "JPDA": "jpda", "IMM": "tests.bench.known_trackers:Imm",
    "motpy": f"{sys.executable} docs/examples/motpy_tracker.py",
}  # fmt: skip
PROFILES = {"clean": [], "inland": ["--profile", "inland"]}
ARPA = "ARPA on video"  # its own two scenarios, once, by `.ci/witnesses`: no rank beside those on plots
HEAD = ("tracker", "clean: OSPA [m]", "runs missed", "inland: OSPA [m]", "runs missed", "worst when clean")
Summary = Mapping[str, Any]  # of a scenario, of a report


def judged(folder: Path, seeds: int, name: str, profile: str) -> list[Summary]:
    """Lets the bench judge a tracker; returns the summaries of its report. Raises OSError without one."""
    out = folder / f"{profile}-{name.lower()}"
    command = [
        sys.executable, "-m", "radar_service", "bench-tracker", *SCENARIOS, "--seeds", str(seeds), "--fixed", "--open",
        *PROFILES[profile], "--tracker", TRACKERS[name], "--plots", str(folder / "plots"), "--record", "-o", str(out),
    ]  # fmt: skip
    subprocess.run(command, cwd=DOCS.parent, check=False, stdout=subprocess.DEVNULL)
    return report_of(out)


def report_of(out: Path) -> list[Summary]:
    """The summaries of a report."""
    summaries: list[Summary] = json.loads((out / "report.json").read_text(encoding="utf-8"))["scenarios"]
    return summaries


def figures(summaries: Sequence[Summary]) -> tuple[str, str]:
    """The mean OSPA over scenarios, and how many of how many runs miss a limit."""
    missed, runs = (sum(len(each[key]) for each in summaries) for key in ("failed_runs", "seeds"))
    return f"{np.mean([each['metrics']['ospa_m'] for each in summaries]):.1f}", f"{missed} of {runs}"


def worst(summaries: Sequence[Summary]) -> str:
    """The recording of the run that misses most limits, and its gravest event."""
    failed = [(len(run["missed"]), each, run) for each in summaries for run in each["failed_runs"][:1]]
    if not failed:
        return "none"
    _, scenario, run = max(failed, key=lambda each: each[0])
    kinds = [event["kind"] for event in run["events"][:1]]
    return " ".join([f"`{scenario['name']}-seed-{scenario['seeds'].index(run['seed'])}`", *kinds])


def main(folder: Path, seeds: int) -> None:
    """Judges all trackers and writes the table, the best on clean plots first, the ARPA apart."""
    rows = []
    for name in TRACKERS:
        clean, inland = (judged(folder, seeds, name, profile) for profile in PROFILES)
        rows.append((name, *figures(clean), *figures(inland), worst(clean)))
    rows.sort(key=lambda row: float(row[1]))
    if (folder / "arpa").exists():
        arpa = report_of(folder / "arpa")
        rows.append((ARPA, *figures(arpa), "", "", worst(arpa)))
    write_measured("leaderboard", table(HEAD, rows), "leaderboard")


if __name__ == "__main__":
    main(Path(sys.argv[1]).absolute(), int((sys.argv[2:] or ["3"])[0]))
