"""Blocks of ASTERIX category 048 (docs/dialects/asterix-048.md): plots as target reports."""

import math
import struct
from collections.abc import Sequence
from datetime import datetime
from functools import partial

import numpy as np

from radar_service.numerics.constants import NAUTICAL_MILE
from radar_service.plots.extractor import LivePlots
from radar_service.plots.plot import Plot
from radar_service.plots.plot_process import PlotProcess, ready_extractor
from radar_service.ports.asterix.video_blocks import CIRCLE, block_of, time_of_day
from radar_service.ports.udp.sender import MAX_DATAGRAM
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.service.logs import log_event
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
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


class PlotSink:
    """The plots of one radar, after each scan; in a service a process extracts them."""

    def __init__(self, port: UdpPort, sic: int, sac: int) -> None:
        self._port, self._sac, self._sic = port, sac, sic
        self._plots: LivePlots | None = None
        self._process: PlotProcess | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins with the first scan."""
        self.close("another epoch")
        known = radar.epoch.info.radar
        if self._port.fork_server is not None:
            self._process = PlotProcess(self._port.fork_server, _tell)
        make = partial(ready_extractor, known, _tell) if self._process is None else partial(self._process.begin, known)
        self._plots = LivePlots(known.azimuths, make)

    def send(self, batch: SpokeBatch) -> None:
        """Sends the plots of the scans that end. After the process has failed another one begins with the next scan."""
        if self._plots is None:
            self.open_epoch(RadarInfo.unnamed(batch.epoch))
        assert self._plots is not None
        lost = self._plots.lost
        try:
            plots = self._plots.add(batch.block)
        except (OSError, EOFError):
            self._plots = None
            raise
        self._port.lost += self._plots.lost - lost
        self._port.send(plot_blocks(plots, batch.epoch, self._sac, self._sic))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Sends nothing."""

    def close(self, reason: str) -> None:
        """Ends the process."""
        self._plots = None
        if self._process is not None:
            self._process.close()
            self._process = None


def _tell(flood: str) -> None:
    log_event("too many plots", port="asterix-plots", reason=flood)
