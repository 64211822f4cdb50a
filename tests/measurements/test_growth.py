"""Growth of the cost of a scan with echoes, azimuths and bins, at most linear:
`pytest -m bench -s tests/measurements/test_growth.py`.

The last test draws out/growth.png: cost against size on logarithmic axes, with a line of slope 1 through each last point.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator

import radar_service as rs
from radar_service.records.fidelity import fidelity_from_name
from radar_service.study.plotting import COLOURS, SMALL, duration, new_figure, png_bytes, style
from tests.scenes import point, scene

pytestmark = pytest.mark.bench
OUT = Path(__file__).parents[2] / "out"
MOVING = {"speed_kn": 12, "course_deg": 30}
MAX_SLOPE = 1.15  # between neighbours a factor 4 apart: 1, and 0.15 for the noise of a busy machine


@dataclass(frozen=True)
class Growth:
    """One driven size.

    title: of the axes;
    xlabel, ylabel: with units;
    make: makes a simulator of a size;
    sizes: a factor 4 apart;
    whole: whether the cost is that of a scan, or of 128 azimuths.
    """

    title: str
    xlabel: str
    ylabel: str
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


AZIMUTHS_128 = "CPU time of 128 azimuths"
GROWTHS = (
    Growth("Echoes", "echoes", AZIMUTHS_128, by_echoes, (5_000, 20_000, 80_000, 320_000), False),
    Growth("Azimuths", "azimuths of a scan", "CPU time of a scan", by_azimuths, (360, 1440, 5760), True),
    Growth("Range bins", "range bins", AZIMUTHS_128, by_bins, (1024, 4096, 16_384), False),
)


@cache
def costs_of(growth: Growth) -> tuple[float, ...]:
    """Returns the cost [s] of each size."""
    return tuple(cost(growth.make(size)) * (size / 128 if growth.whole else 1.0) for size in growth.sizes)


@pytest.mark.parametrize("growth", GROWTHS, ids=lambda growth: growth.xlabel)
def test_cost_grows_no_worse_than_linearly(growth: Growth) -> None:
    costs = costs_of(growth)
    slopes = np.diff(np.log(costs)) / np.diff(np.log(growth.sizes))
    for size, seconds in zip(growth.sizes, costs, strict=True):
        print(
            f"\n| {growth.xlabel} | {size} | {duration(seconds)} {'a scan' if growth.whole else 'for 128 azimuths'} |",
            end="",
        )
    print(f"\nslopes {', '.join(f'{slope:.2f}' for slope in slopes)}")
    assert slopes.max() < MAX_SLOPE


def test_draw_the_growth() -> None:
    """Writes out/growth.png."""
    OUT.mkdir(exist_ok=True)
    (OUT / "growth.png").write_bytes(growth_png([(growth, costs_of(growth)) for growth in GROWTHS]))


def growth_png(measured: Sequence[tuple[Growth, Sequence[float]]]) -> bytes:
    """Returns one set of axes for each growth, side by side, as PNG."""
    with style():
        figure = new_figure(3.0)
        for axes, (growth, costs) in zip(figure.subplots(1, len(measured)), measured, strict=True):
            draw_growth(axes, growth, costs)
        figure.subplots_adjust(left=0.085, right=0.99, top=0.9, bottom=0.17, wspace=0.38)
    return png_bytes(figure)


def draw_growth(axes: Axes, growth: Growth, costs: Sequence[float]) -> None:
    """Draws costs [s] against sizes, and linear growth through the last point."""
    linear = [costs[-1] * size / growth.sizes[-1] for size in growth.sizes]
    axes.loglog(growth.sizes, linear, color="#9a9a9a", linestyle="--", label="linear growth")
    axes.loglog(growth.sizes, costs, "o-", color=COLOURS[0], label="measured")
    for size, seconds, before in zip(growth.sizes, costs, (0.0, *costs), strict=False):
        place: dict[str, Any] = {"xytext": (-4, 4), "ha": "right"} if seconds > before else {"xytext": (6, -9), "ha": "left"}
        axes.annotate(duration(seconds), (size, seconds), textcoords="offset points", fontsize=SMALL, **place)
    axes.set_title(growth.title)
    axes.set_xlabel(growth.xlabel)
    axes.set_ylabel(growth.ylabel)
    axes.set_xlim(growth.sizes[0] / 5.0, growth.sizes[-1] * 1.8)
    axes.set_ylim(min(linear[0], costs[0]) / 1.6, costs[-1] * 2.5)
    axes.xaxis.set_major_locator(FixedLocator(growth.sizes))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.tick_params(axis="x", labelsize=SMALL - 0.5)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda size, _: f"{size:,.0f}"))
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda seconds, _: duration(seconds)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.legend(loc="lower right")
