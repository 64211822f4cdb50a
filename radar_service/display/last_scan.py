"""A still picture of the last scan: what a display shows, as a PNG."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from radar_service.display.picture import render_png
from radar_service.display.units import DEFAULT_UNIT, Unit
from radar_service.display.video import Controls, Layout, display_video
from radar_service.numerics import Singles

Rows = tuple[NDArray[np.intp], Singles, Singles | None]


def last_scan_png(
    rows: Sequence[Rows], azimuths: int, to: Layout, controls: Controls, noise_power: float, *, title: str, size: int,
    range_max: float | None, heading: float, unit: Unit = DEFAULT_UNIT,
) -> bytes:  # fmt: skip
    """Returns the PNG of one scan as u8 video, north up; azimuths without a row are grey.

    rows: row numbers (K,), power (K, N) [W] and, for scan correlation, that of the scan before; oldest first;
    azimuths: of a scan; to: the bins of the video;
    noise_power: of a cell [W]; size: pixels; range_max: edge of the picture [m], None for that of `to`;
    heading: of the heading line [rad from north]; unit: of ranges and rings.
    """
    polar = np.zeros((azimuths, to.bins), dtype=np.uint8)
    filled = np.zeros(azimuths, dtype=bool)
    last: tuple[int, Singles] | None = None  # number and power of the row before
    for numbers, power, earlier in rows:
        before = last[1] if last and (last[0] + 1) % azimuths == numbers[0] else None
        polar[numbers] = display_video(power, to, controls, noise_power, before, earlier)
        filled[numbers] = True
        last = int(numbers[-1]), power[-1]
    return render_png(
        polar, to.first, to.step, range_max=range_max or to.range, size=size, heading=heading % (2.0 * math.pi),
        title=title, filled=filled, unit=unit,
    )  # fmt: skip
