"""Which cell a bin shows, so that a label and the power of a source are those of that cell."""

import numpy as np

from radar_service.display.video import Controls, Layout, stretch_cells, video_level_db
from radar_service.types import Indices, Profiles, Singles


def shown_cells(
    encoding: str, power: Singles, field: Profiles, to: Layout, controls: Controls, noise_power: float,
    before: Singles | None = None, earlier: Singles | None = None,
) -> Indices:  # fmt: skip
    """The number (K, bins) of the cell whose sample each bin shows in an encoding; the first one where several are equal.

    Arguments are those of `encoding.encode`. Echo stretch shows a cell also in the bins behind it.
    """
    if encoding == "u8":
        level = video_level_db(power, to, controls, noise_power, before, earlier)
        return _strongest_cells(level, to, stretch_cells(to, controls))
    if encoding == "c64":
        return _strongest_cells(field[:, : to.samples].real ** 2 + field[:, : to.samples].imag ** 2, to, 0)
    return _strongest_cells(power[:, : to.samples], to, 0)


def _strongest_cells(level: Singles, to: Layout, stretch: int) -> Indices:
    """The strongest cell of each bin (K, bins) and of `stretch` cells before it."""
    begins, ends = np.maximum(to.starts - stretch, 0), np.append(to.starts[1:], to.samples)
    cells = np.minimum(begins[:, None] + np.arange(int((ends - begins).max())), ends[:, None] - 1)
    pick = np.argmax(level[:, cells], axis=2)
    return np.asarray(cells[np.arange(to.bins), pick])
