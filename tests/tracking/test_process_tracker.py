"""Trackers in other programs: JSON Lines on standard input and output, and every way in which they go wrong."""

import json
import sys
from pathlib import Path

import pytest

from radar_service.tracking.process_tracker import ProcessTracker, TrackerError, tracks_from_line
from tests.tracking.test_stone_soup import given, plot

ECHO = """
import json, sys
header = json.loads(sys.stdin.readline())
for line in sys.stdin:
    scan = json.loads(line)
    tracks = [
        {"track": k, "time": p["time"], "east": p["east"], "north": p["north"], "velocity_east": 0,
         "velocity_north": header["seed"]}
        for k, p in enumerate(scan["plots"])
    ]
    print(json.dumps({"type": "tracks", "scan": scan["scan"], "tracks": tracks}), flush=True)
"""


def program(tmp_path: Path, code: str) -> str:
    path = tmp_path / "tracker.py"
    path.write_text(code)
    return f"{sys.executable} {path}"


def test_a_program_gets_plots_and_gives_tracks(tmp_path: Path) -> None:
    tracker = ProcessTracker(program(tmp_path, ECHO), {"scenario": "s", "seed": 7})
    for scan in range(3):
        (state,) = tracker.update(given(scan, (plot(scan * 2.5 + 1, 100.0, 200.0),)))
        assert (state.track, state.time, state.east, state.north, state.velocity_north) == (
            "0",
            scan * 2.5 + 1,
            100.0,
            200.0,
            7.0,
        )
    tracker.close()


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import sys; sys.exit(1)", "ended|takes no more"),
        ("import sys\nfor line in sys.stdin: print('hello', flush=True)", "not understood .*hello"),
        ("import sys, json\nfor line in sys.stdin: print(json.dumps({'type': 'tracks', 'scan': 9, 'tracks': []}), flush=True)",
         "the answer to scan 0 has type 'tracks', scan 9"),
        ("import time; time.sleep(60)", "no answer to scan 0 within 0.3 s"),
    ],
    ids=["ends", "rubbish", "another scan", "silent"],
)  # fmt: skip
def test_what_goes_wrong_is_said(code: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(TrackerError, match=message):
        tracker = ProcessTracker(program(tmp_path, code), {"seed": 0}, timeout=0.3 if "sleep" in code else 20.0)
        try:
            for scan in range(3):
                tracker.update(given(scan, ()))
        finally:
            tracker.close()


def test_a_command_that_is_none_is_refused() -> None:
    with pytest.raises(TrackerError, match="no-such-program.* could not be started"):
        ProcessTracker("no-such-program --fast", {})


@pytest.mark.parametrize(
    "change",
    [{"time": float("nan")}, {"east": None}, {"track": "b"}, {"velocity_east": "fast"}],
    ids=["nan", "none", "twice", "text"],
)  # fmt: skip
def test_tracks_of_rubbish_are_refused(change: dict[str, object]) -> None:
    state = {"track": "a", "time": 1.0, "east": 1.0, "north": 2.0, "velocity_east": 0.0, "velocity_north": 0.0}
    line = json.dumps({"type": "tracks", "scan": 4, "tracks": [{**state, **change}, {**state, "track": "b"}]})
    with pytest.raises(TrackerError, match="answer to scan 4"):
        tracks_from_line(line, 4)


def test_an_answer_that_is_no_utf_8_is_refused_at_once(tmp_path: Path) -> None:
    code = "import sys\nfor line in sys.stdin:\n    sys.stdout.buffer.write(b'\\xff\\xfe\\n')\n    sys.stdout.flush()\n"
    tracker = ProcessTracker(program(tmp_path, code), {})
    with pytest.raises(TrackerError, match="not understood"):
        tracker.update(given(0, ()))
    tracker.close()
