"""One run as plain data: extended targets stand where their power lies."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.single_run import CROSSINGS, at_power_centroids
from tests.bench.scores.test_scoring import given, truth

HEADING = np.radians(90.0)  # bow to the east, starboard to the south


def run(offsets: list[tuple[float, float] | None], heading: float = HEADING) -> list[ScanResult]:
    """A ship at rest at (0, 1000) whose power lies at these offsets from her reference point."""
    at_rest = replace(truth("ship", 0.0, 0.0, 1000.0, speed=0.0), heading=heading, length=100.0)
    return [ScanResult(given(k), (), (replace(at_rest, centroid=offset),)) for k, offset in enumerate(offsets)]


def positions(results: list[ScanResult]) -> list[tuple[float, float]]:
    return [result.truths[0].position for result in at_power_centroids(results)]


def test_a_target_stands_where_her_power_lies_in_the_mean() -> None:
    """Glint of 12 m to and fro about 4 m ahead and 3 m to starboard: the mean over 11 crossings, the ends over fewer."""
    glint = [(4.0 + 12.0 * (-1) ** k, 3.0) for k in range(31)]
    moved = positions(run(glint))
    expected = 4.0 + 12.0 * (-1) ** (15 - CROSSINGS) / (2 * CROSSINGS + 1)
    assert moved[15] == pytest.approx((expected, 1000.0 - 3.0))
    assert moved[0] == pytest.approx((4.0, 997.0))  # six crossings: as many ahead as astern


@pytest.mark.parametrize(("degrees", "east", "north"), [(0, 2.0, 5.0), (90, 5.0, -2.0), (180, -2.0, -5.0), (270, -5.0, 2.0)])
def test_offsets_turn_with_the_ship(degrees: float, east: float, north: float) -> None:
    """5 m to the bow and 2 m to starboard."""
    assert positions(run([(5.0, 2.0)] * 3, np.radians(degrees)))[1] == pytest.approx((east, 1000.0 + north))


def test_crossings_without_power_do_not_count() -> None:
    assert positions(run([None, (6.0, 0.0), None]))[0] == pytest.approx((6.0, 1000.0))
    assert positions(run([None] * 3)) == [(0.0, 1000.0)] * 3
    assert positions(run([(6.0, 0.0)] + [None] * (CROSSINGS + 1)))[-1] == (0.0, 1000.0)  # too long ago


def test_targets_are_not_mixed() -> None:
    one, other = run([(6.0, 0.0)])[0], replace(truth("buoy", 0.0, 0.0, 500.0, speed=0.0))
    both = at_power_centroids([replace(one, truths=(*one.truths, other))])[0]
    assert [truth.position for truth in both.truths] == [pytest.approx((6.0, 1000.0)), (0.0, 500.0)]
