"""Reporting intervals of ITU-R M.1371-5."""

import math

import pytest

from radar_service.world.reporting import STATIC, TURNING, Reporting, StationClass, interval
from tests.ports.ais.test_messages import ship

KNOT = 1852.0 / 3600.0


@pytest.mark.parametrize(
    ("station", "knots", "turns", "expected"),
    [
        ("A", 0, False, 180), ("A", 0.1, False, 10), ("A", 14, False, 10), ("A", 14, True, 10 / 3), ("A", 14.1, False, 6),
        ("A", 23, True, 2), ("A", 23, False, 6), ("A", 23.1, False, 2), ("A", 23.1, True, 2), ("B-SO", 2, False, 180),
        ("B-SO", 2.1, True, 30), ("B-SO", 14.1, False, 15), ("B-SO", 23.1, False, 5), ("B-CS", 2, False, 180),
        ("B-CS", 2.1, False, 30), ("B-CS", 40, True, 30),
    ],
)  # fmt: skip
def test_intervals(station: StationClass, knots: float, turns: bool, expected: float) -> None:
    rate = 1.01 * TURNING if turns else 0.99 * TURNING
    assert interval(ship(station_class=station), knots * KNOT, rate) == interval(
        ship(station_class=station), knots * KNOT, -rate
    )
    assert interval(ship(station_class=station), knots * KNOT, rate) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("knots", "turns", "every"), [(10, False, 10.0), (10, True, 10 / 3), (20, False, 6.0), (30, False, 2.0)]
)
def test_reports_keep_their_interval_on_whole_seconds(knots: float, turns: bool, every: float) -> None:
    reporting = Reporting(ship(), 5)
    times = [second for second in range(600) if reporting.is_due(second, knots * KNOT, 2 * TURNING * turns)]
    assert len(times) == pytest.approx(600 / every, abs=1)
    assert {b - a for a, b in zip(times, times[1:], strict=False)} <= {math.floor(every), math.ceil(every)}
    assert times[0] < every


def test_an_aid_reports_each_three_minutes_however_it_moves() -> None:
    reporting = Reporting(ship(kind="aid"), 5)
    times = [second for second in range(1000) if reporting.is_due(second, 5 * KNOT * (second % 2), 0.1)]
    assert {b - a for a, b in zip(times, times[1:], strict=False)} == {180} and times[0] < 180
    assert not any(reporting.is_static_due(second) for second in range(1000))


def test_a_sart_sends_eight_messages_a_minute_two_of_them_its_text_in_each_fourth() -> None:
    reporting = Reporting(ship(kind="sart"), 5)
    first = next(second for second in range(60) if reporting.is_due(second, 0.0, 0.0))
    sent = {
        second - first: "text" if reporting.is_static_due(second) else "position"
        for second in range(first, first + 480)
        if reporting.is_due(second, 0.0, 0.0) or reporting.is_static_due(second)
    }
    assert list(sent) == [60 * minute + 2 * k for minute in range(8) for k in range(8)]
    assert [second for second, what in sent.items() if what == "text"] == [8, 10, 248, 250]


def test_a_turn_is_reported_sooner() -> None:
    """At anchor each three minutes; the report that is due later comes within the new interval."""
    reporting = Reporting(ship(), 5)
    at_rest = [second for second in range(400) if reporting.is_due(second, 0.0, 0.0)]
    assert len(at_rest) in (2, 3) and at_rest[-1] - at_rest[0] in (180, 360)
    under_way = [second for second in range(400, 430) if reporting.is_due(second, 30 * KNOT, 0.0)]
    assert under_way[0] <= 402 and len(under_way) >= 14


def test_static_reports_come_every_six_minutes_and_ships_not_together() -> None:
    firsts = []
    for mmsi in range(100, 140):
        reporting = Reporting(ship(mmsi=mmsi), 1)
        times = [second for second in range(1000) if reporting.is_static_due(second)]
        assert {b - a for a, b in zip(times, times[1:], strict=False)} == {int(STATIC)}
        firsts.append(times[0])
        assert 1 <= reporting.slot < 10
    assert len(set(firsts)) > 10 and max(firsts) < 60
