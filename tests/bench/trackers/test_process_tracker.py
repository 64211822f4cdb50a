"""Trackers in other programs: JSON Lines on standard input and output, and every way in which they go wrong."""

import contextlib
import os
import re
import select
import sys
import tempfile
from pathlib import Path

import pytest

from radar_service.bench.run import answered
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.trackers import process_tracker
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.process_tracker import ProcessTracker, end_waiting
from tests.bench.trackers.test_stone_soup import given, plot

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


AGAIN = """
import json, os, sys
for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "header":
        run = message["run"]
    else:
        state = {"track": f"{os.getpid()} {run}", "time": 0, "east": 0, "north": 0, "velocity_east": 0, "velocity_north": 0}
        print(json.dumps({"type": "tracks", "scan": message["scan"], "again": True, "tracks": [state]}), flush=True)
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
        ("import sys; sys.exit(1)", "has ended"),
        ("import time; time.sleep(60)", "no answer \\(a line, flushed\\) to scan 0 within 0.3 s"),
    ],
    ids=["ends", "silent"],
)  # fmt: skip
def test_what_goes_wrong_is_said(code: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(TrackerError, match=message):
        tracker = ProcessTracker(program(tmp_path, code), {"seed": 0}, timeout=0.3 if "sleep" in code else 20.0)
        try:
            for scan in range(3):
                tracker.update(given(scan, ()))
        finally:
            tracker.close()


@pytest.mark.parametrize("sealed", [None, (), ("/nowhere",)])
@pytest.mark.parametrize(
    ("command", "message"),
    [("no-such-program --fast", "there is no such program$"), ("", ""), ("python 'x", ""),
     ("gmn", "no such program; did you mean gnn?"), ("tracker", "did you mean ./tracker.py?"),
     ("./tracker.py", "it may not be executed"),
     (f"{sys.executable} -u trackers.py", "there is no file trackers.py in .*; did you mean tracker.py?")],
)  # fmt: skip
def test_a_command_that_is_none_is_refused(
    command: str, message: str, sealed: tuple[str, ...] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tracker.py").write_text("")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TrackerError, match=f"{re.escape(command)}.* could not be started: .*{message}"):
        ProcessTracker(command, {}, sealed=sealed)


def test_a_program_that_reads_nothing_is_ended(tmp_path: Path) -> None:
    """More plots than the pipe takes: the bench does not wait, and closing ends the program."""
    tracker = ProcessTracker(program(tmp_path, "import time; time.sleep(600)"), {"seed": 0}, timeout=0.3)
    with pytest.raises(TrackerError, match="read no plots for 0.3 s"):
        tracker.update(given(0, (plot(1.0, 100.0, 200.0),) * 1000))
    tracker.close()
    assert not tracker.is_stuck


def test_a_program_that_writes_more_than_it_is_asked_is_read_no_further(tmp_path: Path) -> None:
    """It answers all scans before it gets one, for ever: a few lines are kept, the rest is not read."""
    answer = "{'type': 'tracks', 'scan': k, 'tracks': []}"
    code = f"import itertools, json\nfor k in itertools.count():\n    print(json.dumps({answer}))\n"
    with pytest.raises(TrackerError, match="wrote more lines than it got scans"):  # perhaps before it got the header
        tracker = ProcessTracker(program(tmp_path, code), {"seed": 0})
        with contextlib.closing(tracker):
            for scan in range(process_tracker.MAX_WAITING + 1000):
                tracker.update(given(scan, ()))


def test_an_answer_without_end_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_tracker, "MAX_LINE", 1000)
    tracker = ProcessTracker(program(tmp_path, "print('x' * 10_000, flush=True)\ninput()\ninput()\ninput()"), {"seed": 0})
    with pytest.raises(TrackerError, match="it has 1000 characters or more"):
        tracker.update(given(0, ()))
    tracker.close()


LEAKS = """
import json, os, sys, time
kept, children = [], []
for line in sys.stdin:
    scan = json.loads(line)
    if scan["type"] == "scan":
        {wrong}
        print(json.dumps({{"type": "tracks", "scan": scan["scan"], "tracks": []}}), flush=True)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is absent")
