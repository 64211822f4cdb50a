"""A plotter of others under test: its TTM become tracks on the map, and a plotter or a feed that ends says so."""

import io
import json
import math
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

from radar_service.bench import ttm_child
from radar_service.bench.ttm_child import Plotter, track_of
from radar_service.ports.nmea.sentences import latitude_longitude, sentence
from radar_service.world.geo import geographic_from_map

OWN = {"time": 7.0, "east": 100.0, "north": 50.0, "heading": math.radians(30.0), "course": math.pi / 2.0, "speed": 5.0}


def ttm(*fields: str, status: str = "T") -> str:
    return sentence("RA", "TTM", *fields, "1.0", "2.0", "N", "x", status, "", "120000", "A").decode()


def test_true_and_relative_fields_lie_about_own_ship() -> None:
    one = track_of(ttm("01", "1.0", "90.0", "T", "10.0", "0.0", "T"), OWN)
    expected = {"track": "01", "time": 7.0, "east": 1952.0, "north": 50.0, "velocity_east": 0.0}
    assert one and one[1] and {key: one[1][key] for key in expected} == pytest.approx(expected)
    assert one[1]["velocity_north"] == pytest.approx(10 * 1852 / 3600)
    other = track_of(ttm("01", "1.0", "60.0", "R", "0.0", "0.0", "R"), OWN)
    assert other and other[1] and (other[1]["east"], other[1]["velocity_east"]) == pytest.approx((1952.0, 5.0))


ORIGIN = (50.0, -1.0)


def tll(east: float, north: float, status: str = "T") -> str:
    place = geographic_from_map(np.array([east, north]), ORIGIN).tolist()
    return sentence("RA", "TLL", "01", *latitude_longitude(*place), "x", "120000", status, "").decode()


def test_places_have_the_mean_velocity_of_the_last_minute() -> None:
    """Of a ship that turns, to 18 mm of a place: 5 m/s east, and from 60 s on north at 3 m/s."""
    plotter, velocities = Plotter(ORIGIN), list[tuple[float, float]]()
    for time in range(0, 121, 30):
        plotter.follow([{**OWN, "time": float(time)}])
        plotter.listen([tll(min(time, 60) * 5.0 - 100.0, max(time - 60, 0) * 3.0 - 2000.0)])
        (state,) = plotter.tracks(time)
        velocities += [(state["velocity_east"], state["velocity_north"])]
    assert (state["east"], state["north"], state["time"]) == pytest.approx((200.0, -1820.0, 120.0), abs=0.02)
    expected = [(0.0, 0.0), (5.0, 0.0), (5.0, 0.0), (2.5, 1.5), (0.0, 3.0)]
    assert np.array(velocities) == pytest.approx(np.array(expected), abs=2 * 0.018 / 30.0)
    plotter.listen([tll(0.0, 0.0, "L")])
    assert plotter.tracks(120.0) == []


def test_places_count_where_no_ttm_is_written_and_the_scene_has_an_origin() -> None:
    plotter = Plotter(ORIGIN)
    plotter.follow([OWN])
    plotter.listen([tll(5.0, 0.0), ttm("01", "1.0", "90.0", "T", "10.0", "0.0", "T"), tll(5.0, 0.0)])
    assert [state["east"] for state in plotter.tracks(7.0)] == pytest.approx([1952.0])
    assert track_of(tll(5.0, 0.0), OWN) is None
    with pytest.raises(ValueError):
        track_of(sentence("RA", "TLL", "01", "5x", "N", "1", "W", "", "", "T", "").decode(), OWN, ORIGIN)


def test_what_is_no_track_is_passed_over() -> None:
    good = ttm("01", "1.0", "90.0", "T", "10.0", "0.0", "T")
    assert track_of(good.replace("90", "91"), OWN) is None and track_of("$RATTM,", OWN) is None
    assert track_of(ttm("01", "1.0", "90.0", "T", "", "", "T", status="Q"), OWN) is None
    assert track_of(ttm("01", "", "", "T", "", "", "T", status="L"), OWN) == ("01", None)


