"""Compares two work trees on this machine through the public interface: the same fields, the same plan counts, the same speed.

    python -m tests.bench.compare_trees OLD/.venv/bin/python NEW/.venv/bin/python [--real ../shared/real] [--runs 9]

Each argument is the interpreter of an environment with one tree installed. Fields are compared scan by scan: the largest
difference over the strongest cell, in dB ("equal" where all bytes are). CPU times are those of whole processes, interleaved; the
interval of their median ratio is a bootstrap over the pairs. Exits with 1 where a field differs by more than -120 dB, a
count differs, or the interval does not hold 1 or less below 1.10.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

SHIPPED = ("worked-example", "orientation", "far-target", "open-sea", "harbour")
AT_REST = ("worked-example", "orientation", "far-target")
LIMIT_DB, LIMIT_RATIO = -120.0, 1.10

PROGRAM = """
import json, resource, sys
import numpy as np
import radar_service as rs

case = json.loads(sys.argv[1])
scene = rs.load_scene(case["scene"])
sim = rs.Simulator(scene, fidelity=case["fidelity"], seed=case["seed"])
for number in range(case["scans"]):
    scan = sim.scan()
    if case["out"]:
        np.save(f"{case['out']}-{number}.npy", scan.field)
cpu = resource.getrusage(resource.RUSAGE_SELF)
print(json.dumps({"counts": sim.plan.as_dict()["counts"] if case["out"] else None, "cpu": cpu.ru_utime + cpu.ru_stime}))
"""


def real_scenes(folder: Path) -> Iterator[tuple[str, object]]:
    """Two scenes of real input: buildings of the Swinomish Channel, and Catalina's coast passed by a steel ship in a seaway."""
    tile = folder / "swinomish" / "osm_2_2.obj"
    radar = {"range_max_m": 3000, "beamwidth_deg": 1.9, "height_m": 15}
    buildings = {"name": "houses", "mesh": tile.name, "up": "y", "position_m": [300, 200, 0]}
    yield "swinomish", (tile.parent, {"name": "swinomish", "radar": radar, "body": [buildings]})
    island = {
        "name": "island", "heightmap": "catalina.png", "low_m": -2063, "high_m": 633, "material": "land",
        "extent_m": [40000, 40000], "position_m": [-6000, 4000, 0],
    }  # fmt: skip
    ship = {
        "name": "ship", "shape": "hull", "length_m": 90, "beam_m": 16, "height_m": 14, "material": "steel",
        "position_m": [800, 900, 0], "course_deg": 200, "heading_deg": 200, "speed_kn": 14,
    }  # fmt: skip
    own = {"speed_kn": 10, "course_deg": 30, "heading_deg": 30}
    weather = {"noise": True, "multipath": True, "sea_state": 3, "rain_mm_h": 4}
    scene = {
        "name": "catalina",
        "radar": {"range_max_m": 6000},
        "own_ship": own,
        "environment": weather,
        "body": [island, ship],
    }
    yield "catalina", (folder, scene)


def cases(real: Path | None) -> Iterator[tuple[str, object, str, int]]:
    """Name, scene, fidelity and scans of each comparison."""
    scenes: list[tuple[str, object]] = [(name, name) for name in SHIPPED]
    if real is not None and real.is_dir():
        scenes += list(real_scenes(real))
    for name, scene in scenes:
        for fidelity in ("documented", "fast", "balanced", "auto"):
            yield name, scene, fidelity, 3
        if name in AT_REST:
            yield name, scene, "reference", 1


def run(python: str, scene: object, fidelity: str, scans: int, out: str) -> dict[str, object]:
    """One simulation in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(scene, tuple):
            source, content = scene
            path = Path(folder) / "scene.json"
            path.write_text(json.dumps(content))
            for name in {body.get("mesh") or body.get("heightmap") for body in content["body"]} - {None}:
                (Path(folder) / name).write_bytes((source / name).read_bytes())
            scene = str(path)
        case = json.dumps({"scene": scene, "fidelity": fidelity, "seed": 1, "scans": scans, "out": out})
        done = subprocess.run([python, "-c", PROGRAM, case], capture_output=True, text=True, check=True, cwd=folder)
        return dict(json.loads(done.stdout.splitlines()[-1]))


def difference_db(old: Path, new: Path) -> float:
    """The largest difference of two fields over the strongest cell [dB], -inf where all bytes are equal."""
    a, b = np.load(old), np.load(new)
    if a.tobytes() == b.tobytes():
        return -np.inf
    return float(20.0 * np.log10(np.abs(a - b).max() / np.abs(a).max()))


def compare_fields(old: str, new: str, real: Path | None) -> bool:
    """Prints a line per case; whether all agree."""
    good = True
    for name, scene, fidelity, scans in cases(real):
        with tempfile.TemporaryDirectory() as folder:
            counts = [
                run(python, scene, fidelity, scans, f"{folder}/{side}")["counts"] for side, python in enumerate((old, new))
            ]
            worst = max(difference_db(Path(f"{folder}/0-{n}.npy"), Path(f"{folder}/1-{n}.npy")) for n in range(scans))
        same = counts[0] == counts[1]
        good &= worst <= LIMIT_DB and same
        fields = "equal" if worst == -np.inf else f"{worst:.0f} dB"
        print(f"{name:15} {fidelity:11} {scans} scan(s): fields {fields}, counts {'equal' if same else counts}", flush=True)
    return good


def compare_speed(old: str, new: str, runs: int) -> bool:
    """Prints the median ratio of CPU times, new over old, per scene; whether all are within the limit."""
    rng, good = np.random.default_rng(0), True
    for scene in ("harbour", "open-sea"):
        times = []
        for _ in range(runs):
            times.append([float(str(run(python, scene, "balanced", 20, "")["cpu"])) for python in (old, new)])
        ratio = np.array([b / a for a, b in times])
        medians = np.median(rng.choice(ratio, (10_000, runs)), axis=1)
        low, high = np.quantile(medians, [0.025, 0.975])
        good &= bool(low <= 1.0 and high < LIMIT_RATIO)
        interval = f"95 % interval {low:.3f} to {high:.3f}"
        print(f"{scene}: CPU time new/old {np.median(ratio):.3f}, {interval} ({runs} pairs)", flush=True)
    return good


def main() -> int:
    """The command."""
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("old", help="interpreter of the environment with the old tree")
    p.add_argument("new", help="interpreter of the environment with the new tree")
    p.add_argument("--real", type=Path, help="folder of real input (shared/real)")
    p.add_argument("--runs", type=int, default=9, help="interleaved pairs for the speed (0: none)")
    chosen = p.parse_args()
    old, new = (str(Path(python).absolute()) for python in (chosen.old, chosen.new))
    good = compare_fields(old, new, chosen.real)
    if chosen.runs:
        good &= compare_speed(old, new, chosen.runs)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
