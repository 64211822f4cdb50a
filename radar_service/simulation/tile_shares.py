"""How the tiles of a scan are shared out to processes: consecutive ones to each, so that the last process ends soonest."""

import numpy as np

from radar_service.numerics.types import Floats, Indices

NOBODY = -1  # owns a tile that nobody computes


class TileShares:
    """The shares of the tiles (T,) of a scan, by what the tiles took before. owners: the number of the process of each tile."""

    def __init__(self, tiles: int, passage: int) -> None:
        """passage: tiles in which the beam meets a body."""
        self.owners: Indices = np.full(tiles, NOBODY)
        self._passage = passage
        self._seconds: Floats = np.full(tiles, np.nan)  # that each takes, where that is known
        self._again: Floats = np.zeros(tiles)  # that it takes more, as the first one of its process

    def share_out(self, tiles: Indices, count: int) -> None:
        """Shares some tiles (M,), rising, out to at most `count` processes."""
        seconds, again = self._costs(tiles)
        owners = shares(seconds, again, count)
        self.owners[:] = NOBODY
        self.owners[tiles] = owners
        self._again[tiles] = np.where(np.diff(owners, prepend=0) > 0, again, 0.0)

    def note(self, tile: int, seconds: float) -> None:
        """Notes what a tile took in its process [s]."""
        latest, known = max(seconds - self._again[tile], 0.0), float(self._seconds[tile])
        self._seconds[tile] = latest if np.isnan(known) else (latest + known) / 2.0

    def uneven(self, count: int) -> float:
        """How many times the time of the best shares the last process of these takes, as far as is known."""
        tiles = np.flatnonzero(self.owners != NOBODY)
        seconds, again = self._costs(tiles)
        return longest(seconds, again, self.owners[tiles]) / longest(seconds, again, shares(seconds, again, count))

    def _costs(self, tiles: Indices) -> tuple[Floats, Floats]:
        """What these tiles (M,) take, and what each takes more as the first one of a process [s]."""
        seconds = self._seconds[tiles]
        known = seconds[~np.isnan(seconds)]
        seconds = np.where(np.isnan(seconds), known.mean() if len(known) else 1.0, seconds)
        return seconds, computed_again(seconds, self._passage)


def longest(seconds: Floats, again: Floats, owners: Indices) -> float:
    """How long the process takes that ends last; arguments as of `shares`, and what it returns."""
    first = np.diff(owners, prepend=0) > 0
    return float(np.bincount(owners, seconds + np.where(first, again, 0.0)).max())


def shares(seconds: Floats, again: Floats, count: int) -> Indices:
    """The number (T,) of the process that computes each of consecutive tiles, so that the last one ends soonest.

    seconds: that each tile takes (T,); again: what it takes more where a process begins with it (T,); count: of processes at
    most: where the work of one cannot be shared, others have none.
    """
    tiles = len(seconds)
    until = np.concatenate([[0.0], np.cumsum(seconds)])
    spent = until[1:] - until[:-1, None] + again[:, None]  # by who computes from one tile to another, both included
    spent[np.tril_indices(tiles, -1)] = np.inf
    ends, begins = [spent[0]], [np.zeros(tiles, dtype=np.int64)]  # of 1, 2, ... processes: least time, where the last begins
    for _ in range(1, min(count, tiles)):
        last = np.maximum(np.append(np.inf, ends[-1][:-1])[:, None], spent)
        ends.append(last.min(axis=0))
        begins.append(last.argmin(axis=0))
    owners, stop = np.zeros(tiles, dtype=np.int64), tiles
    for number in range(int(np.argmin([end[-1] for end in ends])), 0, -1):
        begin = int(begins[number][stop - 1])
        owners[begin:stop], stop = number, begin
    return owners


def computed_again(seconds: Floats, passage: int) -> Floats:
    """What each tile (T,) would take more [s] if other processes had computed those before: the bodies that begin there.

    seconds: that tiles take (T,): a body's echoes are computed with its first one. passage: tiles that a body is in the beam.
    """
    bodies = np.maximum(seconds - np.median(seconds), 0.0)
    before = np.concatenate([np.zeros(passage), np.cumsum(bodies)])
    return np.asarray(before[passage - 1 : -1] - before[: len(seconds)])
