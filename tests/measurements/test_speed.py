"""How fast scenes run, against real time and against the floor (see `floor`).

`python -m tests.measurements.test_speed [ROW ...]` prints the table of all rows but metal, or of rows by name (eight minutes);
`pytest -m bench -s tests/measurements/test_speed.py` has the same rows, and metal.
CPU time of one thread, the least of some scans after a first one that is not counted; floor and engine by turns in one run, so
that a busy machine slows both. The first block counts from reading the scene on.
"""

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import radar_service as rs
from radar_service.numerics.parallel import BLAS_LIMIT
from tests.measurements import places as scenes
from tests.measurements.floor import floor_seconds, scan_work
from tests.real import places
from tests.service_starts import seconds_to_first_spoke

pytestmark = pytest.mark.bench
HEADER = (
    "| scene | CPU s a scan | azimuths/s | x real time | x floor | CPU s, MB at the first block | peak MB |\n"
    + 7 * "|---"
    + "|"
)
MAKERS: dict[str, Callable[[Path], rs.Scene]] = {
    "harbour": lambda folder: scenes.shipped("harbour"),
    "open-sea": lambda folder: scenes.shipped("open-sea"),
    "99,000 building triangles, 12 kn": scenes.buildings,
    "2,000,000 terrain triangles, 12 kn": scenes.coast,
    "low coast, 0.5 million triangles, 8 kn": scenes.low_coast,
    "low coast, 0.5 million triangles, 25 kn": lambda folder: scenes.low_coast(folder, 25.0),
    "low coast, 2 million triangles, 8 kn": lambda folder: scenes.low_coast(folder, 8.0, 1260),
    "low coast, 2 million triangles, 25 kn": lambda folder: scenes.low_coast(folder, 25.0, 1260),
    "low coast, 5.4 million triangles, 8 kn": lambda folder: scenes.low_coast(folder, 8.0, 2060),
    "coast of 1 to 5 m, buildings, buoys, 8 kn": lambda folder: scenes.low_coast(folder, built=True),
    "coast of 1 to 55 m, buildings, buoys, 8 kn": lambda folder: scenes.low_coast(folder, top=55.0, built=True),
    "Swinomish on a low coast, 5 ships, 8 kn": scenes.low_channel,
    "10,000 declared hulls": lambda folder: scenes.declared_hulls(10_000),
    "20 mesh ships, 4096 x 4096, 48 rpm": lambda folder: scenes.many_ships(),
}
METAL: dict[str, Callable[[Path], rs.Scene]] = {
    "harbour, ships rolling 5 degrees": lambda folder: scenes.rolling_harbour(),
    "20 steel coasters, calm": lambda folder: scenes.coasters(at_sea=False),
    "20 steel coasters, sea state 3": lambda folder: scenes.coasters(at_sea=True),
    "strait, 60 declared ships": lambda folder: scenes.strait(folder, "declared"),
    "strait, 60 ships by optics": lambda folder: scenes.strait(folder, "optics"),
    "strait, 60 ships by optics in a seaway": lambda folder: scenes.strait(folder, "seaway"),
    "100 steel boxes": lambda folder: scenes.steel_boxes(100),
    "1000 steel boxes": lambda folder: scenes.steel_boxes(1000),
    "3000 steel boxes": lambda folder: scenes.steel_boxes(3000),
}
FIRST_SPOKE, STARTS = "first spoke of the harbour", 3


def timed(sim: rs.Simulator, limit: float = 12.0) -> tuple[float, float]:
    """CPU time [s] of one scan and of its floor."""
    for _ in sim.blocks(scans=1):
        pass
    work = scan_work(sim)
    scans, floors, begun = [], [], time.process_time()
    while len(scans) < 2 or (time.process_time() - begun < limit and len(scans) < 7):
        start = time.process_time()
        for _ in sim.blocks(scans=1):
            pass
        scans.append(time.process_time() - start)
        floors.append(floor_seconds(work))
    return min(scans), min(floors)


def row(name: str, folder: Path) -> str:
    """One line of the table."""
    start = time.process_time()
    made = (MAKERS | METAL)[name](folder)
    sim = rs.Simulator(made, seed=1)
    first = sim.blocks(scans=1)
    next(first)
    first.close()
    begun, memory = time.process_time() - start, _peak()
    scan, floor = timed(sim)
    radar = made.radar
    speed = f"{scan:.3g} | {radar.azimuths / scan:.0f} | {radar.rotation_period / scan:.2f} | {scan / floor:.2f}"
    return f"| {name} | {speed} | {begun:.2f}, {memory:.0f} | {_peak():.0f} |"


def _peak() -> float:
    """Peak memory of this process until now [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def in_own_process(name: str) -> str:
    """One line of the table, from a process of its own, so that the peak is the scene's; empty where its files are absent."""
    if ("triangles, 12 kn" in name or "Swinomish" in name) and not (places.REAL / "README.md").is_file():
        return ""
    code = "import sys; from tests.measurements import test_speed; test_speed.print_row(*sys.argv[1:])"
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-c", code, name, folder]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, cwd=Path(__file__).parents[2])
    return done.stdout.strip()


def print_row(name: str, folder: str) -> None:
    """Prints one line of the table."""
    with BLAS_LIMIT.held():  # for the floor too
        print(row(name, Path(folder)))


def print_table(names: Sequence[str]) -> None:
    """Prints the rows of these names, all by default, as each is there."""
    print(HEADER)
    for name in names or [*MAKERS, FIRST_SPOKE]:
        if name != FIRST_SPOKE:
            print(in_own_process(name) or f"| {name}: the real input is not at {places.REAL} |", flush=True)
        else:
            took = sorted(seconds_to_first_spoke("harbour") for _ in range(STARTS))
            print(f"{name}, from the command on: {took[STARTS // 2]:.2f} s ({took[0]:.2f} to {took[-1]:.2f} s on the clock)")


@pytest.mark.parametrize("name", [*MAKERS, *METAL])
def test_speed(name: str) -> None:
    """Faster than real time but for metal (required)."""
    line = in_own_process(name)
    if not line:
        pytest.skip(f"the real input is not at {places.REAL}")
    print(f"\n{HEADER}\n{line}")
    assert float(line.split("|")[4]) > 1.0 or name in METAL


if __name__ == "__main__":
    if unknown := sorted({*sys.argv[1:]} - {*MAKERS, *METAL, FIRST_SPOKE}):
        sys.exit(f"{', '.join(unknown)}: no row has this name; give some of: {'; '.join([*MAKERS, *METAL, FIRST_SPOKE])}")
    print_table(sys.argv[1:])
