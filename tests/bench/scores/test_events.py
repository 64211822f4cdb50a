"""Events of runs by hand: two targets that stand 1 km apart, and tracks that stand at one of them, or far off."""

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