def test_memory_is_that_of_the_program_and_of_what_it_starts(tmp_path: Path) -> None:
    """20 MB a scan, in a child."""
    leak = "kept.append(bytearray(b'x') * 20_000_000)"
    for wrong in (leak, f"pid = os.fork()\n        if not pid:\n            {leak}\n            time.sleep(60)"):
        tracker = ProcessTracker(program(tmp_path, LEAKS.format(wrong=wrong)), {})
        tracker.update(given(0, ()))
        first = tracker.memory or 0
        for scan in range(1, 4):
            tracker.update(given(scan, ()))
        later = tracker.memory or 0
        tracker.close()
        assert later - first > (55e6 if wrong == leak else 0.0)


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is absent")
def test_a_program_that_forks_without_end_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_tracker, "MAX_PROCESSES", 4)
    wrong = "[os.fork() or time.sleep(60) for _ in range(5)]"
    tracker = ProcessTracker(program(tmp_path, LEAKS.format(wrong=wrong)), {})
    with pytest.raises(TrackerError, match="tracker: '.*' has 6 processes; at most 4"):
        list(answered([ScanResult(given(0, ()), (), ())], tracker))
    tracker.close()


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is absent")
def test_a_child_in_a_session_of_its_own_ends_with_its_program(tmp_path: Path) -> None:
    """Its output hangs up as it ends."""
    os.mkfifo(fifo := tmp_path / "fifo")
    (hung_up := select.poll()).register(output := os.open(fifo, os.O_RDONLY | os.O_NONBLOCK), select.POLLHUP)
    child = f"subprocess.Popen(['sleep', '600'], stdout=open({str(fifo)!r}, 'w'), stderr=-3, start_new_session=True)"
    tracker = ProcessTracker(program(tmp_path, f"import subprocess\n{child}\ninput()"), {})
    tracker.close()
    assert hung_up.poll(10_000)
    os.close(output)


def test_an_answer_that_is_no_utf_8_is_refused_at_once(tmp_path: Path) -> None:
    code = "import sys\nfor line in sys.stdin:\n    sys.stdout.buffer.write(b'\\xff\\xfe\\n')\n    sys.stdout.flush()\n"
    tracker = ProcessTracker(program(tmp_path, code), {})
    with pytest.raises(TrackerError, match="not understood"):
        tracker.update(given(0, ()))
    tracker.close()


def test_a_program_that_asks_for_it_gets_further_headers_and_others_start_anew(tmp_path: Path) -> None:
    command, names = program(tmp_path, AGAIN), list[list[str]]()
    for run, digest in enumerate("aaab"):
        tracker = ProcessTracker.ready(command, {"run": run}, None, digest)
        names.append(tracker.update(given(0, ()))[0].track.split())
        tracker.finish()
    ends = tracker.status
    end_waiting()
    assert [name[1] for name in names] == ["0", "1", "2", "3"] and ends is None and tracker.status is not None
    assert names[0][0] == names[1][0] == names[2][0] != names[3][0]
    tracker = ProcessTracker.ready(program(tmp_path, AGAIN.replace("True", "False")), {"run": 0}, None, "")
    tracker.update(given(0, ()))
    tracker.finish()
    assert tracker.status is not None


def test_a_program_that_ends_while_it_waits_leaves_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    command, trackers = program(tmp_path, AGAIN.replace("flush=True)", "flush=True)\n        break")), list[ProcessTracker]()
    for run in range(2):
        trackers.append(ProcessTracker.ready(command, {"run": run}, (), ""))
        trackers[-1].update(given(0, ()))
        trackers[-1].finish()
        while trackers[-1].status is None:
            pass
    assert len([*tmp_path.glob("tracker-*")]) == 1
    end_waiting()
