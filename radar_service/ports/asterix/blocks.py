"""Blocks of ASTERIX: video and its summaries, category 240, edition 1.3 (EUROCONTROL-SPEC-0149-240); plots, 048. No I/O.

A block is the category, its length, and one record: a list of which items follow, and these. Cell k of a spoke reaches from k to
k + 1 durations; a spoke reaches from half a spoke before its azimuth to half a spoke behind it.
"""

import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from radar_service.display.video import DB_PER_STEP, decibels
from radar_service.numerics import NAUTICAL_MILE
from radar_service.plots import Plot
from radar_service.ports.udp.sender import MAX_DATAGRAM
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from radar_service.spoke_source import SpokeSourceInfo
from radar_service.world import true_bearing

CATEGORY = 240
LIGHT = 299_792_458.0  # m/s: ranges are times there
CIRCLE = 2**16  # units of azimuth
DAY = 86_400 * 128  # units of the time of day
OCTETS = ((0x40, 4, 255), (0x20, 64, 255), (0x10, 256, 254))  # of items 050, 051, 052: presence bit, unit, most units
VIDEO_ITEMS, MORE_ITEMS = 0xE7, 0x88  # 010, 000, 020, 041, 048; 049, 140
SUMMARY_ITEMS = 0xD0  # 010, 000, 030
SUMMARY, VIDEO = 1, 2  # message types
HEAD = 35  # octets of a block of video without its cells
RESOLUTION = {8: 4, 16: 5}  # codes of item 048
FLOOR_DB, PER_DB = -100.0, 100.0  # of 16 bits: level 0, and units of a decibel
PLOT_CATEGORY = 48
ITEMS, CHARACTERISTICS = 0xF2, 0x18  # 010, 140, 020, 040, 130; of the last one run length and amplitude
PRIMARY, SIMULATED = 1 << 5, 1 << 4  # of item 020
RANGE = NAUTICAL_MILE / 256.0  # m: unit of range
RUN = 2.0 * math.pi / 8192  # unit of run length
IN_BLOCK = (MAX_DATAGRAM - 3) // 14  # records


@dataclass(frozen=True)
class Form:
    """How video is sent. sac: system area code; bits: of a cell, 8 or 16; largest: octets of a block."""

    sac: int = 0
    bits: int = 8
    largest: int = 1400

    @property
    def cells(self) -> int:
        """How many cells fit a block."""
        room = self.largest - HEAD
        return max(min(room // unit, most) * unit for _, unit, most in OCTETS) * 8 // self.bits

    @property
    def law(self) -> str:
        """What the value of a cell means."""
        if self.bits == 8:
            return f"8 bit: 0 below threshold, else value x {DB_PER_STEP} dB above it at most (log, after gain, sea, rain)"
        return f"16 bit: value / {PER_DB:g} {FLOOR_DB:+g} dB over mean noise (log, before gain, sea, rain), 0 at most that"


def summary(radar: RadarInfo, form: Form, sic: int) -> bytes:
    """Returns the block that says what the video of a radar is, in ASCII."""
    known = radar.name if radar.epoch.is_blind else radar.epoch.info.scene.name
    name = known.encode("ascii", "replace").decode()[:40]
    text = f"{name}, radar {radar.identity[:20]}. Azimuth from true north, mid spoke. Cell k from k to k+1 durations. {form.law}"
    head = struct.pack(">BBBBB", SUMMARY_ITEMS, form.sac, sic, SUMMARY, len(text))
    return block_of(CATEGORY, head + text.encode("ascii", "replace"))


def video(batch: SpokeBatch, form: Form, sic: int) -> Iterator[list[bytes]]:
    """Yields the blocks of each spoke of a batch; none for one whose heading is lost, as its azimuth is not known.

    Sequence numbers follow from those of the spokes: blocks that are missing were lost.
    """
    block, to, known = batch.block, batch.epoch.layout(None), batch.epoch.info
    rows, room = _cells(batch, form), form.cells
    starts = range(0, to.bins, room)
    north = true_bearing(0.0, block.position, known.scene.origin) if known.scene.origin else np.zeros(len(block))
    azimuth, half = CIRCLE * (block.azimuth + north) / (2.0 * math.pi), 0.5 * CIRCLE / known.radar.azimuths
    near = round((to.first - 0.5 * to.step) / to.step)  # cells before the first one
    duration = round(2.0 * to.step / LIGHT * 1e15)  # fs
    for k, time in enumerate(block.time.tolist()):
        blocks = list[bytes]()
        when = time_of_day(batch.epoch.start_utc, time)
        for part, start in enumerate(() if math.isnan(block.heading[k]) else starts):
            head = struct.pack(
                ">BBBIHHIIBB", form.sac, sic, VIDEO, ((batch.first + k) * len(starts) + part) % 2**32,
                round(azimuth[k] - half) % CIRCLE, round(azimuth[k] + half) % CIRCLE, near + start, duration,
                0, RESOLUTION[form.bits],
            )  # fmt: skip
            blocks.append(_video_block(head, rows[k, start : start + room], when))
        yield blocks


def _cells(batch: SpokeBatch, form: Form) -> NDArray[np.generic]:
    """The cells of a batch (K, bins) as they are sent."""
    to = batch.epoch.layout(None)
    if form.bits == 8:
        return batch.video_bytes(to)
    level = decibels(batch.block.power[:, : to.samples]) - 10.0 * math.log10(batch.epoch.info.noise_power)
    units: NDArray[np.generic] = np.rint(np.clip((level - FLOOR_DB) * PER_DB, 0.0, 65535.0)).astype(">u2")
    return units


def time_of_day(start: datetime, time: float) -> bytes:
    """Returns an instant in units of the time of day. start: UTC at time 0; time: simulated [s]."""
    midnight = start.replace(hour=0, minute=0, second=0, microsecond=0)
    return (round(128.0 * ((start - midnight).total_seconds() + time)) % DAY).to_bytes(3, "big")


def _video_block(head: bytes, cells: NDArray[np.generic], time: bytes) -> bytes:
    """Returns a block of some cells in the smallest of the items that takes them. head: the items before; time: of day."""
    octets = cells.tobytes()
    bit, unit, _ = next(item for item in OCTETS if len(octets) <= item[1] * item[2])
    repeats = -(-len(octets) // unit)
    count = struct.pack(">HBHB", len(octets), cells.size >> 16, cells.size & 0xFFFF, repeats)
    items = bytes((VIDEO_ITEMS, MORE_ITEMS | bit)) + head + count
    return block_of(CATEGORY, items + octets.ljust(repeats * unit, b"\0") + time)


def block_of(category: int, records: bytes) -> bytes:
    """Returns a block of records."""
    return struct.pack(">BH", category, 3 + len(records)) + records


def plot_blocks(plots: Sequence[Plot], epoch: Epoch, sac: int, sic: int) -> list[bytes]:
    """Returns the blocks of plots, each below the size of a frame."""
    records = [_record(plot, epoch.info, epoch.start_utc, sac, sic) for plot in plots]
    return [block_of(PLOT_CATEGORY, b"".join(records[k : k + IN_BLOCK])) for k in range(0, len(records), IN_BLOCK)]


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
