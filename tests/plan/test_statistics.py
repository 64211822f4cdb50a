"""Sums of costs, and the pace that they allow."""

import math

import pytest

from radar_service.plan.statistics import Costs, EngineStatistics, realtime_factor
from tests.scenes import scene

COSTS = Costs(1.0, 2.0, 4.0, 32.0, effects={"clutter": 8.0, "interference": 16.0})


def test_the_total_has_every_stage_once() -> None:
    """Powers of two: a stage that is missing or counted twice changes the sum."""
    assert COSTS.total == 63.0


def test_the_pace_is_the_spoke_period_over_the_cost_of_an_azimuth() -> None:
    """24 rpm and 720 azimuths: 3.4722 ms per spoke; 63 us of it are used."""
    made = scene(radar={"rpm": 24, "azimuths": 720})
    assert realtime_factor(made, COSTS) == pytest.approx(2.5 / 720 / 63e-6)
    assert realtime_factor(made, Costs(0.0, 0.0, 0.0, 0.0, 0.0)) == math.inf


def test_nothing_is_known_before_an_engine_is_prepared() -> None:
    assert EngineStatistics() == EngineStatistics({}, None, None, None)
