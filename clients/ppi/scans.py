"""Whole scans out of a feed, as arrays and as pictures."""

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.display.picture import picture_from_power
from radar_service.display.ppi import Ppi
from radar_service.stream import wire

from .client import FeedClient, FeedError

MAX_CELLS = 2**27  # azimuths x bins that a radar may claim: a gigabyte as complex64


def empty_ppi(hello: dict[str, Any]) -> Ppi:
    """A PPI for the spokes of that epoch. Raises FeedError where it would be too large."""
    encoding = hello["encoding"]
    azimuths, bins = int(hello["radar"]["azimuths"]), int(encoding["bins"])
    if azimuths * bins > MAX_CELLS:
        raise FeedError(
            f"the radar claims {azimuths} azimuths x {bins} bins; at most {MAX_CELLS} cells fit: ask for fewer bins"
        )
    dtype = np.dtype(wire.DTYPES[encoding["name"]])
    return Ppi(azimuths, bins, float(encoding["range_first_m"]), float(encoding["range_step_m"]), dtype)


class ReceivedScan:
    """One revolution, beginning at whatever azimuth came first; rows stand by azimuth index, row 0 looks north.

    ppi: the samples. time [s], heading, course [rad], speed [m/s] (A,), position (A, 2) [m]: NaN where no spoke came.
    """

    def __init__(self, hello: dict[str, Any], first: int) -> None:
        self.hello, self.first, self.reached = hello, first, first
        self.ppi = empty_ppi(hello)
        azimuths = len(self.ppi.number)
        self.time, self.heading, self.course, self.speed = (np.full(azimuths, np.nan) for _ in range(4))
        self.position = np.full((azimuths, 2), np.nan)
        self.blind = np.zeros(azimuths, dtype=np.bool_)

    @property
    def azimuths(self) -> int:
        """Spokes of a revolution."""
        return len(self.time)

    @property
    def end(self) -> int:
        """Number of the first spoke after this scan."""
        return self.first + self.azimuths

    @property
    def complete(self) -> bool:
        """Whether every azimuth of the revolution has come or is known to be lost."""
        return self.reached >= self.end

    @property
    def missing(self) -> int:
        """Azimuths that did not come."""
        return int((~self.ppi.filled).sum())

    @property
    def newest_heading(self) -> float:
        """Heading [rad] of own ship at the newest spoke."""
        return float(self.heading[np.argmax(self.ppi.number)])

    def add(self, message: dict[str, Any]) -> None:
        """Take what belongs to this scan out of a `spokes` or `gap` message."""
        first, count = int(message["first"]), int(message["count"])
        self.reached = max(self.reached, first + count)
        if message["type"] != "spokes":
            return
        numbers = first + np.arange(count)
        mine = (numbers >= self.first) & (numbers < self.end)
        rows = int(message["index"]) + np.arange(count)
        news = np.flatnonzero(mine)[self.ppi.add(rows[mine], wire.samples(message)[mine], numbers[mine])]
        into = rows[news]
        self.time[into] = np.asarray(message["time"])[news]
        self.heading[into] = wire.radians_from_turn(message["heading"])[news]
        self.course[into] = wire.radians_from_turn(message["course"])[news]
        self.speed[into] = np.asarray(message["speed"])[news]
        self.position[into] = np.asarray(message["position"])[news]
        self.blind[into] = np.asarray(message.get("blind") or [False] * count)[news]


class ScanCollector:
    """Whole scans out of messages, consecutive where nothing is lost between them, all of one epoch.

    scans: the last `keep` whole ones (None: all); done: how many there were; current: the one being collected, if any;
    restarts: how often a new epoch made what was there worthless.
    """

    def __init__(self, keep: int | None = None) -> None:
        self.scans: deque[ReceivedScan] = deque(maxlen=keep)
        self.done = self.restarts = 0
        self.current: ReceivedScan | None = None
        self._hello: dict[str, Any] | None = None
        self._after = 0

    @property
    def spokes(self) -> int:
        """Spokes accounted for, come or lost, in whole scans and the current one."""
        current = self.current.reached - self.current.first if self.current else 0
        return current + (self.done * self.azimuths if self.done else 0)

    @property
    def azimuths(self) -> int:
        """Spokes of a scan; 0 before the hello."""
        return int(self._hello["radar"]["azimuths"]) if self._hello else 0

    def take(self, message: dict[str, Any]) -> None:
        """Use a message. Raises FeedError for too large a scan; ValueError, TypeError, LookupError for nonsense."""
        if message["type"] == "hello":
            self._greet(message)
        elif message["type"] in ("spokes", "gap"):
            self._fill(message)

    def _greet(self, message: dict[str, Any]) -> None:
        if self._hello and self._hello["epoch"] == message["epoch"]:
            return
        if self.spokes:
            self.restarts += 1
        self.scans.clear()
        self.done, self.current, self._after, self._hello = 0, None, 0, message

    def _fill(self, message: dict[str, Any]) -> None:
        beyond = message["first"] + message["count"]
        while True:
            if self.current is None:
                start = max(message["first"], self._after)
                if message["type"] == "gap" or start >= beyond or self._hello is None:
                    return  # a scan begins with a spoke
                self.current = ReceivedScan(self._hello, start)
            self.current.add(message)
            if not self.current.complete:
                return
            self.scans.append(self.current)
            self.done, self._after, self.current = self.done + 1, self.current.end, None


