"""When a state of a target is owed, by hand."""

from dataclasses import replace

import pytest

from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.sightings import sightings_of
from tests.bench.scores.test_scoring import given, truth


def run(visible: str) -> list[ScanResult]:
    """A target that is seen in the scans of these signs that are no dots."""
    return [
        ScanResult(given(k), (), (replace(truth("t", 2.5 * k, 0.0, 1000.0), visible=sign != "."),))
        for k, sign in enumerate(visible)
    ]


@pytest.mark.parametrize(
    ("visible", "first", "due", "vanishes"),
    [
        ("x" * 40, 0, range(23, 40), False),  # the scan that ends 60 s after the crossing at 0 s
        ("." * 5 + "x" * 40, 5, range(28, 45), False),
        ("x" * 30 + "." * 5 + "x" * 5, 0, range(23, 40), False),
        ("x" * 30 + "." * 5, 0, range(23, 35), False),  # she may come back
        ("x" * 30 + "." * 6, 0, range(23, 30), True),
        ("x" * 30 + "." * 6 + "x" * 14, 0, [*range(23, 30), *range(46, 50)], False),
    ],
    ids=["always", "late", "gap", "gap at the end", "vanishes", "long gap"],
)
def test_a_state_is_owed_after_a_minute_and_through_short_gaps(
    visible: str, first: int, due: range | list[int], vanishes: bool
) -> None:
    sightings = sightings_of(run(visible))["t"]
    assert (sightings.first, sorted(sightings.due), sightings.has_vanished) == (first, [*due], vanishes)


def test_a_track_may_stay_for_twenty_scans_and_come_no_sooner_than_its_target() -> None:
    sightings = sightings_of(run("..." + "x" * 30 + "." * 40))["t"]
    assert [k for k in range(73) if sightings.may_have_track(k)] == [*range(3, 53)]


def test_a_target_that_is_never_seen_is_none() -> None:
    assert sightings_of(run("....")) == {}
