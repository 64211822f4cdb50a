"""A still picture of the last scan: what a display shows, as a PNG."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from radar_service.display.picture import render_png
from radar_service.display.video import Controls, Layout, display_video

Rows = tuple[NDArray[np.intp], NDArray[np.float32]]


def last_scan_png(
    rows: Sequence[Rows], azimuths: int, to: Layout, controls: Controls, noise_power: float, *, title: str, size: int,
    range_max: float | None, heading: float,
) -> bytes:  # fmt: skip
    """Returns the PNG of one scan as u8 video, north up; azimuths without a row are grey.

    rows: row numbers (K,) and power (K, N) [W], oldest first; azimuths: of a scan; to: the bins of the video;
    noise_power: of a cell [W]; size: pixels; range_max: edge of the picture [m], None for that of `to`;
    heading: of the heading line [rad from north].
    """
    polar = np.zeros((azimuths, to.bins), dtype=np.uint8)
    filled = np.zeros(azimuths, dtype=bool)
    last: tuple[int, NDArray[np.float32]] | None = None  # number and power of the row before
    for numbers, power in rows:
        before = last[1] if last and (last[0] + 1) % azimuths == numbers[0] else None
        polar[numbers] = display_video(power, to, controls, noise_power, before)
        filled[numbers] = True
        last = int(numbers[-1]), power[-1]
    return render_png(
        polar, to.first, to.step, range_max=range_max or to.range, size=size, heading=heading % (2.0 * math.pi),
        title=title, filled=filled,
    )  # fmt: skip
