"""Trackers of any language: they take plots and give tracks as JSON Lines, whichever way the lines go (docs/bench.md)."""

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from threading import Thread
from typing import Any, TypeVar

from radar_service.bench.trackers.tracker import TrackerInput, TrackState
from radar_service.plots import Plot
from radar_service.terminal import UsageError

ANSWER_SECONDS = 60.0  # that a tracker may take for one scan
MAX_LINE = 2**24  # characters of an answer
MAX_TRACKS = 1000  # of an answer: metrics compare each with each target
MAX_NAME = 100  # characters of a track's name
MAX_VALUE = 1e9  # m, m/s and s: the square of a larger one may overflow
MAX_PLOTS = 10_000  # of an answer
PLOT_KEYS = ("time", "range", "bearing")
KEYS = ("time", "east", "north", "velocity_east", "velocity_north")
NUMBERS, FLAGS = ("cpa", "tcpa"), ("coasting", "alarm", "lost", "full")  # that it may have
WORDS = {"priority": ("ais", "radar"), "acquired": ("automatic", "manual")}  # that it may have too
T = TypeVar("T")


class TrackerError(UsageError):
    """A tracker that ended, did not answer in time or answered rubbish. Its text says which."""


class TrackerHangs(TrackerError):
    """A tracker that took or gave nothing in time."""


