"""How the tiles of a scan are shared out to processes: consecutive ones to each, so that the last process ends soonest.

Scans follow each other, so the last tile and the first one are consecutive too.
"""

import numpy as np

from radar_service.numerics.types import Flags, Floats, Indices

NOBODY = -1  # owns a tile that nobody computes
LATEST = 0.25  # weight of what a tile took last: a busy machine takes twice as long at times
TRIED = 32  # tiles, about, that are tried as the first one of a process: each takes 0.1 to 1 ms


class TileShares:
    """The shares of the tiles (T,) of a scan, by what the tiles took before. owners: the number of the process of each tile."""

    def __init__(self, tiles: int, passage: int) -> None:
        """passage: tiles in which the beam meets a body."""
        self.owners: Indices = np.full(tiles, NOBODY)
        self._passage = passage
        self._seconds: Floats = np.full(tiles, np.nan)  # that each takes, where that is known
        self._again: Floats = np.zeros(tiles)  # that it takes more in the present scan, as its process begins with it

    def share_out(self, tiles: Indices, count: int) -> None:
        """Shares some tiles (M,), rising, out to at most `count` processes."""
        seconds, again = self._costs(tiles)
        owners, last_owner = shares(seconds, again, count), self.owners[tiles[-1]]
        begin = begins(owners)
        begin[0] = owners[0] != last_owner  # who had the last tile knows what the beam meets in the first one
        self.owners[:] = NOBODY
        self.owners[tiles] = owners
        self._again[tiles] = np.where(begin, again, 0.0)

    def go_on(self) -> None:
        """Begins another scan in the same shares."""
        tiles = np.flatnonzero(self.owners != NOBODY)
        _, again = self._costs(tiles)
        self._again[tiles] = np.where(begins(self.owners[tiles]), again, 0.0)

    def note(self, tile: int, seconds: float) -> None:
        """Notes what a tile took in its process [s]."""
        latest, known = max(seconds - self._again[tile], 0.0), float(self._seconds[tile])
        self._seconds[tile] = latest if np.isnan(known) else known + LATEST * (latest - known)

    def end_late(self, count: int, times: float) -> bool:
        """Whether the last process of these shares takes more than so many times what it takes in the best shares, as far as is
        known."""
        tiles = np.flatnonzero(self.owners != NOBODY)
        seconds, again = self._costs(tiles)
        now, least = longest(seconds, again, self.owners[tiles]), max(seconds.sum() / count, seconds.max())
        return bool(now > times * least) and now > times * longest(seconds, again, shares(seconds, again, count))

    def _costs(self, tiles: Indices) -> tuple[Floats, Floats]:
        """What these tiles (M,) take, and what each takes more as the first one of a process [s]."""
        seconds = self._seconds[tiles]
        known = seconds[~np.isnan(seconds)]
        seconds = np.where(np.isnan(seconds), known.mean() if len(known) else 1.0, seconds)
        return seconds, computed_again(seconds, self._passage)


def begins(owners: Indices) -> Flags:
    """Which tiles (T,) of a turn their process begins with: none where one process has all."""
    return np.asarray(owners != np.roll(owners, 1))


def longest(seconds: Floats, again: Floats, owners: Indices) -> float:
    """How long the process takes that ends last; arguments as of `shares`, and what it returns."""
    return float(np.bincount(owners, seconds + np.where(begins(owners), again, 0.0)).max())


def shares(seconds: Floats, again: Floats, count: int) -> Indices:
    """The number (T,) of the process that computes each tile of a turn, so that the last one ends soonest; number 0 has the first
    tile.

    seconds: that each tile takes (T,); again: what it takes more where a process begins with it (T,); count: of processes at
    most: where the work of one cannot be shared, others have none.
    """
    best = np.zeros(len(seconds), dtype=np.int64)
    shortest = longest(seconds, again, best)
    run = _too_long_run(seconds, min(shortest, longest(seconds, again, _from_first(seconds, again, count))))
    for begin in [0, *run[:: 1 + len(run) // TRIED]]:
        owners = np.roll(_from_first(np.roll(seconds, -begin), np.roll(again, -begin), count), begin)
        time = longest(seconds, again, owners)
        if time < shortest:
            best, shortest = owners, time
    return np.asarray((best - best[0]) % (best.max() + 1))


def _too_long_run(seconds: Floats, limit: float) -> list[int]:
    """The fewest consecutive tiles of which one process takes longer than a limit, but for the first one: in shares within the
    limit some process begins with one of them. None where one process can have all."""
    tiles = len(seconds)
    until = np.append(0.0, np.cumsum(np.tile(seconds, 2)))
    stop = np.searchsorted(until, until[:tiles] + limit, side="right")
    first = int(np.argmin(stop - np.arange(tiles)))
    return [(first + k) % tiles for k in range(1, min(int(stop[first]) - first, tiles))]


def _from_first(seconds: Floats, again: Floats, count: int) -> Indices:
    """The same, where a process begins with the first tile (T,)."""
    tiles = len(seconds)
    until = np.append(0.0, np.cumsum(seconds))
    spent = until[1:] - until[:-1, None] + again[:, None]  # by who computes from one tile to another, both included
    spent[np.tril_indices(tiles, -1)] = np.inf
    ends, starts = [spent[0]], [np.zeros(tiles, dtype=np.int64)]  # of 1, 2, ... processes: least time, where the last begins
    for _ in range(1, min(count, tiles)):
        last = np.maximum(np.append(np.inf, ends[-1][:-1])[:, None], spent)
        ends.append(last.min(axis=0))
        starts.append(last.argmin(axis=0))
    owners, stop = np.zeros(tiles, dtype=np.int64), tiles
    for number in range(int(np.argmin([end[-1] for end in ends])), 0, -1):
        start = int(starts[number][stop - 1])
        owners[start:stop], stop = number, start
    return owners


def computed_again(seconds: Floats, passage: int) -> Floats:
    """What each tile (T,) of a turn would take more [s] if other processes computed those before: the bodies that begin there.

    seconds: that tiles take (T,): a body's echoes are computed with its first one. passage: tiles that a body is in the beam.
    """
    bodies, before = np.maximum(seconds - np.median(seconds), 0.0), min(passage, len(seconds)) - 1
    until = np.append(0.0, np.cumsum(np.concatenate([bodies[len(bodies) - before :], bodies])))
    return np.asarray(until[before : before + len(bodies)] - until[: len(bodies)])
