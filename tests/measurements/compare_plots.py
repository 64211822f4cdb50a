"""Compares the plots of two work trees: all packaged scenarios and scenes, to the bit.

    python -m tests.measurements.compare_plots OLD/.venv/bin/python NEW/.venv/bin/python [--scans 60] [--only NAME ...]

Each argument is the interpreter of an environment with one tree installed. A scenario runs with its own settings, a scene with
each threshold, at most `--scans` scans (scenes: 3). Compared are all fields of all plots, the cells of each, and how many were
left out. Prints a line per case; exits with 1 where any differs.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

from radar_service.bench.scenario import scenarios

SCENES = {  # with thresholds; the windows of CFAR are longer than the spokes of the smallest scenes
    "worked-example": ("known",), "orientation": ("known",), "far-target": ("known", "ca", "os"),
    "open-sea": ("known", "ca", "os"), "harbour": ("known", "ca", "os"),
}  # fmt: skip

PROGRAM = """
import dataclasses, hashlib, json, sys, time
import radar_service as rs
from radar_service.plots.extractor import PlotExtractor
from radar_service.bench.run import rule_of, threshold_of
from radar_service.bench.scenario import PlotSettings, load_scenario

case = json.loads(sys.argv[1])
if case["threshold"]:
    scene, settings, fidelity = rs.load_scene(case["name"]), PlotSettings(threshold=case["threshold"], pfa=1e-4), "fast"
    scans, settings = 3, settings.model_copy(update={"max_plots": 10_000})
else:
    scenario = load_scenario(case["name"])
    scene, settings, fidelity = rs.load_scene(scenario.scene_for(0), folder=scenario.folder), scenario.plots, scenario.fidelity
    scans = min(scenario.scans, case["scans"])
simulator = rs.Simulator(scene, fidelity, seed=0)
extractor = PlotExtractor(
    scene.radar, threshold_of(settings, scene), rule=rule_of(settings), max_plots=settings.max_plots,
    nearest=settings.nearest_m,
)
digest, plots, cpu = hashlib.blake2b(digest_size=16), 0, 0.0
for _ in range(scans):
    scan = simulator.scan()
    began = time.process_time()
    ended = extractor.add(scan)
    cpu += time.process_time() - began
    plots += len(ended.plots)
    digest.update(repr((ended.scan, ended.plots, ended.sidelobes, ended.dropped)).encode())
    for cells in ended.cells:
        for column in dataclasses.fields(cells):
            digest.update(getattr(cells, column.name).tobytes())
print(json.dumps({"digest": digest.hexdigest(), "plots": plots, "scans": scans, "cpu": cpu / scans}))
"""


def run(python: str, name: str, threshold: str, scans: int) -> dict[str, object]:
    """What one tree gives for one case, in a process of its own."""
    case = json.dumps({"name": name, "threshold": threshold, "scans": scans})
    done = subprocess.run([python, "-c", PROGRAM, case], capture_output=True, text=True, check=True, cwd="/")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def main() -> int:
    """The command."""
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("old", help="interpreter of the environment with the old tree")
    p.add_argument("new", help="interpreter of the environment with the new tree")
    p.add_argument("--scans", type=int, default=60, help="of each scenario, at most (default 60)")
    p.add_argument("--only", nargs="*", default=[], metavar="NAME", help="these scenarios and scenes alone")
    chosen = p.parse_args()
    every = [(name, "") for name in scenarios()] + [(name, one) for name, some in SCENES.items() for one in some]
    good = True
    for name, threshold in [one for one in every if not chosen.only or one[0] in chosen.only]:
        old, new = (run(str(Path(one).absolute()), name, threshold, chosen.scans) for one in (chosen.old, chosen.new))
        same = old["digest"] == new["digest"]
        good &= same
        print(
            f"{name:24}{threshold:7}{new['scans']:3} scans {new['plots']:6} plots {'equal' if same else 'DIFFERENT'}, "
            f"CPU per scan {old['cpu']:.3f} s before, {new['cpu']:.3f} s now",
            flush=True,
        )  # fmt: skip
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