class LineTracker(ABC):
    """A tracker.Tracker behind lines of JSON (docs/bench.md). `close` ends it."""

    def __init__(self, name: str, timeout: float) -> None:
        """name: for messages; timeout: for each line, there and back [s]."""
        self.name, self.timeout = name, timeout
        self.end = "has ended"  # what has become of it, where it takes or gives no more
        self._sending: Thread | None = None
        self._fault: Exception | None = None
        self.again = False  # whether the first answer asks for further headers

    def begin(self, header: Mapping[str, Any]) -> None:
        """Sends the header; ends the tracker where it does not take it. Raises TrackerError."""
        try:
            self.send({"type": "header", **header})
        except BaseException:
            self.close()
            raise

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Returns the tracks after a scan, as Tracker.update. Raises TrackerError."""
        self.send(scan.as_dict())
        line = self.answer(scan.scan)
        tracks = tracks_from_line(line, scan.scan)
        if scan.scan == 0:
            self.again = json.loads(line).get("again") is True
        return tracks

    def plots(self, scan: TrackerInput) -> tuple[Plot, ...]:
        """Returns the plots of an extractor in a scan of the video. Raises TrackerError."""
        self.send(scan.as_dict())
        return plots_from_line(self.answer(scan.scan), scan)

    def send(self, message: Mapping[str, Any]) -> None:
        """Sends one line, from a thread of its own: a tracker that reads nothing would block this one for ever. Raises
        TrackerError."""
        line = json.dumps(message, allow_nan=False)
        self._sending = Thread(target=self._write, args=(line,), name="plots for a tracker", daemon=True)
        self._sending.start()
        self._sending.join(self.timeout)
        if self.is_stuck:
            raise TrackerHangs(f"tracker: {self.name!r} read no plots for {self.timeout:g} s")
        if self._fault is not None:
            raise TrackerError(f"tracker: {self.name!r} {self.end} and takes no more plots") from self._fault

    @property
    def is_stuck(self) -> bool:
        """Whether a line is still not taken."""
        return self._sending is not None and self._sending.is_alive()

    def _write(self, line: str) -> None:
        try:
            self.write(line)
        except Exception as error:  # raised by `send`, in the caller's thread
            self._fault = error

    @abstractmethod
    def write(self, line: str) -> None:
        """Writes one line without its end; raises any error where the tracker has gone."""

    @abstractmethod
    def answer(self, scan: int) -> str:
        """Returns the next line of the tracker, which answers a scan. Raises TrackerError."""

    @abstractmethod
    def close(self) -> None:
        """Ends the tracker, or the connection to it."""

    def finish(self) -> None:
        """Ends a run that went well."""
        self.close()

    @property
    def status(self) -> int | None:
        """The exit status of a program that has ended, negative for a signal; None where there is none."""
        return None

    @property
    def memory(self) -> int | None:
        """Memory of a program [bytes]; None where nobody knows. Raises TrackerError."""
        return None

    @property
    def last_line(self) -> str:
        """What a program has last written to its standard error; "" where there is nothing."""
        return ""

    def silent(self, scan: int) -> TrackerError:
        """Returns the error of a tracker that does not answer in time."""
        return TrackerHangs(f"tracker: no answer (a line, flushed) to scan {scan} within {self.timeout:g} s")


def tracks_from_line(line: str, scan: int) -> tuple[TrackState, ...]:
    """Returns the tracks of one answer. Raises TrackerError where it is none, or that to another scan."""
    tracks = _records(line, scan, "tracks", MAX_TRACKS, _state)
    if len({track.track for track in tracks}) < len(tracks):
        raise TrackerError(f"tracker: the answer to scan {scan} names a track twice")
    return tracks


def plots_from_line(line: str, scan: TrackerInput) -> tuple[Plot, ...]:
    """Returns the plots of one answer of an extractor. Raises TrackerError where it is none, or that to another scan."""
    return _records(line, scan.scan, "plots", MAX_PLOTS, partial(_plot, scan))


def _records(line: str, scan: int, key: str, most: int, record: Callable[[Any], T]) -> tuple[T, ...]:
    """The records of one answer, which has them under its type."""
    try:
        answer = json.loads(line)
        if answer["type"] != key or answer["scan"] != scan:
            raise TrackerError(
                f"tracker: the answer to scan {scan} has type {_shown(answer['type'])}, scan {_shown(answer['scan'])}"
            )
        if len(answer[key]) > most:
            raise TrackerError(f"tracker: the answer to scan {scan} has {len(answer[key])} {key}; at most {most}")
        return tuple(map(record, answer[key]))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise TrackerError(
            f"tracker: the answer to scan {scan} is not understood ({_shown(error)}): {line[:80]!r}"
        ) from None


def _shown(value: object) -> str:
    """A value of a stranger in a message, which stays one line of fair length."""
    return repr(value)[:200]


def _state(track: Mapping[str, Any]) -> TrackState:
    name = track["track"]
    if not isinstance(name, str | int) or len(str(name)) > MAX_NAME:
        raise ValueError(f"track is {_shown(name)}; a name of at most {MAX_NAME} characters, or a whole number, is needed")
    values: dict[str, Any] = _numbers(track, (*KEYS, *(key for key in NUMBERS if track.get(key) is not None)))
    flags: dict[str, Any] = {key: track[key] for key in FLAGS if track.get(key) is not None}
    for key, flag in flags.items():
        if not isinstance(flag, bool):
            raise ValueError(f"{key} is {_shown(flag)}; true or false is needed")
    mmsi = track.get("mmsi")
    words: dict[str, Any] = {key: track.get(key) for key in WORDS}
    if mmsi is not None and (not isinstance(mmsi, int) or isinstance(mmsi, bool) or not 0 < mmsi < 1e9):
        raise ValueError(f"mmsi is {_shown(mmsi)}; a whole number of nine digits at most is needed")
    for key, word in words.items():
        if word is not None and word not in WORDS[key]:
            raise ValueError(f"{key} is {_shown(word)}; {' or '.join(WORDS[key])} is needed")
    return TrackState(track=str(name), **values, **flags, mmsi=mmsi, **words)


def _numbers(record: Mapping[str, Any], keys: Sequence[str]) -> dict[str, float]:
    values = {key: float(record[key]) for key in keys}
    for key, value in values.items():
        if not math.isfinite(value):
            raise ValueError(f"{key} is {value}; a finite number is needed")
        if abs(value) > MAX_VALUE:
            raise ValueError(f"{key} is {value:g}; at most {MAX_VALUE:g} is needed")
    return values


def _plot(scan: TrackerInput, plot: Mapping[str, Any]) -> Plot:
    """A plot of an extractor, which needs no keys but PLOT_KEYS. scan: with own ship, about which it is drawn."""
    values = _numbers(plot, PLOT_KEYS)
    place, turn = values["range"], values["bearing"]
    return Plot(
        scan=scan.scan, time=values["time"], range=place, bearing=turn, east=scan.east + place * math.sin(turn),
        north=scan.north + place * math.cos(turn), snr_db=0.0, cells=1, range_extent=(place, place), bearing_extent=(turn, turn),
    )  # fmt: skip
