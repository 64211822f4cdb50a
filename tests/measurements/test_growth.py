"""Growth of the cost of a scan with echoes, azimuths and bins, at most linear:
`pytest -m bench -s tests/measurements/test_growth.py`.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.records.fidelity import fidelity_from_name
from tests.scenes import point, scene

pytestmark = pytest.mark.bench
MOVING = {"speed_kn": 12, "course_deg": 30}
MAX_SLOPE = 1.15  # between neighbours a factor 4 apart: 1, and 0.15 for the noise of a busy machine


@dataclass(frozen=True)
class Growth:
    """One driven size.

    name: of the size;
    make: makes a simulator of a size;
    sizes: a factor 4 apart;
    whole: whether the cost is that of a scan, or of 128 azimuths.
    """

    name: str
    make: Callable[[int], rs.Simulator]
    sizes: tuple[int, ...]
    whole: bool


def plateau(**radar: Any) -> rs.Scene:
    """Returns a plateau around own ship, which moves."""
    flat = {"name": "flat", "shape": "box", "length_m": 3600, "width_m": 3600, "height_m": 4, "position_m": [0, 0, 0]}
    settings = {"range_max_m": 2500, "azimuths": 720, "height_m": 40, **radar}
    return scene([{**flat, "material": "land"}, point("mark", 900, 0)], radar=settings, own_ship=MOVING)


def by_echoes(size: int) -> rs.Simulator:
    return rs.Simulator(
        plateau(), replace(fidelity_from_name("balanced"), scatterers_per_cell=size / 80_000.0)
    )  # 317,000 visible at 4


def by_azimuths(size: int) -> rs.Simulator:
    return rs.Simulator(plateau(azimuths=size))


def by_bins(size: int) -> rs.Simulator:
    marks = [point(f"p{k}", 400 + 3 * k, 300, swerling=0) for k in range(100)]
    return rs.Simulator(scene(marks, radar={"range_max_m": size * 1.9986}, own_ship=MOVING, environment={"noise": True}))


def cost(sim: rs.Simulator) -> float:
    """Returns the CPU time [s] of 8 blocks of 16 azimuths, the shortest of five runs."""
    best = np.inf
    for _ in range(5):
        blocks = sim.blocks(scans=1)
        next(blocks)
        start = time.process_time()
        for _ in range(8):
            next(blocks)
        best = min(best, time.process_time() - start)
        blocks.close()
    return float(best)


GROWTHS = (
    Growth("echoes", by_echoes, (5_000, 20_000, 80_000, 320_000), False),
    Growth("azimuths of a scan", by_azimuths, (360, 1440, 5760), True),
    Growth("range bins", by_bins, (1024, 4096, 16_384), False),
)


@pytest.mark.parametrize("growth", GROWTHS, ids=lambda growth: growth.name)
def test_cost_grows_no_worse_than_linearly(growth: Growth) -> None:
    costs = [cost(growth.make(size)) * (size / 128 if growth.whole else 1.0) for size in growth.sizes]
    slopes = np.diff(np.log(costs)) / np.diff(np.log(growth.sizes))
    for size, seconds in zip(growth.sizes, costs, strict=True):
        print(f"\n| {growth.name} | {size} | {seconds:.2g} s {'a scan' if growth.whole else 'for 128 azimuths'} |", end="")
    print(f"\nslopes {', '.join(f'{slope:.2f}' for slope in slopes)}")
    assert slopes.max() < MAX_SLOPE
