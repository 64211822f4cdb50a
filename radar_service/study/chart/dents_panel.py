"""The sixth panel: a rolling ship whose walls are dented, with her dents and without."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.records.fidelity import PRESETS
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.ships_panel import RollingShip, power_errors
from radar_service.world.body import Plating
from radar_service.world.scene import Scene

BALANCED = PRESETS["balanced"]
DENTS = (0.002, 0.004, 0.008)  # m: IACS Rec. 47 has 4 mm as the standard and 8 mm as the limit
FRAME, TIER = 0.7, 2.5  # m, as plating has them by default
KEPT, FLAT = "dents kept", "dents left out"
METHODS = 2 * len(DENTS)


def dents_points(ship: Scene, aspects: int, scans: int, done: Callable[[], object]) -> list[Point]:
    """Two points for each depth of dents, from so many aspects of each passage of the beam over a ship (`rolling_ships`), against
    each aspect traced with dents; none where she has no echo.

    An azimuth bears its share of the time of all aspects of a scan. `done` is called after each scan of a method."""
    points = []
    for depth in DENTS:
        dented = _plated(ship, Plating(depth, FRAME, TIER, 0))
        exact = RollingShip.of(dented, replace(BALANCED, trace_step_deg=0.0))
        passages = [_some(exact.nodes(scan), aspects) for scan in range(scans + 1)]
        truth = [[exact.powers(*passage)] for passage in passages[1:]]
        if not any(powers.any() for (powers,) in truth):
            return []
        methods = [RollingShip.of(each, BALANCED) for each in (dented, _plated(ship, None))]
        results: list[list[list[Floats]]] = [[], []]

        def run(method: RollingShip, result: list[list[Floats]], at: list[tuple[int, list[int]]]) -> None:
            result.append([method.powers(*at[len(result) + 1])])

        for method in methods:
            method.powers(*passages[0])  # facets are cut once for a distance; that is not timed
        tasks = [partial(run, *each, passages) for each in zip(methods, results, strict=True)]
        times = time_interleaved(tasks, [scans] * 2, done)
        share = np.mean([len(exact.nodes(scan)[1]) / len(nodes) for scan, (_, nodes) in enumerate(passages)])
        for family, taken, powers in zip((KEPT, FLAT), times, results, strict=True):
            per_azimuth = tuple(float(t * share) / ship.radar.azimuths for t in taken)
            points.append(Point("dents", family, f"{1e3 * depth:g} mm", per_azimuth, False, *power_errors(powers, truth)))
    return points


def _some(passage: tuple[int, list[int]], count: int) -> tuple[int, list[int]]:
    """The crossing of a passage, and so many of its nodes at most, evenly."""
    crossing, nodes = passage
    return crossing, [nodes[k] for k in np.unique(np.linspace(0, len(nodes) - 1, count).astype(np.int64)).tolist()]


def _plated(ship: Scene, plating: Plating | None) -> Scene:
    (body,) = ship.bodies
    return ship.with_world(bodies=(replace(body, plating=plating),))
