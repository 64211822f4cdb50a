"""Whether scenes run as fast as their plan says, and how `auto` stands beside `balanced`:
`pytest -m bench -s tests/measurements`.

CPU time of one thread, the least of some whole scans after a first one; a busy machine slows plan and scan alike, not evenly.
"""

import time
from collections.abc import Callable
from pathlib import Path

import pytest

import radar_service as rs
from radar_service.records.fidelity import PRESETS
from tests.measurements import places as scenes
from tests.real import places

pytestmark = pytest.mark.bench
FACTOR = 1.5  # required
MAKERS: dict[str, Callable[[Path], rs.Scene]] = {
    "harbour": lambda folder: scenes.shipped("harbour"),
    "open-sea": lambda folder: scenes.shipped("open-sea"),
    "far-target": lambda folder: scenes.shipped("far-target"),
    "orientation": lambda folder: scenes.shipped("orientation"),
    "99,000 building triangles, 12 kn": scenes.buildings,
    "2,000,000 terrain triangles, 12 kn": scenes.coast,
    "20 mesh ships, 4096 x 4096, 48 rpm": lambda folder: scenes.many_ships(),
}


def scan_seconds(sim: rs.Simulator, limit: float = 10.0) -> float:
    """CPU time [s] of a scan."""
    scans: list[float] = []
    begun = time.thread_time()
    while len(scans) < 3 or (time.thread_time() - begun < limit and len(scans) < 6):
        start = time.thread_time()
        for _ in sim.blocks(scans=1):
            pass
        scans.append(time.thread_time() - start)
    return min(scans[1:])


@pytest.mark.parametrize("name", MAKERS)
def test_scenes_run_as_fast_as_predicted(name: str, tmp_path: Path) -> None:
    """Within a factor of 1.5 (required); `auto` takes no longer than `balanced`, to a tenth, but for points that the budget
    asks for and `balanced` has not."""
    if "triangles" in name and not (places.REAL / "README.md").is_file():
        pytest.skip(f"the real input is not at {places.REAL}")
    scene = MAKERS[name](tmp_path)
    begun = time.thread_time()
    sim = rs.Simulator(scene)
    set_up = time.thread_time() - begun
    costs = sim.plan.costs
    planned = time.thread_time() - begun - set_up
    assert costs is not None
    each = 1e6 / scene.radar.azimuths
    measured, balanced = scan_seconds(sim) * each, scan_seconds(rs.Simulator(scene, "balanced")) * each
    print(
        f"\n| {name} | predicted {costs.total:.0f} us | measured {measured:.0f} | `balanced` {balanced:.0f} | "
        f"set-up {set_up:.2f} s, plan {planned:.2f} s |"
    )
    assert measured / FACTOR < costs.total < measured * FACTOR
    assert measured < 1.1 * balanced or sim.fidelity.min_scatterers > PRESETS["balanced"].min_scatterers
