"""A still picture of what a radar sees, drawn from the last revolution."""

import numpy as np
from numpy.typing import NDArray

from radar_service.display.picture import render_png
from radar_service.display.video import Controls, display_video
from radar_service.stream.messages import Engine, engine_layout

Rows = tuple[NDArray[np.intp], NDArray[np.float32]]


def ppi_png(engine: Engine, sweep: list[Rows], controls: Controls, size: int, range_max: float | None, time: float) -> bytes:
    """A PNG of the sweep (rows and their power [W]) as u8 video out to range_max [m]; rows not yet swept are grey."""
    azimuths = engine.scene.radar.azimuths
    to = engine_layout(engine, None, range_max)
    polar = np.zeros((azimuths, to.bins), dtype=np.uint8)
    filled = np.zeros(azimuths, dtype=bool)
    for rows, power in sweep:
        polar[rows] = display_video(power, to, controls, engine.noise_power)
        filled[rows] = True
    heading = float(engine.scene.own_ship.pose(time).heading[0])
    return render_png(
        polar, to.first, to.step, range_max=range_max or to.range, size=size, heading=heading, title=engine.scene.name,
        filled=filled,
    )  # fmt: skip
