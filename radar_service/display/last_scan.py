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
    for numbers, power in rows:
        polar[numbers] = display_video(power, to, controls, noise_power)
        filled[numbers] = True
    return render_png(
        polar, to.first, to.step, range_max=range_max or to.range, size=size, heading=heading % (2.0 * math.pi),
        title=title, filled=filled,
    )  # fmt: skip
