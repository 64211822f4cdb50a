"""What a tracker says of danger and of itself, by hand: a ship that comes straight on at 10 m/s, from 19.6 km."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.warnings import warning_scores
from tests.bench.scores.test_scoring import given, track, truth

Said = Callable[[int], dict[str, Any]]  # by scan


def coming(
    says: Said, scans: int = 160, names: str = "a", north: float = 0.0, start: float = -19.6e3
) -> dict[str, float | None]:
    """Scores of a ship with one track, whose name is that of its place in `names`, 80 scans each."""
    made = []
    for scan in range(scans):
        ship = truth("ship", 2.5 * (scan + 1), start, north)
        made.append(ScanResult(given(scan), (replace(track(names[scan // 80 % len(names)], ship), **says(scan)),), (ship,)))
    return warning_scores(judged(made))


def test_who_says_nothing_is_not_judged() -> None:
    assert coming(lambda scan: {}) == {}


def test_cpa_and_tcpa_are_those_of_the_end_of_the_scan() -> None:
    """From three minutes on, in 95 % of scans: before, nothing is judged."""
    for tcpa, error in ((0.0, 0.0), (60.0, 1.0)):
        scores = coming(
            lambda scan, more=tcpa: {"cpa": 185.2 if scan >= 72 else 1e6, "tcpa": 1960.0 - 2.5 * (scan + 1) + more}
        )
        assert scores["said_cpa_nm"] == pytest.approx(0.1) and scores["said_tcpa_min"] == pytest.approx(error, abs=1e-6)


@pytest.mark.parametrize(
    ("first", "north", "late", "false"),
    [(63, 0.0, 0.0, 0.0), (75, 0.0, 0.0, 0.0), (79, 0.0, 4.0, 0.0), (0, 0.0, 0.0, 0.0), (999, 0.0, 85.0, 0.0)],
)
def test_an_alarm_is_due_where_the_errors_of_table_3_leave_no_doubt(
    first: int, north: float, late: float, false: float
) -> None:
    """A TCPA of 1770 s ends scan 75: half an hour, less half a minute."""
    scores = coming(lambda scan: {"alarm": scan >= first}, north=north)
    assert (scores["alarm_late_scans"], scores["false_alarms"]) == (late, false)
    lead = (
        None if first == 999 else pytest.approx((1960.0 - 2.5 * (max(first, 72) + 1)) / 60.0)
    )  # scan 72 ends three minutes
    assert scores.get("alarm_lead_min") == lead


def test_a_ship_that_keeps_its_range_has_no_time_of_approach() -> None:
    """Whatever is said of it is no error, and an alarm within 2 NM is not false."""
    made = []
    for scan in range(80):
        ship = truth("ship", 2.5 * (scan + 1), 0.0, 1000.0)
        ship = replace(ship, own_velocity=ship.velocity, own_position=(ship.position[0], 0.0))
        said = replace(track("a", ship), cpa=1000.0, tcpa=0.0, alarm=True)
        made.append(ScanResult(given(scan), (said,), (ship,)))
    scores = warning_scores(judged(made))
    assert scores == {"said_cpa_nm": pytest.approx(0.0), "false_alarms": 0.0}


@pytest.mark.parametrize(
    ("north", "start", "false"), [(4000.0, -15e3, 0.0), (4400.0, -15e3, 1.0), (0.0, -22.6e3, 1.0), (0.0, 1e3, 1.0)]
)
def test_an_alarm_without_danger_is_false(north: float, start: float, false: float) -> None:
    """4260 m are 2 NM and 0.3; or too early; or the ship goes away."""
    scores = coming(lambda scan: {"alarm": True}, north=north, start=start)
    assert scores["false_alarms"] == false


@pytest.mark.parametrize(
    ("told", "scans", "errors"),
    [((), 30, 1.0), ((20,), 30, 0.0), ((21,), 30, 0.0), ((24,), 30, 1.0), ((10,), 30, 2.0), ((20, 21), 30, 1.0), ((), 21, 0.0)],
)  # fmt: skip
def test_a_lost_target_is_told_within_two_scans(told: tuple[int, ...], scans: int, errors: float) -> None:
    """Its track ends after scan 19: without a word, at once, later, too late, or the word comes while it goes on, or twice; and
    a run may end before the word is due."""
    made = []
    for scan in range(scans):
        ship = truth("ship", 2.5 * (scan + 1), 0.0, 1000.0)
        names = ["a"] * (scan < 20 and scan not in told) + ["b"]
        lost = [replace(track("a", ship), lost=True)] if scan in told else []
        tracks = [replace(track(name, ship, north=len(name)), lost=False) for name in names]
        made.append(ScanResult(given(scan), (*tracks, *lost), (ship,)))
    assert warning_scores(judged(made)).get("lost_errors", 0.0) == errors


@pytest.mark.parametrize(
    ("tracks", "full", "errors"), [(21, False, 16.0), (21, True, 0.0), (19, False, 0.0), (19, True, 40.0)]
)
def test_a_full_table_is_told(tracks: int, full: bool, errors: float) -> None:
    """One ship of all is left out; it is owed a track from the 24th scan on. Fewer than 20 tracks are no full table."""
    made = []
    for scan in range(40):
        ships = [truth(f"{k}", 2.5 * (scan + 1), 0.0, 500.0 * k) for k in range(tracks + 1)]
        said = tuple(replace(track(ship.body, ship), full=full) for ship in ships[1:])
        made.append(ScanResult(given(scan), said, tuple(ships)))
    assert warning_scores(judged(made))["full_errors"] == errors