async def collect_scans(
    client: FeedClient, scans: int, keep: int | None = None, progress: Callable[[int, int], None] | None = None
) -> ScanCollector:
    """A collector with at least `scans` whole scans of one epoch, of which it keeps the last `keep`.

    progress: told spokes accounted for and in all, after each message. Raises FeedError, as the client does.
    """
    collector = ScanCollector(keep)
    async for message in client.messages():
        try:
            collector.take(message)
        except (LookupError, TypeError, ValueError) as fault:
            raise FeedError(f"the radar sent a {message['type']} message that cannot be used: {fault!r}") from fault
        if progress and collector.azimuths:
            progress(collector.spokes, scans * collector.azimuths)
        if collector.done >= scans:
            break
    return collector


def power_from_samples(samples: NDArray[Any], encoding: dict[str, Any]) -> NDArray[np.float32]:
    """Power [W] of samples (..., N) in one of the untouched encodings; `encoding` is that table of the hello.

    Raises ValueError for u8: gain and clutter controls have changed it, so that it says brightness and not power.
    """
    return _POWERS[encoding["name"]](samples, encoding)


def _from_video(samples: NDArray[Any], encoding: dict[str, Any]) -> NDArray[np.float32]:
    raise ValueError("encoding u8 is brightness, not power; ask the radar for u8-log, f16, f32 or c64")


def _from_log(samples: NDArray[Any], encoding: dict[str, Any]) -> NDArray[np.float32]:
    level_db = encoding["offset_db"] + encoding["db_per_step"] * np.arange(256)
    power = 10.0 ** (level_db / 10.0)
    power[0] = 0.0
    watts: NDArray[np.float32] = power.astype(np.float32)[samples]
    return watts


def _from_db(samples: NDArray[Any], encoding: dict[str, Any]) -> NDArray[np.float32]:
    power: NDArray[np.float32] = np.power(np.float32(10.0), samples.astype(np.float32) / np.float32(10.0))
    return power


def _from_field(samples: NDArray[Any], encoding: dict[str, Any]) -> NDArray[np.float32]:
    power: NDArray[np.float32] = np.square(samples.real) + np.square(samples.imag)
    return power


_POWERS: dict[str, Callable[[NDArray[Any], dict[str, Any]], NDArray[np.float32]]] = {
    "u8": _from_video,
    "u8-log": _from_log,
    "f16": _from_db,
    "f32": lambda samples, encoding: samples.copy(),
    "c64": _from_field,
}


def power(ppi: Ppi, encoding: dict[str, Any]) -> NDArray[np.float32]:
    """Power [W] (A, N) of a picture in one of the untouched encodings, 0 where no spoke came."""
    watts = power_from_samples(ppi.polar, encoding)
    watts[~ppi.filled] = 0.0  # in f16 an empty row would read 0 dBW
    return watts


def brightness(scan: ReceivedScan, dynamic_range_db: float = 60.0, reference: float | None = None) -> NDArray[np.uint8]:
    """The scan as a picture (A, N) of 0 to 255; see `bright_cells`."""
    return bright_cells(scan.ppi, scan.hello["encoding"], dynamic_range_db, reference)


def bright_cells(
    ppi: Ppi, encoding: dict[str, Any], dynamic_range_db: float = 60.0, reference: float | None = None
) -> NDArray[np.uint8]:
    """A picture (A, N) of 0 to 255: u8 as it is, else decibels below `reference` [W], by default the strongest cell."""
    if encoding["name"] == "u8":
        return ppi.polar
    return picture_from_power(power(ppi, encoding), dynamic_range_db, reference)
