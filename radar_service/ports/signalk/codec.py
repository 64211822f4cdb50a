"""Spokes as the Signal K Radar API has them: video of 252 levels, range in whole metres, angles from the bow and from north.

The API has no hello, no gap and no bye: a client sees the angles that it did not get. What it may know of a radar it reads once
(`RadarShape`); spokes of another shape are not sent under that view.

A message is a `RadarMessage` of protobuf, repeated field 2: angle (1) and bearing (2) in spokes of a revolution, range (3) [m],
time (4) since 1970 [ms], data (5), latitude (6) and longitude (7) [degrees].
"""

import struct
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from radar_service.numerics import Floats
from radar_service.service.feed_request import FeedRequest, View
from radar_service.service.spokes import SpokeBatch
from radar_service.spoke_source import SpokeSourceInfo
from radar_service.world import geographic_from_map, true_bearing

VARINT, DOUBLE, BYTES = 0, 1, 2  # wire types
SPOKES = 2 << 3 | BYTES
ANGLE, BEARING, RANGE, TIME = (field << 3 | VARINT for field in (1, 2, 3, 4))
DATA = 5 << 3 | BYTES
LATITUDE, LONGITUDE = (field << 3 | DOUBLE for field in (6, 7))
MAX_SAMPLES = 1024  # of a spoke: what the sets that clients know send
LEVELS = 252  # of a sample, as Furuno's have; stronger ones, the last dB of the 63, are shown as the highest


class SpokeFields(NamedTuple):
    """One spoke; None: not known. angle: clockwise from the bow, bearing: from true north, both in spokes of a revolution.

    range: of the far edge of the last sample [m]; time: since 1970 [ms]; position: latitude, longitude [degrees].
    """

    angle: int
    bearing: int | None
    range: int
    time: int | None
    position: tuple[float, float] | None
    data: bytes


def varint(value: int) -> bytes:
    """Returns a whole number from 0 up in groups of seven bits, the lowest first."""
    if value < 0x80:
        return bytes((value,))
    groups = bytearray()
    while value >= 0x80:
        groups.append(value & 0x7F | 0x80)
        value >>= 7
    groups.append(value)
    return bytes(groups)


_keyed = lru_cache(maxsize=1 << 16)(
    lambda key, value: bytes((key,)) + varint(value)
)  # of angles and sizes, which come again


def spoke_bytes(spoke: SpokeFields) -> bytes:
    """Returns one spoke as an element of a message."""
    parts = [_keyed(ANGLE, spoke.angle)]
    if spoke.bearing is not None:
        parts.append(_keyed(BEARING, spoke.bearing))
    parts.append(_keyed(RANGE, spoke.range))
    if spoke.time is not None:
        parts += [bytes((TIME,)), varint(spoke.time)]
    parts += [_keyed(DATA, len(spoke.data)), spoke.data]
    if spoke.position is not None:
        latitude, longitude = spoke.position
        parts.append(struct.pack("<BdBd", LATITUDE, latitude, LONGITUDE, longitude))
    content = b"".join(parts)
    return _keyed(SPOKES, len(content)) + content


def last_spokes(message: bytes, count: int) -> bytes:
    """Returns a message with only its last `count` spokes."""
    starts = list(_starts(message))
    return message[starts[-count] :] if count else b""


def _starts(message: bytes) -> Iterator[int]:
    """Where each spoke of a message of `spoke_bytes` begins."""
    at = 0
    while at < len(message):
        yield at
        at, shift, size = at + 1, 0, 0
        while True:
            byte = message[at]
            size |= (byte & 0x7F) << shift
            at, shift = at + 1, shift + 7
            if byte < 0x80:
                break
        at += size


class RadarShape(NamedTuple):
    """What clients read once of a radar. samples: of the longest spoke, a multiple of 4, as textures of clients need it."""

    azimuths: int
    samples: int
    range_max: int  # m, rounded down

    @classmethod
    def of(cls, source: SpokeSourceInfo) -> "RadarShape":
        """Returns the shape of a radar."""
        samples = min(MAX_SAMPLES, 4 * -(-source.range.size // 4))
        return cls(source.radar.azimuths, samples, int(source.radar.range_max))

    @property
    def encoding(self) -> str:
        """Names the samples of this shape in a view."""
        return f"u8 {self.azimuths} x {self.samples} to {self.range_max} m"

    @property
    def request(self) -> FeedRequest:
        """What a client receives that has read this shape."""
        return FeedRequest(View(self.encoding, MAX_SAMPLES, codec=SignalKCodec.name))


class SignalKCodec:
    """Writes the messages of a spoke websocket."""

    name, port, rising = "signalk", "signalk", True
    path = "/signalk/v2/api/vessels/self/radars/{radar}/spokes"

    def request(self, query: Mapping[str, str], is_local: bool) -> FeedRequest:
        """Returns what every client gets, of whatever shape the radar is; the API has no parameters."""
        return FeedRequest(View("u8", MAX_SAMPLES, codec=self.name))

    def _no_message(self, *_: Any, **__: Any) -> bytes:
        """Returns no message."""
        return b""

    hello = truth = no_truth = gap = bye = _no_message

    def spokes(self, batch: SpokeBatch, view: View) -> bytes:
        """Returns the spokes of a batch; no message where they are of another shape than that of the view."""
        if view.encoding not in ("u8", RadarShape.of(batch.epoch.info).encoding):
            return b""
        return b"".join(map(spoke_bytes, _spokes(batch, view)))

    def trim(self, data: bytes, count: int) -> bytes:
        """Returns a message cut down to its last `count` spokes."""
        return last_spokes(data, count)


def _spokes(batch: SpokeBatch, view: View) -> list[SpokeFields]:
    block, known, to = batch.block, batch.epoch.info, batch.epoch.layout(view.bins)
    rows = np.minimum(batch.video_bytes(to), LEVELS - 1)
    azimuths = known.radar.azimuths
    lost = np.isnan(block.heading)  # the azimuth then counts from the bow
    bearing = _in_spokes(block.azimuth, azimuths)
    # The heading is rounded as such: clients take it from the difference, and each angle comes once in a revolution.
    angle = np.mod(bearing - _in_spokes(np.where(lost, 0.0, block.heading), azimuths), azimuths)
    times = np.rint(1000.0 * (batch.epoch.start_utc.timestamp() + block.time)).astype(np.int64).tolist()  # ms since 1970
    origin = known.scene.origin
    positions = (
        None if origin is None else [(north, east) for north, east in geographic_from_map(block.position, origin).tolist()]
    )
    north = np.zeros(len(block)) if origin is None else true_bearing(0.0, block.position, origin)
    true = np.mod(bearing + _in_spokes(north, azimuths), azimuths)  # each comes once in a revolution, too
    bearings = [None if is_lost else int(each) for each, is_lost in zip(true.tolist(), lost.tolist(), strict=True)]
    angles, to_edge = angle.astype(int).tolist(), round(to.range)
    return [
        SpokeFields(angles[k], bearings[k], to_edge, times[k], positions[k] if positions else None, rows[k].tobytes())
        for k in range(len(block))
    ]


def _in_spokes(angle: Floats, azimuths: int) -> Floats:
    """Angles [rad] in spokes of a revolution, from 0 up."""
    return np.mod(np.rint(angle * (azimuths / (2.0 * np.pi))), azimuths)
