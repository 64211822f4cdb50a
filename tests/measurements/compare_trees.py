"""Compares two work trees on this machine through their public interfaces: the same bytes, the same speed.

    python -m tests.measurements.compare_trees OLD/.venv/bin/python NEW/.venv/bin/python [--real ../shared/real] [--runs 9]

Each argument is the interpreter of an environment with one tree installed. `tests.measurements.tree_side` runs in both, and what
it leaves is compared file by file: fields of all presets on the shipped scenes, a day of commands to two radars with labels,
powers and truth, errors on purpose, files and recordings, the feed's messages and its replays, answers of REST. Fields
that differ are told by the largest difference over the strongest cell [dB]. CPU times are those of whole processes,
interleaved; the interval of their median ratio is a bootstrap over the pairs. Exits with 1 where anything differs by more than
--limit-db allows (only fields have a difference in dB; by default all must be equal), or where an interval does not hold 1 or
less below 1.05.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from tests.measurements.tree_side.__main__ import PARTS
from tests.measurements.tree_side.speed import WORKS

LIMIT_RATIO = 1.05
SHOWN = 8  # names of differing files


def run(python: str, module: str, *arguments: str) -> str:
    """What a module of tests.measurements.tree_side prints in the tree of an interpreter.

    It runs where the packages of this tree are not found: the folder has the tests alone.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tests").symlink_to(Path(__file__).parents[1])
        command = [python, "-B", "-m", f"tests.measurements.tree_side{module}", *arguments]
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
        return done.stdout.splitlines()[-1]


def difference_db(old: Path, new: Path) -> float:
    """How far two files differ: -inf where all bytes are equal; fields by their largest difference over the strongest cell
    [dB]; all else by infinity."""
    if old.read_bytes() == new.read_bytes():
        return -np.inf
    if old.suffix != ".npy":
        return np.inf
    a, b = np.load(old), np.load(new)
    if a.shape != b.shape or a.dtype.kind not in "fc":
        return np.inf
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.nan_to_num(20.0 * np.log10(np.nanmax(np.abs(a - b)) / np.nanmax(np.abs(a))), nan=np.inf))


def names(folder: Path) -> set[Path]:
    """The files below a folder, relative to it."""
    return {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}


def compare_part(old: str, new: str, part: str, limit_db: float, real: str) -> bool:
    """Prints how far the trees agree in a part, and where they do not; whether they do."""
    with tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch) / side for side in ("old", "new")]
        for python, folder in zip((old, new), folders, strict=True):
            run(python, "", str(folder), part, real)
        sides = [names(folder) for folder in folders]
        alone = {path: np.inf for path in sides[0] ^ sides[1]}
        both = {path: difference_db(folders[0] / path, folders[1] / path) for path in sides[0] & sides[1]}
    differing = {path: db for path, db in sorted((alone | both).items()) if db > limit_db}
    worst = max((db for db in both.values() if db > -np.inf), default=-np.inf)
    equal = sum(db == -np.inf for db in both.values())
    print(f"{part}: {equal} of {len(alone) + len(both)} files equal, largest difference {worst:.0f} dB", flush=True)
    for path, db in list(differing.items())[:SHOWN]:
        print(f"    {path}: {'of one tree alone' if path in alone else f'{db:.0f} dB'}")
    return not differing


def compare_speed(old: str, new: str, runs: int) -> bool:
    """Prints the median ratio of CPU times, new over old, of each kind of work; whether all are within the limit."""
    rng, good = np.random.default_rng(0), True
    for work in WORKS:
        times = [[float(json.loads(run(python, ".speed", work))) for python in (old, new)] for _ in range(runs)]
        ratio = np.array([b / a for a, b in times])
        medians = np.median(rng.choice(ratio, (10_000, runs)), axis=1)
        low, high = np.quantile(medians, [0.025, 0.975])
        good &= bool(low <= 1.0 and high < LIMIT_RATIO)
        interval = f"95 % interval {low:.3f} to {high:.3f}"
        print(f"{work}: CPU time new/old {np.median(ratio):.3f}, {interval} ({runs} pairs)", flush=True)
    return good


def main() -> int:
    """The command."""
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("old", help="interpreter of the environment with the old tree")
    p.add_argument("new", help="interpreter of the environment with the new tree")
    p.add_argument("--real", type=Path, help="folder of real input (shared/real)")
    p.add_argument("--parts", nargs="*", choices=PARTS, default=PARTS, help="what is compared (none: nothing but speed)")
    p.add_argument("--limit-db", type=float, default=-np.inf, help="by how much fields may differ (default: by nothing)")
    p.add_argument("--runs", type=int, default=9, help="interleaved pairs for the speed (0: none)")
    chosen = p.parse_args()
    old, new = (str(Path(python).absolute()) for python in (chosen.old, chosen.new))
    real = str(chosen.real.absolute()) if chosen.real and chosen.real.is_dir() else ""
    good = [compare_part(old, new, part, chosen.limit_db, real) for part in chosen.parts]
    if chosen.runs:
        good.append(compare_speed(old, new, chosen.runs))
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
