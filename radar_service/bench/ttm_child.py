"""A radar plotter of others under test, unmodified: `python -m radar_service.bench.ttm_child PROGRAM ...`.

The program writes NMEA 0183 to its standard output, or sends it to `{udp}`, a port of this machine; its TTM are the tracks, or
its TLL, where it writes no TTM and the scene has an origin.
`{feed}` and `{address}` in its arguments stand for those of the radar, which turns in real time.
"""

import json
import math
import re
import secrets
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial, reduce
from socket import AF_INET, SOCK_DGRAM, socket
from threading import Condition, Thread
from typing import IO, Any, TextIO

from radar_service.numerics import NAUTICAL_MILE
from radar_service.radar_feed import OwnShip, own_ships
from radar_service.world import Origin, map_from_geographic

SENTENCE = re.compile(r"\$([A-Z]{2}(TTM|TLL),([ -~]*))\*([0-9A-F]{2})")
TREND = 60.0  # s over which places make a velocity: MSC.192(79) 5.25.4 asks for the trend of motion after a minute
METRES = {"N": NAUTICAL_MILE, "K": 1000.0, "S": 1609.344}
MAX_LINE = 1000  # characters of a line of a program, or of a part of it; a sentence has 82
MAX_DATAGRAM = 65536
LAST_WORDS = 1.0  # s for what a program has written: what it leaves behind may hold its output open
WAIT_SECONDS = 50.0  # for the end of a scan, of the minute that an answer may take


def track_of(line: str, own: OwnShip, origin: Origin | None = None) -> tuple[str, dict[str, Any] | None] | None:
    """Returns the number and the state of a TTM or TLL, None for a lost one; None for all else. Bearings and courses of "R" count
    from the bow and are relative. A TLL, which needs an origin, has no velocity. Raises ValueError and KeyError."""
    form = SENTENCE.fullmatch(line.strip())
    if form is None or reduce(lambda total, byte: total ^ byte, form[1].encode(), 0) != int(form[4], 16):
        return None
    if form[2] == "TLL":
        number, latitude, south, longitude, west, _, _, status, *_ = form[3].split(",")
        if status != "T" or not origin:
            return (number, None) if status == "L" else None
        east, north = map_from_geographic(_degrees(latitude, south), _degrees(longitude, west), origin).tolist()
        return number, {"track": number, "time": own["time"], "east": east, "north": north}
    number, distance, bearing, bearing_of, speed, course, course_of, _, _, unit, _, status, *_ = form[3].split(",")
    if status != "T" or not (distance and bearing and speed and course):
        return (number, None) if status == "L" else None
    turn = math.radians(float(bearing)) + (own["heading"] if bearing_of == "R" else 0.0)
    way, place, ahead = float(speed) * METRES[unit] / 3600.0, float(distance) * METRES[unit], math.radians(float(course))
    east, north = way * math.sin(ahead), way * math.cos(ahead)
    if course_of == "R":
        east, north = east + own["speed"] * math.sin(own["course"]), north + own["speed"] * math.cos(own["course"])
    return number, {
        "track": number, "time": own["time"], "velocity_east": east, "velocity_north": north,
        "east": own["east"] + place * math.sin(turn), "north": own["north"] + place * math.cos(turn),
    }  # fmt: skip


def _degrees(text: str, side: str) -> float:
    """Degrees of the two last digits before the point, which are minutes, and of those before them."""
    degrees, minutes = divmod(float(text), 100.0)
    return math.copysign(degrees + minutes / 60.0, -1.0 if side in ("S", "W") else 1.0)


