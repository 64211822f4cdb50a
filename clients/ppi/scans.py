"""Collects the messages of a feed into whole scans, and turns samples into power and brightness."""

import json
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service import wire
from radar_service.display.picture import picture_from_power
from radar_service.display.ppi import Ppi
from radar_service.wire import SpokeRows

from .client import FeedClient
from .errors import FeedError
from .spoke import label_names

MAX_CELLS = 2**27  # azimuths x bins that a hello may announce: a gigabyte as complex64


def empty_ppi(hello: dict[str, Any]) -> Ppi:
    """Returns an empty PPI for the spokes of this epoch. Raises FeedError if it has more than MAX_CELLS cells."""
    encoding = hello["encoding"]
    azimuths, bins = int(hello["radar"]["azimuths"]), int(encoding["bins"])
    if azimuths * bins > MAX_CELLS:
        raise FeedError(
            f"the radar has {azimuths} azimuths x {bins} bins; at most {MAX_CELLS} cells are accepted: request fewer bins"
        )
    dtype = np.dtype(wire.DTYPES[encoding["name"]])
    return Ppi(azimuths, bins, float(encoding["range_first_m"]), float(encoding["range_step_m"]), dtype)


class ReceivedScan:
    """One revolution, which may begin at any azimuth. Row k holds azimuth k; row 0 points north.

    hello: of its epoch.
    first: number of its first spoke.
    reached: number after the newest spoke, received or lost.
    ppi: the samples.
    time: (A,) [s], NaN without a spoke, as the next four.
    heading, course: (A,) of own ship [rad].
    speed: (A,) of own ship [m/s].
    position: (A, 2) of own ship [m].
    blind: (A,) whether the radar did not transmit.
    labels: (A, N) number of the strongest source, 0 without a spoke; None where no spoke has them.
    """

    def __init__(self, hello: dict[str, Any], first: int) -> None:
        self.hello, self.first, self.reached = hello, first, first
        self.ppi = empty_ppi(hello)
        azimuths = len(self.ppi.number)
        self.time, self.heading, self.course, self.speed = (np.full(azimuths, np.nan) for _ in range(4))
        self.position = np.full((azimuths, 2), np.nan)
        self.blind = np.zeros(azimuths, dtype=np.bool_)
        self.labels: NDArray[np.uint32] | None = None

    @property
    def azimuths(self) -> int:
        """Spokes in a revolution."""
        return len(self.time)

    @property
    def end(self) -> int:
        """Number of the first spoke after this scan."""
        return self.first + self.azimuths

    @property
    def complete(self) -> bool:
        """Whether every azimuth of the revolution has arrived or is announced as lost."""
        return self.reached >= self.end

    @property
    def missing(self) -> int:
        """Azimuths without a spoke."""
        return int((~self.ppi.filled).sum())

    @property
    def newest_heading(self) -> float:
        """Heading [rad] of own ship at the newest spoke that has one; NaN where the radar has lost it all the time."""
        return float(self.heading[np.argmax(np.where(np.isnan(self.heading), -1, self.ppi.number))])

    def add(self, message: dict[str, Any]) -> None:
        """Adds the part of a `spokes` or `gap` message that belongs to this scan."""
        first, count = int(message["first"]), int(message["count"])
        self.reached = max(self.reached, first + count)
        if message["type"] != "spokes":
            return
        rows = SpokeRows.of(message)
        inside = (rows.number >= self.first) & (rows.number < self.end)
        new = np.flatnonzero(inside)[self.ppi.add(rows.index[inside], rows.samples[inside], rows.number[inside])]
        row = rows.index[new]
        self.time[row], self.speed[row], self.position[row] = rows.time[new], rows.speed[new], rows.position[new]
        self.heading[row], self.course[row], self.blind[row] = rows.heading[new], rows.course[new], rows.blind[new]
        if rows.labels is not None:
            self.labels = np.zeros(self.ppi.polar.shape, dtype=np.uint32) if self.labels is None else self.labels
            self.labels[row] = rows.labels[new]


