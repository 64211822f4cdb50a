"""Received scans as a film: the beam goes round, and what it has drawn fades until it comes back."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .client import FeedError
from .scans import ReceivedScan, brightness, power

AFTERGLOW = 0.6  # of its brightness is left to an echo a revolution old: the beam's place shows, old echoes stay readable

ROUNDING = 1e-6  # of a turn: a spoke due at a frame's very moment is on it
MAX_FRAMES = 20_000  # half an hour at 10 a second


class Frame(NamedTuple):
    """The picture at one moment: brightness (A, N) of 0 to 255, rows that have been drawn (A,), heading [rad], time [s]."""

    picture: NDArray[np.uint8]
    filled: NDArray[np.bool_]
    heading: float
    time: float


def film(scans: list[ReceivedScan], fps: int, dynamic_range_db: float = 60.0) -> Iterator[Frame]:
    """Frames of scans (all of one epoch), a second of film for a second of simulation; the last one has the last spoke.

    dynamic_range_db: of what is not u8, below the strongest cell of all the scans.
    """
    bright = _bright(scans, dynamic_range_db)
    time, scan, row = _order(scans)
    lasted = float(time[-1] - time[0])
    turn = lasted / max(1, len(time) - 1) * scans[0].azimuths or 1.0
    drawn, since, done = np.zeros_like(bright[0]), np.full(scans[0].azimuths, -np.inf), 0
    count = max(1, int(np.ceil(lasted * fps)))
    if count > MAX_FRAMES:
        raise FeedError(f"a film of {count} frames; at most {MAX_FRAMES} are made: ask for fewer scans or frames per second")
    for now in time[-1] - np.arange(count)[::-1] / fps:
        upto = int(np.searchsorted(time, now + turn * ROUNDING, side="right"))
        for n in range(done, upto):
            drawn[row[n]], since[row[n]] = bright[scan[n]][row[n]], time[n]
        done, newest = upto, max(0, upto - 1)
        heading = float(scans[scan[newest]].heading[row[newest]])
        yield Frame(faded(drawn, (now - since) / turn), np.isfinite(since), heading, float(now))


def faded(drawn: NDArray[np.uint8], age: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Brightness (A, N) of rows (A,) so many revolutions old."""
    share = 1.0 - (1.0 - AFTERGLOW) * np.clip(age, 0.0, 1.0)
    dimmer: NDArray[np.uint8] = np.rint(drawn * share[:, None].astype(np.float32)).astype(np.uint8)
    return dimmer


def _bright(scans: list[ReceivedScan], dynamic_range_db: float) -> list[NDArray[np.uint8]]:
    """The brightness (A, N) of each scan, on one scale."""
    encoding = scans[0].hello["encoding"]
    strongest = None if encoding["name"] == "u8" else max(float(power(scan.ppi, encoding).max()) for scan in scans)
    return [brightness(scan, dynamic_range_db, strongest) for scan in scans]


def _order(scans: list[ReceivedScan]) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.intp]]:
    """Time [s], scan and row (K,) of each spoke that came, as they were sent."""
    number = np.stack([scan.ppi.number for scan in scans])
    order = np.argsort(number, axis=None, kind="stable")[int((number < 0).sum()) :]
    scan, row = np.unravel_index(order, number.shape)
    return np.stack([scan.time for scan in scans])[scan, row], scan, row