def test_the_newest_states_are_answered_until_a_target_is_lost() -> None:
    plotter = Plotter()
    plotter.follow([OWN])
    first, second = (ttm(number, "1.0", "90.0", "T", "1.0", "0.0", "T") for number in ("01", "02"))
    plotter.listen(
        [first, sentence("RA", "TTM", "01", "x").decode(), second, ttm("01", "", "", "T", "", "", "T", status="L")]
    )
    assert [(state["track"], state["time"]) for state in plotter.tracks(6.0)] == [("02", 6.0)]  # none of the future
    with pytest.raises(RuntimeError, match="the feed has ended"):
        plotter.tracks(8.0)


def test_a_feed_that_breaks_ends_the_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> Iterator[dict[str, float]]:
        yield OWN
        raise OSError

    monkeypatch.setattr(ttm_child, "WAIT_SECONDS", 0.0)
    with pytest.raises(OSError):
        (plotter := Plotter()).follow(broken())
    with pytest.raises(RuntimeError, match="the feed has ended"):
        plotter.tracks(8.0)


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Lines that the program has written, after the first of which the radar turns on."""
    noted, lines = Event(), list[str]()

    def own_ships(feed: str) -> Iterator[dict[str, float]]:
        yield OWN
        assert noted.wait(30.0)
        yield {**OWN, "time": 10.0}

    def told(line: str, *rest: Any) -> Any:
        lines.append(line)
        noted.set()
        return track_of(line, *rest)

    monkeypatch.setattr(ttm_child, "own_ships", own_ships)
    monkeypatch.setattr(ttm_child, "track_of", told)
    yield lines
    noted.set()  # where nothing was heard: the thread of the feed does not outlive the test


def answers(code: str, *words: str) -> list[dict[str, Any]]:
    feed = ttm("01", "1.0", "90.0", "T", "1.0", "0.0", "T").strip()
    lines = [json.dumps({"video": {"feed": feed, "address": "x"}}), json.dumps({"scan": 3, "time": 10.0})]
    ttm_child.serve([sys.executable, "-c", code, "{feed}", *words], iter(lines), written := io.StringIO())
    return [json.loads(line) for line in written.getvalue().splitlines()]


@pytest.mark.parametrize(
    "code",
    [
        "while True: print(sys.argv[1], flush=True)",
        "import os\nos.close(1)\ns, to = socket.socket(type=socket.SOCK_DGRAM), ('127.0.0.1', int(sys.argv[2]))\n"
        "while True: s.sendto(b'', to), s.sendto(sys.argv[1].encode(), to)",
    ],
)
def test_a_program_is_started_with_the_addresses_and_answers_each_scan(code: str, heard: list[str]) -> None:
    (answer,) = answers(f"import socket, sys\n{code}", "{udp}")
    assert (answer["scan"], [state["track"] for state in answer["tracks"]]) == (3, ["01"]) and heard


def test_a_program_that_ends_is_told(heard: list[str]) -> None:
    with pytest.raises(RuntimeError, match="the program has ended, exit status 7"):
        answers("raise SystemExit(7)")


def test_a_program_that_writes_no_line_and_leaves_a_child_is_bounded(tmp_path: Path, heard: list[str]) -> None:
    """The child, which has its output too, lives on: nobody waits for the end of that."""
    child = "open(sys.argv[2], 'w').write(str(subprocess.Popen(['sleep', '60']).pid))"
    code = f"import subprocess, sys\n{child}\nwhile True: print('x' * 3000, end='', flush=True)"
    (answer,) = answers(code, str(file := tmp_path / "child"))
    assert answer["tracks"] == [] and {len(line) for line in heard} == {ttm_child.MAX_LINE}
    os.kill(int(file.read_text()), signal.SIGKILL)
