"""Events of runs by hand: two targets that stand 1 km apart, and tracks that stand at one of them, or far off."""

from dataclasses import replace

import pytest

from radar_service.bench.scores.events import Event, events_of, gravest
from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult
from tests.bench.scores.test_scoring import given, track, truth

PLACES = {"a": (0.0, 1000.0), "b": (1000.0, 1000.0), "x": (5000.0, 1000.0)}  # x: where nothing is
SCANS = 40


def events(**tracks: str) -> list[tuple[str, int, int, str, str]]:
    """Events without sentences. tracks: by name a letter of PLACES for each scan, or a dot; the last letter goes on."""
    made = []
    for scan in range(SCANS):
        at = {place: truth(place, 2.5 * scan, *position) for place, position in PLACES.items()}
        places = {name: path[min(scan, len(path) - 1)] for name, path in tracks.items()}
        states = tuple(track(name, at[place]) for name, place in places.items() if place != ".")
        made.append(ScanResult(given(scan), states, (at["a"], at["b"])))
    return [(event.kind, event.scan, event.last, event.body, event.other) for event in events_of(judged(made))]


@pytest.mark.parametrize(
    ("tracks", "expected"),
    [
        ({"p": "a", "q": "b"}, []),
        ({"p": "a" * 30 + "b", "q": "b" * 30 + "a"}, [("swap", 30, 30, "a", "b")]),
        ({"p": "a" * 30 + "b", "q": "b" * 30 + "x"}, [
            ("swap", 30, 30, "b", "a"), ("break", 30, 39, "a", ""), ("ghost", 30, 39, "b", ""),
        ]),
        ({"p": "a" * 30 + "x", "q": "b", "r": "." * 30 + "a"}, [("break", 30, 30, "a", ""), ("ghost", 30, 39, "a", "")]),
        ({"p": "a" * 30 + "...a", "q": "b"}, [("break", 30, 32, "a", "")]),
        ({"p": "." * 9 + "a", "q": "b"}, []),  # the tenth scan has its first state
        ({"p": "." * 10 + "a", "q": "b"}, [("late", 9, 9, "a", "")]),
        ({"q": "b"}, [("late", 9, 39, "a", "")]),
        ({"p": "a", "q": "b", "r": "..x.xx."}, [("ghost", 2, 2, "", ""), ("ghost", 4, 5, "", "")]),
        ({"p": "a", "q": "b", "r": "....b"}, [("duplicate", 4, 39, "b", "")]),
    ],
)  # fmt: skip
def test_each_fault_is_an_event(tracks: dict[str, str], expected: list[tuple[str, int, int, str, str]]) -> None:
    assert events(**tracks) == expected


def test_the_gravest_events_are_kept_in_their_order() -> None:
    ghost, short, swap = (
        Event("ghost", 1, 30, "", "", ""),
        Event("ghost", 2, 2, "", "", ""),
        Event("swap", 9, 9, "a", "b", ""),
    )
    assert gravest([ghost, short, swap], 2) == [ghost, swap]


def answers(late: int, first: int, last: int, coasting: bool = False, begin: int = 0) -> list[Event]:
    """Events of a track of a target at rest that is good, but in some scans repeats its state of so many scans ago."""
    made = []
    for scan in range(SCANS):
        then = scan - late if first <= scan <= last else scan
        state = replace(track("7", truth("a", 2.5 * then, 0.0, 1000.0)), coasting=coasting)
        states = (state,) if scan >= begin else ()
        made.append(ScanResult(given(scan), states, (truth("a", 2.5 * scan, 0.0, 1000.0),)))
    return events_of(judged(made))


def test_a_state_that_is_too_old_is_told_as_stale_and_not_as_no_track() -> None:
    """Scans of 2.5 s; the state of a scan is of its begin: three scans ago it is 10 s old at the end."""
    (event,) = answers(3, 30, 33)
    assert (event.kind, event.scan, event.last, event.body) == ("stale", 30, 33, "a")
    assert event.what == "state of 10.0 s ago; say coasting, or move it on (track 7 of a)"
    assert answers(3, 30, 33, coasting=True) == answers(2, 30, 33) == []
    assert [(event.kind, event.scan, event.last) for event in answers(3, 0, 12)] == [("stale", 9, 12)]
    assert [(event.kind, event.scan, event.last) for event in answers(3, 0, 12, begin=11)] == [
        ("late", 9, 10), ("stale", 11, 12)
    ]  # fmt: skip
