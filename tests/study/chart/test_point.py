"""Points of the chart: interleaved timing and the Pareto front."""

from collections.abc import Callable

import pytest

from radar_service.study.chart.point import Point, pareto, time_interleaved


def test_tasks_share_a_time_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """One task takes 1 s, the other 3 s. A budget of ten seconds gives five to each."""
    clock, calls = [0.0], []
    monkeypatch.setattr("radar_service.study.chart.point.time.process_time", lambda: clock[0])

    def lasting(seconds: float) -> Callable[[], object]:
        return lambda: clock.append(clock.pop() + seconds)

    times = time_interleaved([lasting(1.0), lasting(3.0)], [9, 9], lambda: calls.append(1), budget=10.0)
    assert times == [(1.0,) * 5, (3.0,) * 2] and len(calls) == 18
    times = time_interleaved([lasting(1.0), lasting(3.0)], [9, 9], lambda: None, budget=20.0)
    assert times == [(1.0,) * 9, (3.0,) * 4]  # the second uses what the first leaves of its half
    assert time_interleaved([lasting(9.0)], [5], lambda: None, budget=4.0) == [(9.0,) * 2]  # a spread needs two


def test_no_point_beats_the_pareto_front() -> None:
    def at(seconds: float, error: float | None, missed: float | None = None) -> Point:
        return Point("field", "f", "s", (seconds,), False, error, missed=missed)

    points = [at(3, -10), at(1, -5), at(2, -4), at(4, -10), at(0.5, None), at(0.1, -90, missed=0.4)]
    assert pareto(points) == [points[1], points[0]]
