"""Names, first states, gaps and ends of tracks, by hand."""

from dataclasses import replace

import pytest

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult, Surroundings
from radar_service.bench.scores.track_life import life_scores
from tests.bench.scores.test_scoring import given, track, truth


def life(seen: str, names: str) -> dict[str, float | None]:
    """A target that is seen in scans without a dot, with tracks of these names; a dot is none."""
    made = []
    for scan, (sign, name) in enumerate(zip(seen, names, strict=True)):
        one = replace(truth("t", 2.5 * scan, 0.0, 1000.0), visible=sign != ".")
        made.append(ScanResult(given(scan), () if name == "." else (track(name, one),), (one,)))
    return life_scores(judged(made))


def test_the_first_state_is_counted_from_the_first_sight() -> None:
    assert life("x" * 20, "..." + "a" * 17)["first_state_scans"] == 4.0
    assert life("....." + "x" * 20, "." * 8 + "a" * 17)["first_state_scans"] == 4.0
    assert life("x" * 20, "." * 20)["first_state_scans"] is None
    assert "first_state_scans" not in life("x" * 10, "." * 10)  # too short to owe one


def test_a_change_of_name_counts_also_after_a_pause() -> None:
    assert life("x" * 20, "a" * 10 + "." * 3 + "b" * 7)["identity_changes"] == 1.0
    assert life("x" * 20, "a" * 10 + "." * 3 + "a" * 7)["identity_changes"] == 0.0


GAPS = "x" * 30 + "....." + "x" * 10 + "." + "x" * 10


@pytest.mark.parametrize(
    ("names", "share"),
    [
        ("a" * 56, 1.0),
        ("a" * 34 + "." + "a" * 21, 0.5),
        ("a" * 35 + "b" * 21, 0.5),
        ("a" * 30 + "." * 5 + "b" * 10 + "." + "c" * 10, 0.0),
    ],
    ids=["held", "lost for a scan", "renamed", "begun anew"],
)
def test_a_gap_of_five_scans_is_bridged_by_the_same_name(names: str, share: float) -> None:
    assert life(GAPS, names)["bridged"] == share


def test_gaps_before_the_first_minute_and_longer_ones_ask_for_nothing() -> None:
    assert "bridged" not in life("x" * 10 + "..." + "x" * 30 + "." * 6 + "x" * 10, "a" * 59)


@pytest.mark.parametrize(("after", "scans"), [(0, 0.0), (8, 8.0), (40, 40.0)])
def test_a_track_ends_some_scans_after_its_target(after: int, scans: float) -> None:
    assert life("x" * 30 + "." * 40, "a" * (30 + after) + "." * (40 - after))["gone_scans"] == scans
    assert "gone_scans" not in life("x" * 30 + "." * 20, "a" * 50)  # the run ends before it is known


def test_a_stale_state_of_what_has_vanished_is_still_there() -> None:
    made = []
    for scan in range(70):
        one = replace(truth("t", 2.5 * scan, 0.0, 1000.0), visible=scan < 30)
        state = track("a", replace(one, time=2.5 * min(scan, 29)))
        made.append(ScanResult(given(scan), (state,), (one,)))
    assert life_scores(judged(made))["gone_scans"] == 40.0


def test_false_tracks_of_an_hour_are_counted_by_name_and_told_apart_from_those_of_land() -> None:
    """Three minutes: a ghost of one name counts once, one of a new name in each scan counts each time; land has its own."""
    made = []
    for scan in range(72):
        one = truth("t", 2.5 * scan, 0.0, 1000.0)
        tracks = (
            track("a", one),
            track("b", one, 500.0),
            track(f"c{scan}", one, -3000.0),
            track("stale", one, 9e3, later=-99.0),
        )
        made.append(ScanResult(given(scan), tracks, (one,)))
    coast = Surroundings(((-2000.0, 1000.0), (-1950.0, 1000.0)), "sea")
    scores = life_scores(judged(made), coast)
    by_land = {scan for scan in range(72) if min(abs(25.0 * scan - 3000.0 + each) for each in (2000.0, 1950.0)) < 200.0}
    assert scores["false_land_h"] == 20.0 * len(by_land) > 0.0
    assert scores["false_sea_h"] == 20.0 * (74 - len(by_land))
    assert life_scores(judged(made))["false_noise_h"] == 20.0 * 74 and "false_land_h" not in life_scores(judged(made))
