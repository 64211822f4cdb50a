"""Blocks of ASTERIX category 048 (docs/dialects/asterix-048.md): plots as target reports. No I/O."""

import math
import struct
from collections.abc import Sequence
from datetime import datetime

import numpy as np

from radar_service.numerics.constants import NAUTICAL_MILE
from radar_service.plots.plot import Plot
from radar_service.ports.asterix.video_blocks import CIRCLE, block_of, time_of_day
from radar_service.ports.udp.sender import MAX_DATAGRAM
from radar_service.service.spokes import Epoch
from radar_service.spoke_source import SpokeSourceInfo
from radar_service.world.geo import true_bearing

CATEGORY = 48
ITEMS, CHARACTERISTICS = 0xF2, 0x18  # 010, 140, 020, 040, 130; of the last one run length and amplitude
PRIMARY, SIMULATED = 1 << 5, 1 << 4  # of item 020
RANGE = NAUTICAL_MILE / 256.0  # m: unit of range
RUN = 2.0 * math.pi / 8192  # unit of run length
IN_BLOCK = (MAX_DATAGRAM - 3) // 14  # records


def plot_blocks(plots: Sequence[Plot], epoch: Epoch, sac: int, sic: int) -> list[bytes]:
    """Returns the blocks of plots, each below the size of a frame."""
    records = [_record(plot, epoch.info, epoch.start_utc, sac, sic) for plot in plots]
    return [block_of(CATEGORY, b"".join(records[k : k + IN_BLOCK])) for k in range(0, len(records), IN_BLOCK)]


def _record(plot: Plot, known: SpokeSourceInfo, start: datetime, sac: int, sic: int) -> bytes:
    bearing, origin = plot.bearing, known.scene.origin
    if origin is not None:
        own = plot.range * np.array([math.sin(bearing), math.cos(bearing)])
        bearing = float(true_bearing(bearing, np.array([plot.east, plot.north]) - own, origin))
    run = (plot.bearing_extent[1] - plot.bearing_extent[0] - 1e-9) % (2.0 * math.pi)  # of a ring a whole turn, not none
    amplitude = 10.0 * math.log10(known.noise_power) + 30.0 + plot.snr_db  # dBm
    return struct.pack(
        ">BBB3sBHHBBb", ITEMS, sac, sic, time_of_day(start, plot.time), PRIMARY | SIMULATED,
        min(round(plot.range / RANGE), 65535), round(bearing / (2.0 * math.pi) * CIRCLE) % CIRCLE,
        CHARACTERISTICS, min(round(run / RUN), 255), min(max(round(amplitude), -128), 127),
    )  # fmt: skip