class Plotter:
    """Tracks of a program's sentences, and own ship of the feed. origin: of the scene, which TLL need."""

    def __init__(self, origin: Origin | None = None) -> None:
        self._changed, self._own, self._ended, self._origin = Condition(), dict[str, float](time=-1.0), "", origin
        self._tracks: dict[str, dict[str, Any]] = {}
        self._places: dict[str, list[dict[str, Any]]] = {}  # of TLL

    def follow(self, ships: Iterable[OwnShip]) -> None:
        """Takes own ship as time goes on."""
        try:
            for own in ships:
                with self._changed:
                    self._own = dict(own)
                    self._changed.notify_all()
        finally:
            self.end("the feed has ended")

    def listen(self, lines: Iterable[str]) -> None:
        """Takes the sentences of the program, by one of its ways."""
        for line in lines:
            with self._changed, suppress(ValueError, KeyError):  # of a sentence that is not understood
                if self._own["time"] >= 0.0 and (report := track_of(line, self._own, self._origin)):
                    self._take(*report)

    def _take(self, number: str, state: dict[str, Any] | None) -> None:
        """Takes a state; that of a TLL has the mean velocity of the last minute, and does not replace one of a TTM."""
        earlier, places = self._tracks.pop(number, None), self._places.pop(number, [])
        if state and "velocity_east" not in state and earlier and not places:
            state = earlier
        elif state and "velocity_east" not in state:
            recent = [place for place in (*places, state) if place["time"] >= state["time"] - TREND]
            span = state["time"] - recent[0]["time"] or math.inf
            state = state | {f"velocity_{axis}": (state[axis] - recent[0][axis]) / span for axis in ("east", "north")}
            self._places[number] = recent
        self._tracks |= {number: state} if state else {}

    def end(self, why: str) -> None:
        """Ends the wait for the radar."""
        with self._changed:
            self._ended = self._ended or why
            self._changed.notify_all()

    def tracks(self, time: float) -> list[dict[str, Any]]:
        """Returns the newest state of each track at the end of a scan [s], for which it waits. Raises RuntimeError."""
        with self._changed:
            self._changed.wait_for(lambda: self._own["time"] >= time or self._ended, WAIT_SECONDS)
            if self._own["time"] < time:
                raise RuntimeError(self._ended or f"the radar has not turned on for {WAIT_SECONDS:g} s")
            return [{**state, "time": min(state["time"], time)} for state in self._tracks.values()]


def serve(words: Sequence[str], lines: Iterator[str], answers: TextIO) -> None:
    """Answers each scan of some lines, of which the first one is the header. Raises RuntimeError and OSError."""
    video = json.loads(next(lines))["video"]
    plotter, port = Plotter(video.get("origin")), socket(AF_INET, SOCK_DGRAM)
    port.bind(("127.0.0.1", 0))
    places = {"{feed}": video["feed"], "{address}": video["address"], "{udp}": str(port.getsockname()[1])}
    command = [reduce(lambda word, key: word.replace(key, places[key]), places, word) for word in words]
    program = subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True, errors="replace")
    assert program.stdout is not None
    Thread(target=plotter.follow, args=(own_ships(video["feed"]),), daemon=True).start()
    last = secrets.token_bytes()
    ways = _written(program.stdout), _sent(port, last)
    listening = [Thread(target=plotter.listen, args=(lines_of,), daemon=True) for lines_of in ways]

    def watch() -> None:
        status = program.wait()
        listening[0].join(LAST_WORDS)
        plotter.end(f"the program has ended, exit status {status}")

    for thread in (*listening, Thread(target=watch, daemon=True)):
        thread.start()
    try:
        for scan in map(json.loads, lines):
            answer = {"type": "tracks", "scan": scan["scan"], "tracks": plotter.tracks(scan["time"])}
            print(json.dumps(answer), file=answers, flush=True)
    finally:
        program.kill()
        program.wait()
        port.sendto(last, port.getsockname())
        for thread in listening:
            thread.join(LAST_WORDS)


def _written(output: IO[str]) -> Iterator[str]:
    """Yields the lines of a program."""
    with output:
        yield from iter(partial(output.readline, MAX_LINE), "")


def _sent(port: socket, last: bytes) -> Iterator[str]:
    """Yields the lines of datagrams before the last one."""
    while (data := port.recv(MAX_DATAGRAM)) != last:
        yield from data.decode("ascii", "replace").splitlines()
    port.close()


if __name__ == "__main__":
    serve(sys.argv[1:], iter(sys.stdin), sys.stdout)
