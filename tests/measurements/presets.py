"""What each preset costs and how far off it is: `python -m tests.measurements.presets`, some minutes; `--real` adds
real buildings.

Errors are relative field errors of points against the closed form and mean powers of surfaces against their cross-sections;
times are CPU times of one thread (the engine's own; BLAS keeps to one).
"""

import argparse
import itertools
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import radar_service as rs
from radar_service.records.fidelity import PRESETS, Fidelity
from radar_service.scene_file.document import scene_content
from tests.engine.test_pipeline import COARSE, error_db, scattered
from tests.real import places
from tests.scenes import SHIPPED, scene

WAY = {"speed_kn": 12, "course_deg": 30}
NAMES = ("fast", "balanced", "reference")
RAYS = [replace(PRESETS["balanced"], name=f"balanced by {kind}", sampler=kind) for kind in ("rays", "stratified", "sobol")]
SEEDS = 300
SLOW = 8  # azimuths of a scene under way that the slow preset is timed over, spread over a few degrees


def point_errors(fidelity: Fidelity) -> list[float]:
    """Relative field error [dB] at rest, with own ship under way, with the bodies under way."""
    errors = []
    for own, others in (({}, {}), (WAY, {}), ({}, WAY)):
        made = scene(scattered(6, 2800, 2, **others), radar={"range_max_m": 3000}, own_ship=own)
        sim = rs.Simulator(made, fidelity)
        sim.scan()
        errors.append(error_db(made, sim.scan()))
    return errors


def surface_error(fidelity: Fidelity) -> tuple[float, float]:
    """Mean power of a plate of 60 x 30 m square on at 1 km over gamma A, and its standard error [dB]."""
    plate = {"name": "p", "shape": "plate", "width_m": 60, "height_m": 30, "position_m": [0, 1000, 15], "heading_deg": 180,
             "material": "concrete"}  # fmt: skip
    made = scene([plate], radar={**COARSE, "rays": 20_000})
    one = scene([{"name": "t", "shape": "point", "position_m": [0, 1000, 15], "rcs_dbsm": 0}], radar=COARSE)
    unit = rs.Simulator(one, fidelity).scan().power[0].sum() * made.bodies[0].material.gamma * 1800
    sections = np.array([rs.Simulator(made, fidelity, seed).scan().power[0].sum() / unit for seed in range(SEEDS)])
    return 10 * np.log10(sections.mean()), 4.34 * sections.std() / sections.mean() / np.sqrt(SEEDS)


def timed(make: Callable[[], rs.Simulator], azimuths: int | None) -> tuple[float, float]:
    """CPU seconds to set up, and CPU milliseconds per azimuth over the second scan, or over the first few azimuths."""
    start = time.process_time()
    sim = make()
    setup = time.process_time() - start
    if azimuths is None:
        sim.scan()
    start = time.process_time()
    count = sum(1 for _ in itertools.islice(sim.spokes(scans=1), azimuths))
    return setup, 1e3 * (time.process_time() - start) / count


def harbour(**own_ship: Any) -> rs.Scene:
    """The shipped harbour, own ship as given."""
    table = scene_content(SHIPPED / "harbour.toml")
    return rs.load_scene({**table, "own_ship": table["own_ship"] | own_ship}, folder=SHIPPED)


def timings(made: rs.Scene, under_way: rs.Scene, fidelity: Fidelity) -> tuple[float, float, float]:
    """Set-up [CPU s], at anchor and under way [CPU ms per azimuth]."""
    setup, at_rest = timed(lambda: rs.Simulator(made, fidelity), None)
    slow = SLOW if fidelity.azimuths_per_block == 1 else 360
    return setup, at_rest, timed(lambda: rs.Simulator(under_way, fidelity), slow)[1]


def energies(made: rs.Scene, fidelity: Fidelity, seeds: range) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Sum of power x R^4 over a scan, seed by seed: every building counts by its cross-section."""
    result = []
    for seed in seeds:
        scan = rs.Simulator(made, fidelity, seed).scan()
        result.append(float(np.sum(scan.power * scan.range**4)))
    return np.array(result)


def table(fidelities: list[Fidelity]) -> None:
    """Errors and times of each, a line each."""
    anchored, under_way = harbour(), harbour(speed_kn=10, course_deg=200)
    print("errors: points at rest, own ship 12 kn, bodies 12 kn [dB]; surface [dB +- standard error]")
    print("times: set-up of the harbour [CPU s], at anchor, under way [CPU ms per azimuth; 720 x 24 rpm has 3.47]")
    for fidelity in fidelities:
        rest, own, bodies = point_errors(fidelity)
        level, error = surface_error(fidelity)
        setup, at_rest, moving = timings(anchored, under_way, fidelity)
        print(
            f"{fidelity.name:24s} {rest:6.1f} {own:6.1f} {bodies:6.1f} | {level:5.2f} +- {error:.2f} | "
            f"{setup:6.2f} {at_rest:7.3f} {moving:8.3f}",
            flush=True,
        )


def real_table(fidelities: list[Fidelity], seeds: range) -> None:
    """Times and mean powers among the buildings of the Swinomish Channel."""
    with tempfile.TemporaryDirectory() as folder:
        quiet: dict[str, Any] = {"environment": {"noise": False}, "radar": {"beamwidth_deg": 1.9, "azimuths": 720}}

        def loaded(**more: Any) -> rs.Scene:
            return rs.load_scene(places.swinomish(Path(folder), **quiet, **more), folder=folder)

        anchored, under_way = loaded(), loaded(own_ship={"speed_kn": 12, "course_deg": 180})
        triangles = sum(len(body.mesh.faces) for body in anchored.bodies if body.mesh is not None)
        print(
            f"Swinomish, {triangles} triangles, 6 km, 720 azimuths; power x R^4 over that of reference, {len(seeds)} seeds"
        )
        print("mean [dB +- standard error]; set-up [CPU s], at anchor, under way [CPU ms per azimuth]")
        exact = energies(anchored, PRESETS["reference"], seeds)
        for fidelity in fidelities:
            mine = exact if fidelity.name == "reference" else energies(anchored, fidelity, seeds)
            level = 10 * np.log10(mine.mean() / exact.mean())
            error = 4.34 * np.hypot(*(e.std() / e.mean() for e in (mine, exact))) / np.sqrt(len(seeds))
            setup, at_rest, moving = timings(anchored, under_way, fidelity)
            print(f"{fidelity.name:24s} {level:6.3f} +- {error:.3f} | {setup:6.2f} {at_rest:7.3f} {moving:8.3f}", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--real", action="store_true", help="the Swinomish table alone")
    parser.add_argument("--rays", action="store_true", help="the ray samplers too")
    requested = parser.parse_args()
    fidelities = [PRESETS[name] for name in NAMES] + (RAYS if requested.rays else [])
    if requested.real:
        real_table(fidelities, range(3))
    else:
        table(fidelities)


if __name__ == "__main__":
    main()
