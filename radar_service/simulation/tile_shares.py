"""How the tiles of a scan are shared out to processes: consecutive ones to each, which took about as long before."""

import numpy as np

from radar_service.numerics.types import Floats, Indices

NOBODY = -1  # owns a tile that nobody computes
LATEST = 0.25  # weight of what a tile took last: a busy machine takes twice as long at times


class TileShares:
    """The shares of the tiles (T,) of a scan, by what the tiles took before. owners: the number of the process of each tile."""

    def __init__(self, tiles: int) -> None:
        self.owners: Indices = np.full(tiles, NOBODY)
        self._seconds: Floats = np.full(tiles, np.nan)  # that each takes, where that is known

    def share_out(self, tiles: Indices, count: int) -> None:
        """Shares some tiles (M,), rising, out to at most `count` processes."""
        self.owners[:] = NOBODY
        self.owners[tiles] = shares(self._costs(tiles), count)

    def note(self, tile: int, seconds: float) -> None:
        """Notes what a tile took in its process [s]."""
        known = float(self._seconds[tile])
        self._seconds[tile] = seconds if np.isnan(known) else known + LATEST * (seconds - known)

    def are_uneven(self, count: int, times: float) -> bool:
        """Whether the last process takes more than so many times what it takes in new shares, as far as is known."""
        tiles = np.flatnonzero(self.owners != NOBODY)
        seconds = self._costs(tiles)
        now, new = (np.bincount(owners, seconds).max() for owners in (self.owners[tiles], shares(seconds, count)))
        return bool(now > times * new)

    def _costs(self, tiles: Indices) -> Floats:
        """What these tiles (M,) take [s]; those that are not known, the mean of the others."""
        seconds = self._seconds[tiles]
        known = seconds[~np.isnan(seconds)]
        return np.where(np.isnan(seconds), known.mean() if len(known) else 1.0, seconds)


def shares(seconds: Floats, count: int) -> Indices:
    """The number (T,) of the process, of `count`, that computes each tile: it has the middle of the tile's time [s] in its equal
    share of all time."""
    middle = np.cumsum(seconds) - 0.5 * seconds
    return np.asarray(np.minimum(count * middle / seconds.sum(), count - 1), dtype=np.int64)
