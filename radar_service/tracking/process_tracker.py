"""Trackers of any language: another program takes plots and gives tracks as JSON Lines, on its standard input and output."""

import json
import math
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from queue import Empty, Queue
from threading import Thread
from typing import Any

from radar_service.tracking.tracker import TrackerInput, TrackState

ANSWER_SECONDS = 60.0  # that a tracker may take for one scan
MAX_LINE = 2**24  # characters of an answer
KEYS = ("time", "east", "north", "velocity_east", "velocity_north")


class TrackerError(Exception):
    """A tracker that ended, did not answer in time or answered rubbish. Its text says which."""


class ProcessTracker:
    """A tracker.Tracker that another program is. `close` ends the program.

    It gets one line with `type` "header", then one with `type` "scan" for each scan (TrackerInput.as_dict). To each scan it
    answers with one line: {"type": "tracks", "scan": its number, "tracks": [{"track", "time", "east", "north",
    "velocity_east", "velocity_north"}]}.
    """

    def __init__(self, command: str, header: Mapping[str, Any], timeout: float = ANSWER_SECONDS) -> None:
        """command: as a shell splits it, but without a shell; timeout: for each answer [s]. Raises TrackerError."""
        self._command, self._timeout = command, timeout
        try:
            self._process = subprocess.Popen(
                shlex.split(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", errors="replace"
            )
        except (OSError, ValueError) as error:
            raise TrackerError(f"tracker: {command!r} could not be started: {error}") from None
        self._answers: Queue[str] = Queue()
        Thread(target=self._read, name="tracker's answers", daemon=True).start()
        self._send({"type": "header", **header})

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Returns the tracks after a scan, as Tracker.update. Raises TrackerError."""
        self._send(scan.as_dict())
        try:
            line = self._answers.get(timeout=self._timeout)
        except Empty:
            raise TrackerError(f"tracker: no answer to scan {scan.scan} within {self._timeout:g} s") from None
        if not line:
            raise TrackerError(f"tracker: {self._command!r} ended before it answered scan {scan.scan}")
        return tracks_from_line(line, scan.scan)

    def close(self) -> None:
        """Ends the program."""
        with suppress(OSError):
            if self._process.stdin:
                self._process.stdin.close()
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _send(self, message: Mapping[str, Any]) -> None:
        assert self._process.stdin
        try:
            self._process.stdin.write(json.dumps(message, allow_nan=False) + "\n")
            self._process.stdin.flush()
        except OSError:
            raise TrackerError(f"tracker: {self._command!r} has ended and takes no more plots") from None

    def _read(self) -> None:
        assert self._process.stdout
        with self._process.stdout as output:
            while line := output.readline(MAX_LINE):
                self._answers.put(line)
        self._answers.put("")


def tracks_from_line(line: str, scan: int) -> tuple[TrackState, ...]:
    """Returns the tracks of one answer. Raises TrackerError where it is none, or that to another scan."""
    try:
        answer = json.loads(line)
        if answer["type"] != "tracks" or answer["scan"] != scan:
            raise TrackerError(f"tracker: the answer to scan {scan} has type {answer['type']!r}, scan {answer['scan']!r}")
        tracks = tuple(_state(track) for track in answer["tracks"])
    except (ValueError, KeyError, TypeError) as error:
        raise TrackerError(f"tracker: the answer to scan {scan} is not understood ({error!r}): {line[:80]!r}") from None
    if len({track.track for track in tracks}) < len(tracks):
        raise TrackerError(f"tracker: the answer to scan {scan} names a track twice")
    return tracks


def _state(track: Mapping[str, Any]) -> TrackState:
    values = {key: float(track[key]) for key in KEYS}
    for key, value in values.items():
        if not math.isfinite(value):
            raise ValueError(f"{key} is {value}; a finite number is needed")
    return TrackState(track=str(track["track"]), **values)
