"""The lines of trackers: what is no answer is refused with a sentence, and a tracker that does not read holds nobody."""

import json
import threading

import pytest

from radar_service.bench.trackers.json_lines import MAX_TRACKS, LineTracker, TrackerError, plots_from_line, tracks_from_line
from tests.bench.trackers.test_stone_soup import given, plot

STATE = {"track": "a", "time": 1.0, "east": 1.0, "north": 2.0, "velocity_east": 0.0, "velocity_north": 0.0}


def line(*tracks: object, **changes: object) -> str:
    return json.dumps({"type": "tracks", "scan": 4, "tracks": list(tracks), **changes})


def test_an_answer_gives_tracks() -> None:
    one, other = tracks_from_line(line(STATE, {**STATE, "track": 7}), 4)
    assert (one.track, one.time, one.east, one.north, other.track) == ("a", 1.0, 1.0, 2.0, "7")
    assert tracks_from_line(line(), 4) == ()
    assert [one.coasting for one in tracks_from_line(line({**STATE, "coasting": True}, {**STATE, "track": "b"}), 4)] == [
        True,
        False,
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"time": float("nan")}, "time is nan"),
        ({"north": float("inf")}, "north is inf"),
        ({"east": None}, "not understood"),
        ({"track": "b"}, "names a track twice"),
        ({"velocity_east": "fast"}, "fast"),
        ({"east": -1e200}, "at most 1e[+]09"),
        ({"track": "n" * 101}, "at most 100 characters"),
        ({"track": {"name": "a"}}, "a whole number, is needed"),
        ({"track": 10**100}, "at most 100 characters"),
        ({"coasting": 1}, "true or false is needed"),
        ({"mmsi": "211000001"}, "mmsi is '211000001'; a whole number of nine digits"),
        ({"mmsi": True}, "mmsi is True"),
        ({"mmsi": 10**4000}, "mmsi is 1000"),
        ({"priority": "both"}, "priority is 'both'; ais or radar is needed"),
    ],
    ids=["nan", "inf", "none", "twice", "text", "far", "long name", "no name", "long number", "coasting", "mmsi",
         "true", "digits", "priority"],
)  # fmt: skip
def test_tracks_of_rubbish_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(TrackerError, match=f"answer to scan 4.*{words}") as raised:
        tracks_from_line(line({**STATE, **change}, {**STATE, "track": "b"}), 4)
    assert len(str(raised.value)) < 500


def test_the_plots_of_an_extractor_lie_about_own_ship() -> None:
    at = given(4, ())
    answer = json.dumps({"type": "plots", "scan": 4, "plots": [{"time": 1, "range": 50.0, "bearing": 1.5707963, "x": 0}]})
    (one,) = plots_from_line(answer, at)
    assert (one.scan, one.time, one.range) == (4, 1.0, 50.0)
    assert (one.east - at.east, one.north - at.north) == (pytest.approx(50.0), pytest.approx(0.0, abs=1e-5))
    with pytest.raises(TrackerError, match="answer to scan 4 is not understood .KeyError.'bearing'.."):
        plots_from_line(answer.replace("bearing", "angle"), at)
    with pytest.raises(TrackerError, match="answer to scan 4 has type 'tracks'"):
        plots_from_line(line(), at)


@pytest.mark.parametrize(
    "text",
    ["", "[]", "null", "[" * 100_000, '{"type": "tracks"}', line(tracks=None), line(tracks=7), line(tracks=[3]), "\udcff",
     '{"type": "tracks", "scan": 4, "tracks": [' + "9" * 5000 + "]}"],
    ids=["empty", "list", "null", "deep", "cut", "no tracks", "number", "numbers", "surrogate", "digits"],
)  # fmt: skip
def test_what_is_no_answer_is_refused_in_one_short_line(text: str) -> None:
    with pytest.raises(TrackerError, match="answer to scan 4 is not understood") as raised:
        tracks_from_line(text, 4)
    assert len(str(raised.value)) < 500 and "\n" not in str(raised.value)


def test_another_scan_and_too_many_tracks_are_refused() -> None:
    with pytest.raises(TrackerError, match="type 'tracks', scan 4$"):
        tracks_from_line(line(), 5)
    with pytest.raises(TrackerError, match="type 'plots', scan 4$"):
        tracks_from_line(line(type="plots"), 4)
    many = [{**STATE, "track": k} for k in range(MAX_TRACKS + 1)]
    assert len(tracks_from_line(line(*many[1:]), 4)) == MAX_TRACKS
    with pytest.raises(TrackerError, match="has 1001 tracks; at most 1000"):
        tracks_from_line(line(*many), 4)


class Deaf(LineTracker):
    """Takes no line before it may, and then fails as it is told to."""

    def __init__(self, error: Exception | None) -> None:
        super().__init__("deaf", 0.01 if error is None else 60.0)
        self.may, self._error = threading.Event(), error

    def write(self, line: str) -> None:
        if self._error:
            raise self._error
        self.may.wait(60.0)

    def answer(self, scan: int) -> str:
        raise self.silent(scan)

    def close(self) -> None:
        self.may.set()


def test_a_tracker_that_does_not_read_holds_nobody() -> None:
    tracker = Deaf(None)
    with pytest.raises(TrackerError, match="'deaf' read no plots for 0.01 s"):
        tracker.update(given(0, (plot(1.0, 100.0, 200.0),)))
    assert tracker.is_stuck
    tracker.close()


def test_a_tracker_that_has_gone_takes_no_more_plots() -> None:
    with pytest.raises(TrackerError, match="'deaf' has ended and takes no more plots") as raised:
        Deaf(BrokenPipeError("gone")).update(given(0, ()))
    assert isinstance(raised.value.__cause__, BrokenPipeError)
