"""10,000 moving steel boxes load, plan and stream, and leave nothing:
`pytest -m bench -n 0 -s tests/measurements/test_many_bodies.py` (five minutes on two busy cores).
Times are CPU times of one thread."""

import gc
import resource
import time
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.trace.embree import TREES
from tests.scenes import scene

pytestmark = pytest.mark.bench
BODIES = 10_000
SPOKES = 400  # more than a scan


def boxes(count: int, shapes: int) -> list[dict[str, Any]]:
    """Boxes of so many shapes all over 6 km."""
    rng = np.random.default_rng(1)
    azimuth, distance = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.uniform(200**2, 5500**2, count))
    return [
        {"name": f"b{k}", "shape": "box", "length_m": 8 + 6 * (k % shapes) / shapes, "width_m": 4, "height_m": 3,
         "position_m": [float(distance[k] * np.sin(azimuth[k])), float(distance[k] * np.cos(azimuth[k])), 0],
         "material": "steel", "speed_kn": 5 + k % 11, "course_deg": k * 37 % 360}
        for k in range(count)
    ]  # fmt: skip


@pytest.mark.parametrize(("count", "shapes"), [(506, 506), (2500, 8), (BODIES, 8), (BODIES, BODIES)])
def test_moving_boxes_load_plan_and_stream(count: int, shapes: int) -> None:
    """All trees end with the simulator. Preparing costs in proportion to the bodies, so no bound on time is stated here."""
    gc.collect()
    before, start = TREES.live, time.process_time()
    made = scene(boxes(count, shapes), radar={"range_max_m": 6000, "azimuths": 360})
    loaded = time.process_time()
    sim = rs.Simulator(made)
    prepared, spokes = time.process_time(), 0
    for block in sim.blocks(scans=2):
        spokes += len(block.time)
        if spokes >= SPOKES:
            break
    streamed = time.process_time()
    truth = sim.truth(1.0)
    told = time.process_time()
    print(
        f"\n{count} boxes of {shapes} shapes: load {loaded - start:.1f} s, prepare {prepared - loaded:.1f} s, "
        f"{1e3 * (streamed - prepared) / spokes:.1f} ms a spoke, truth {told - streamed:.2f} s, {TREES.live} trees, "
        f"at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB"
    )
    assert len(truth.bodies) == count and before < TREES.live <= TREES.maximum
    if shapes == 8:
        assert sim.plan.counts is not None
    del sim, made, block
    gc.collect()
    assert TREES.live == before
