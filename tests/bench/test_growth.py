"""How the cost of a scan grows with echoes, azimuths and bins: no worse than linearly. `pytest -m bench -s tests/bench`.

Each chart, out/growth-*.png, has cost against size on logarithmic axes and the line of slope 1 through its last point.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

import radar_service as rs
from radar_service.fidelity import fidelity_from_name
from tests.scenes import point, scene

pytestmark = pytest.mark.bench
OUT = Path(__file__).parents[2] / "out"
UNDER_WAY = {"speed_kn": 12, "course_deg": 30}
SLOPE = 1.15  # of the steepest stretch between neighbours a factor 4 apart; 1 and what a busy machine adds


def plain(**radar: Any) -> rs.Scene:
    """A plateau all round, own ship under way."""
    flat = {"name": "flat", "shape": "box", "length_m": 3600, "width_m": 3600, "height_m": 4, "position_m": [0, 0, 0]}
    settings = {"range_max_m": 2500, "azimuths": 720, "height_m": 40, **radar}
    return scene([{**flat, "material": "land"}, point("mark", 900, 0)], radar=settings, own_ship=UNDER_WAY)


def by_echoes(size: int) -> rs.Simulator:
    return rs.Simulator(
        plain(), replace(fidelity_from_name("balanced"), scatterers_per_cell=size / 80_000.0)
    )  # 317,000 seen at 4


def by_azimuths(size: int) -> rs.Simulator:
    return rs.Simulator(plain(azimuths=size))


def by_bins(size: int) -> rs.Simulator:
    marks = [point(f"p{k}", 400 + 3 * k, 300, swerling=0) for k in range(100)]
    return rs.Simulator(scene(marks, radar={"range_max_m": size * 1.9986}, own_ship=UNDER_WAY, environment={"noise": True}))


def cost(sim: rs.Simulator) -> float:
    """CPU time [s] of 8 tiles of 16 azimuths, the least of five goes."""
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


@pytest.mark.parametrize(
    ("what", "make", "sizes", "whole"),
    [
        ("echoes", by_echoes, [5_000, 20_000, 80_000, 320_000], False),
        ("azimuths", by_azimuths, [360, 1440, 5760], True),
        ("bins", by_bins, [1024, 4096, 16_384], False),
    ],
    ids=["echoes", "azimuths", "bins"],
)
def test_cost_grows_no_worse_than_linearly(
    what: str, make: Callable[[int], rs.Simulator], sizes: list[int], whole: bool
) -> None:
    costs = [cost(make(size)) * (size / 128 if whole else 1.0) for size in sizes]
    slopes = np.diff(np.log(costs)) / np.diff(np.log(sizes))
    for size, seconds in zip(sizes, costs, strict=True):
        print(f"\n| {what} | {size} | {seconds * 1e3:.1f} ms {'a scan' if whole else 'for 128 azimuths'} |", end="")
    print(f"\nslopes {', '.join(f'{slope:.2f}' for slope in slopes)}")
    chart(what, sizes, costs)
    assert slopes.max() < SLOPE


def chart(what: str, sizes: list[int], costs: list[float]) -> None:
    """Writes out/growth-`what`.png."""
    OUT.mkdir(exist_ok=True)
    image = Image.new("RGB", (520, 400), "white")
    pen = ImageDraw.Draw(image)
    x, y = np.log10(sizes), np.log10(costs)
    low_x, low_y, span = x[0], min(y.min(), y[-1] - (x[-1] - x[0])), max(x[-1] - x[0], np.ptp(y)) * 1.1

    def at(a: float, b: float) -> tuple[float, float]:
        return 70 + (a - low_x) / span * 420, 350 - (b - low_y) / span * 300

    pen.line([at(x[0], y[-1] - (x[-1] - x[0])), at(x[-1], y[-1])], fill="silver", width=2)
    pen.line([at(a, b) for a, b in zip(x, y, strict=True)], fill="navy", width=3)
    for a, b, size, seconds in zip(x, y, sizes, costs, strict=True):
        left, top = at(a, b)
        pen.ellipse([left - 4, top - 4, left + 4, top + 4], fill="navy")
        pen.text((left - 10, top - 22), f"{seconds * 1e3:.0f} ms", fill="black")
        pen.text((left - 10, 360), f"{size}", fill="black")
    pen.text((200, 378), f"{what}; grey: linear", fill="black")
    image.save(OUT / f"growth-{what}.png")
