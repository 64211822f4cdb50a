"""What labels and radiometric truth cost: `python -m tests.measurements.label_cost [SCANS]`, on a quiet machine.

Scans of both kinds alternate, and the least disturbed of each counts. Times are those of one core.
"""

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import radar_service as rs
from tests.scenes import point, scene

HULL = {"shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "position_m": [0, 0, 0]}


def twenty(body: dict[str, Any], **under_way: Any) -> list[dict[str, Any]]:
    """Twenty bodies 500 to 4500 m away, under way."""
    rng = np.random.default_rng(5)
    places = zip(rng.uniform(500, 4500, 20), rng.uniform(0, 2 * np.pi, 20), strict=True)
    course = [float(rng.uniform(0, 360)) for _ in range(20)]
    motion = [{"speed_kn": 10, "course_deg": each} | under_way for each in course]
    positions = [[float(r * np.sin(a)), float(r * np.cos(a)), body["position_m"][2]] for r, a in places]
    return [body | motion[k] | {"name": f"body {k}", "position_m": each} for k, each in enumerate(positions)]


POINTS = twenty(point("p", 0, 0, rcs_dbsm=40))
NEAR = [body | {"position_m": [1500.0 + 9 * k, 1400.0 + 70 * (k % 3), 10]} for k, body in enumerate(POINTS)]
SCENES: dict[str, tuple[Callable[..., rs.Scene], dict[str, Any]]] = {
    "20 wooden hulls in a rough sea": (
        scene,
        {"bodies": twenty(HULL | {"material": "wood"}), "environment": {"sea_state": 3}},
    ),
    "20 steel hulls": (scene, {"bodies": twenty(HULL | {"material": "steel"})}),
    "20 points of 40 dBsm": (scene, {"bodies": POINTS}),
    "20 points of 60 dBsm": (scene, {"bodies": twenty(point("p", 0, 0, rcs_dbsm=60))}),
    "20 points, own ship under way": (scene, {"bodies": POINTS, "own_ship": {"speed_kn": 12, "course_deg": 30}}),
    "20 points, eclipsing": (scene, {"bodies": POINTS, "radar": {"eclipsing": True}}),
    "20 points in 200 m": (scene, {"bodies": NEAR}),
    "20 points at rest": (scene, {"bodies": twenty(point("p", 0, 0, rcs_dbsm=40), speed_kn=0)}),
}


def spent(simulators: list[rs.Simulator], scans: int) -> list[float]:
    """Seconds of CPU of the fastest scan of each simulator; their first one fills caches."""
    seconds = []
    for _ in range(scans + 1):
        seconds.append([_seconds(simulator.scan) for simulator in simulators])
    return np.array(seconds[1:]).min(axis=0).tolist()


def radiometric(simulator: rs.Simulator, scans: int) -> float:
    """Seconds of CPU of the radiometric truth of one of the last scans."""
    seconds = []
    for _ in range(scans + 1):
        simulator.scan()
        seconds.append(_seconds(lambda: simulator.crossings(radiometric=True)))
    return min(seconds[1:])


def rows(scans: int) -> Iterator[str]:
    """The lines of the table."""
    yield "| scene | plain scan, noise | with labels | plain scan, no noise | with labels | radiometric truth, noise |"
    yield "|---|---|---|---|---|---|"
    for name, (make, sections) in SCENES.items():
        cells = [name]
        for noise in (True, False):
            made = make(**sections | {"environment": sections.get("environment", {}) | {"noise": noise}})
            plain, labelled = spent([rs.Simulator(made, "balanced", labels=labels) for labels in (False, True)], scans)
            cells += [f"{1e3 * plain:.0f} ms", f"{labelled / plain:.2f}"]
            if noise:
                cost = f"{radiometric(rs.Simulator(made, 'balanced'), scans) / plain:.2f}"
        yield f"| {' | '.join([*cells, cost])} |"
    harbour = rs.load_scene("harbour")
    plain, labelled = spent([rs.Simulator(harbour, labels=labels) for labels in (False, True)], scans)
    cost = f"{radiometric(rs.Simulator(harbour), scans) / plain:.2f}"
    yield f"| harbour | {1e3 * plain:.0f} ms | {labelled / plain:.2f} | | | {cost} |"


def _seconds(call: Callable[[], object]) -> float:
    before = time.process_time()
    call()
    return time.process_time() - before


if __name__ == "__main__":
    for line in rows(int(sys.argv[1]) if len(sys.argv) > 1 else 9):
        print(line, flush=True)