class ScanCollector:
    """Collects messages into whole scans of one epoch. Scans follow each other without a gap unless spokes are lost.

    scans: the last `keep` whole scans (None: all). done: number of whole scans. current: the unfinished scan, if any.
    restarts: how often a new epoch discarded spokes.
    """

    def __init__(self, keep: int | None = None) -> None:
        self.scans: deque[ReceivedScan] = deque(maxlen=keep)
        self.done = self.restarts = 0
        self.current: ReceivedScan | None = None
        self._hello: dict[str, Any] | None = None
        self._after = 0

    @property
    def spokes(self) -> int:
        """Spokes, received or lost, in whole scans and in the current one."""
        current = self.current.reached - self.current.first if self.current else 0
        return current + (self.done * self.azimuths if self.done else 0)

    @property
    def azimuths(self) -> int:
        """Spokes in a scan; 0 before the hello."""
        return int(self._hello["radar"]["azimuths"]) if self._hello else 0

    def take(self, message: dict[str, Any]) -> None:
        """Adds a message. Raises FeedError if the scan is too large; ValueError, TypeError or LookupError if it is invalid."""
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
        end = message["first"] + message["count"]
        while True:
            if self.current is None:
                start = max(message["first"], self._after)
                if message["type"] == "gap" or start >= end or self._hello is None:
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
    """Receives until `scans` scans of one epoch are whole; returns the collector, which keeps the last `keep` of them.

    progress: called after each message with the number of spokes so far and in all. Raises FeedError as the client does.
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
    """Returns the power [W] of samples (..., N). `encoding` is the table of that name in the hello.

    Raises ValueError for u8: it is brightness, which depends on the gain and clutter controls.
    """
    watts: NDArray[np.float32]
    match encoding["name"]:
        case "u8-log":
            level_db = encoding["offset_db"] + encoding["db_per_step"] * np.arange(256)
            level_db[0] = -np.inf
            watts = (10.0 ** (level_db / 10.0)).astype(np.float32)[samples]
        case "f16":
            watts = np.power(np.float32(10.0), samples.astype(np.float32) / np.float32(10.0))
        case "f32":
            watts = samples.copy()
        case "c64":
            watts = np.square(samples.real) + np.square(samples.imag)
        case name:
            raise ValueError(f"encoding {name} is brightness, not power; request u8-log, f16, f32 or c64")
    return watts


def power(ppi: Ppi, encoding: dict[str, Any]) -> NDArray[np.float32]:
    """Returns the power [W] (A, N) of a picture, 0 without a spoke. Raises ValueError for u8."""
    watts = power_from_samples(ppi.polar, encoding)
    watts[~ppi.filled] = 0.0  # an empty row of f16 would mean 0 dBW
    return watts


def brightness(scan: ReceivedScan, dynamic_range_db: float = 60.0) -> NDArray[np.uint8]:
    """Returns the brightness (A, N) of a scan, 0 to 255; see `bright_cells`."""
    return bright_cells(scan.ppi, scan.hello["encoding"], dynamic_range_db)


def bright_cells(ppi: Ppi, encoding: dict[str, Any], dynamic_range_db: float = 60.0) -> NDArray[np.uint8]:
    """Returns brightness (A, N), 0 to 255: u8 unchanged, else linear in decibels, 255 for the strongest cell.

    dynamic_range_db: from brightness 255 down to 0.
    """
    if encoding["name"] == "u8":
        return ppi.polar
    return picture_from_power(power(ppi, encoding), dynamic_range_db)


def arrays(scans: Sequence[ReceivedScan]) -> dict[str, Any]:
    """Scans, all of one epoch, as the arrays of a file of scans (`radar_service.scans.file`).

    power where the encoding tells it, field where it is c64, and samples where they are neither.
    """
    ppi, encoding = scans[0].ppi, scans[0].hello["encoding"]
    azimuths, bins = ppi.polar.shape
    of_spokes = ("time", "heading", "course", "speed", "position", "blind")
    spoke = np.stack([scan.ppi.number for scan in scans])
    return {
        **{name: np.stack([getattr(scan, name) for scan in scans]) for name in of_spokes},
        **_received(np.stack([scan.ppi.polar for scan in scans]), spoke < 0, encoding),
        "number": np.array([scan.first // azimuths for scan in scans]),
        "spoke": spoke,
        "azimuth": np.arange(azimuths) * (2.0 * np.pi / azimuths),
        "range": ppi.range_first + np.arange(bins) * ppi.range_step,
        "range_step": np.array(ppi.range_step),
        "name": np.array(scans[0].hello["scene"]["name"]),
        "hello": np.array(json.dumps(scans[0].hello, default=str)),
        **_labels(scans),
    }


def _labels(scans: Sequence[ReceivedScan]) -> dict[str, Any]:
    """The labels (S, A, N), and the table of sources; none where no scan has them."""
    if all(scan.labels is None for scan in scans):
        return {}
    names = label_names(scans[0].hello)
    nothing = np.zeros(scans[0].ppi.polar.shape, dtype=np.uint32)
    return {
        "labels": np.stack([nothing if scan.labels is None else scan.labels for scan in scans]),
        "label_numbers": np.array(list(names), dtype=np.uint32), "label_names": np.array(list(names.values())),
    }  # fmt: skip


def _received(samples: NDArray[Any], missing: NDArray[np.bool_], encoding: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """samples (S, A, N) as power, field or samples; NaN where they are `missing` (S, A)."""
    result: dict[str, NDArray[Any]] = {}
    if encoding["name"] != "u8":
        result["power"] = power_from_samples(samples, encoding)
    if encoding["name"] == "c64":
        result["field"] = samples
    for watts_or_field in result.values():
        watts_or_field[missing] = np.nan
    return result if encoding["name"] in ("f32", "c64") else result | {"samples": samples}
