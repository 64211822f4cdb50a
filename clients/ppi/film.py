"""Received scans as a film: the beam turns, and echoes fade until it returns."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.display.picture import picture_from_power

from .errors import FeedError
from .scans import ReceivedScan, power

AFTERGLOW = 0.6  # brightness left after one revolution: the beam's position shows, and old echoes stay readable

ROUNDING = 1e-6  # of a turn: a spoke at exactly the time of a frame belongs to it
MAX_FRAMES = 20_000  # half an hour at 10 a second


class Frame(NamedTuple):
    """One picture: brightness (A, N) of 0 to 255, which rows hold a spoke (A,), heading [rad] (NaN: none yet),
    simulated time [s]."""

    picture: NDArray[np.uint8]
    filled: NDArray[np.bool_]
    heading: float
    time: float


def film(scans: list[ReceivedScan], fps: int, dynamic_range_db: float = 60.0) -> Iterator[Frame]:
    """Yields the frames of scans of one epoch. One second of film shows one second of simulated time.

    dynamic_range_db: range of levels that is shown, below the strongest cell of all scans; u8 video ignores it.
    Raises FeedError for more than MAX_FRAMES frames.
    """
    bright = _bright(scans, dynamic_range_db)
    time, scan, row = _order(scans)
    duration = float(time[-1] - time[0])
    scan_period = duration / max(1, len(time) - 1) * scans[0].azimuths or 1.0
    drawn, drawn_at, done = np.zeros_like(bright[0]), np.full(scans[0].azimuths, -np.inf), 0
    count, heading = max(1, int(np.ceil(duration * fps))), float("nan")
    if count > MAX_FRAMES:
        raise FeedError(f"a film of {count} frames; at most {MAX_FRAMES} are made: ask for fewer scans or frames per second")
    for now in time[-1] - np.arange(count)[::-1] / fps:
        due = int(np.searchsorted(time, now + scan_period * ROUNDING, side="right"))
        for n in range(done, due):
            drawn[row[n]], drawn_at[row[n]] = bright[scan[n]][row[n]], time[n]
        done, newest = due, max(0, due - 1)
        reported = float(scans[scan[newest]].heading[row[newest]])
        heading = heading if np.isnan(reported) else reported
        yield Frame(faded(drawn, (now - drawn_at) / scan_period), np.isfinite(drawn_at), heading, float(now))


def faded(drawn: NDArray[np.uint8], age: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Returns the brightness (A, N) of rows whose age is `age` (A,) revolutions."""
    factor = 1.0 - (1.0 - AFTERGLOW) * np.clip(age, 0.0, 1.0)
    dimmed: NDArray[np.uint8] = np.rint(drawn * factor[:, None].astype(np.float32)).astype(np.uint8)
    return dimmed


def _bright(scans: list[ReceivedScan], dynamic_range_db: float) -> list[NDArray[np.uint8]]:
    """The brightness (A, N) of each scan, all on one scale."""
    encoding = scans[0].hello["encoding"]
    if encoding["name"] == "u8":
        return [scan.ppi.polar for scan in scans]
    strongest = max(float(power(scan.ppi, encoding).max()) for scan in scans)
    return [picture_from_power(power(scan.ppi, encoding), dynamic_range_db, strongest) for scan in scans]


def _order(scans: list[ReceivedScan]) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.intp]]:
    """Time [s], scan and row (K,) of each received spoke, in the order of their numbers."""
    number = np.stack([scan.ppi.number for scan in scans])
    order = np.argsort(number, axis=None, kind="stable")[int((number < 0).sum()) :]
    scan, row = np.unravel_index(order, number.shape)
    return np.stack([scan.time for scan in scans])[scan, row], scan, row
