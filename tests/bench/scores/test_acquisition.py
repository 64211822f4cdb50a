"""Orders of a user: a tracker that obeys has no error, and one that ignores a kind of them has the error of this kind."""

import math
from typing import Any

import pytest
from pydantic import ValidationError

from radar_service.bench.run import answered
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.acquisition import acquisition_scores
from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.trackers.callable_child import scan_of
from tests.bench import known_trackers as known
from tests.bench.scores.test_scoring import given, truth
from tests.bench.trackers.test_stone_soup import plot

SHIPS = {"inside": 2000.0, "beside": 2500.0, "chosen": -2000.0, "outside": -2600.0}  # m to the north
ORDERS: dict[int, dict[str, Any]] = {
    0: {"zone": (1500.0, 3500.0, 315.0, 45.0)}, 4: {"acquire": "chosen"}, 20: {"cancel": "beside"}
}  # fmt: skip


def scans(count: int = 40, orders: dict[int, dict[str, Any]] = ORDERS) -> list[ScanResult]:
    """A plot of each ship in each scan."""
    made = []
    for k in range(count):
        ships = tuple(truth(name, 2.5 * (k + 1), 0.0, north) for name, north in SHIPS.items())
        plots = tuple(plot(2.5 * (k + 1), *ship.position) for ship in ships)
        ordered = ({"acquire": None, "cancel": None, "zone": None, **orders[k]},) if k in orders else ()
        made.append(
            ScanResult(scan_of({**given(k).as_dict(), "plots": [vars(p) for p in plots]}), (), ships, orders=ordered)
        )
    return made


def errors(results: list[ScanResult], ignored: str = "") -> float | None:
    tracker = known.Obeys()
    tracker.ignored = ignored
    return acquisition_scores(judged([*answered(results, tracker)])).get("acquisition_errors")


@pytest.mark.parametrize(
    ("ignored", "wrong"), [("", 0.0), ("zone", 1.0), ("acquire", 1.0), ("cancel", 1.0)]
)  # outside is acquired too; chosen is not; beside goes on
def test_each_order_is_obeyed(ignored: str, wrong: float) -> None:
    assert errors(scans(), ignored) == wrong


def test_a_target_inside_the_zone_needs_a_track_within_a_minute() -> None:
    """A tracker that waits for an order acquires neither of two; 24 scans end after a minute, when nothing is owed yet."""
    alone: dict[int, dict[str, Any]] = {0: {"zone": (1500.0, 3500.0, 135.0, 225.0)}}
    ordered = {0: ORDERS[0], 4: {"acquire": "chosen"}}
    blind = [ScanResult(r.given, (), r.truths, orders=r.orders) for r in scans(40, ordered)]
    assert errors(scans(40, alone)) == 0.0

    class Waits(known.Obeys):
        def acquired(self, state: Any, scan: Any) -> Any:
            how = super().acquired(state, scan)
            return how if how == "manual" else None

    found = acquisition_scores(judged([*answered(blind, Waits())]))
    farther = {0: {"zone": (2000.7, 3500.0, 315.0, 45.0)}, 4: {"acquire": "chosen"}}  # `inside` lacks 0.5 m at first
    later = [ScanResult(r.given, (), r.truths, orders=r.orders) for r in scans(40, farther)]
    assert acquisition_scores(judged([*answered(later, Waits())])) == {"acquisition_errors": 1.0}
    assert found == {"acquisition_errors": 2.0} and errors(scans(24, {0: ORDERS[0]})) == 0.0


def test_orders_go_by_places_and_by_names_of_tracks() -> None:
    sent = [result.given.as_dict().get("orders") for result in answered(scans(), known.Obeys())]
    (zone,), (place,), (name,) = (orders for orders in sent if orders)
    assert zone == {"zone": [1500.0, 3500.0, math.radians(315.0), math.radians(45.0)]}
    assert place == {"acquire": [125.0, -2000.0]} and name == {"cancel": "2"}


def test_who_does_not_say_how_it_acquires_is_not_judged() -> None:
    assert acquisition_scores(judged([*answered(scans(), known.Imm())])) == {}


@pytest.mark.parametrize(
    "orders", [[{}], [{"acquire": "a", "cancel": "a"}], [{"zone": (0, 1, 0, 1)}] * 2, [{"cancel": "b"}]]
)
def test_an_order_is_one_thing_of_one_target(orders: list[dict[str, Any]]) -> None:
    with pytest.raises(ValidationError, match="order: "):
        Scenario(
            question="q", expected="e", source="s", scene={"body": [{"name": "a"}]}, order=[{"scan": 0, **o} for o in orders]
        )
