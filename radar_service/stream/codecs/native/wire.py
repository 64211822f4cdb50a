"""The bytes of the native feed: every websocket message is one msgpack map with a `type` and an `epoch`. No I/O here.

Angles on the wire are whole numbers of 1/65536 turn, clockwise (`azimuth`, `heading`, `course`: from true north, so that
azimuth - heading modulo 65536 is the angle from the bow). Everything else is SI, or carries its unit in its name.

hello   first message, and again whenever the epoch changes:
        protocol 1, epoch, radar {id, name, azimuths, rpm, bins, range_step_m, range_max_m, beamwidth_deg,
        beamwidth_el_deg, frequency_hz, modulation, bandwidth_hz, pulse_s, prf_hz, power_w, height_m, blind_sectors_deg},
        scene {name, origin {latitude_deg, longitude_deg} or nil, bodies, warnings}, seed, fidelity, plan,
        encoding {name, bins, range_step_m, range_first_m, range_m, dtype, noise_dbw; in u8 and u8-log also db_per_step,
        offset_db}, view {sector_deg, spokes, compression}, controls {...}, clocks {simulated_s, utc, pace}, mode,
        truth (whether this server sends it)
spokes  first (sequence number of the first one), count, scan, index (of the first one within the scan),
        time [s of simulation, one each], azimuth [one each], heading [one each; nil while the radar has lost it: azimuth
        then counts from the bow, and course is nil too], position [[east, north] m, one each],
        course [one each], speed [m/s, one each], bins, range_step_m, range_first_m (where sample 0 stands), range (far
        edge of the last cell, m), encoding, data (spokes x bins, row-major, little-endian), blind (bool each; absent: none).
        Where a view leaves out or merges spokes: row_first, row_count (a row stands for row_count spokes from
        first + row_first on; lists hold one entry for each row; spokes in no row were left out by the view and count as
        delivered). Where a view compresses: compression (of data: zstd, or deflate as in RFC 1950)
truth   time, own_ship {...}, bodies [{...}]: see records.BodyTruth, SI and radians
gap     first, count, reason: exactly the spokes that this client lost
bye     reason; the server closes after it

Encodings. With P the power of a cell in watts:
u8      the video that a display shows: 0 nothing, else (dBW after gain, STC, FTC - offset_db) / db_per_step, to half a step
u8-log  without display controls: byte b > 0 means 10 log10 P = offset_db + b x db_per_step (b = 255: or more); 0: below the scale
f16     10 log10 P as float16 (-inf where P = 0);  f32: P as float32;  c64: the complex field, sqrt(W), as complex64
With fewer bins than cells, each bin holds the strongest cell of its group.
"""

import zlib
from typing import Any

import msgpack
import numpy as np
import zstandard
from numpy.typing import NDArray

PROTOCOL = 1
TURN = 65_536  # wire units per revolution
DTYPES = {"u8": "|u1", "u8-log": "|u1", "f16": "<f2", "f32": "<f4", "c64": "<c8"}
COMPRESSIONS = ("zstd", "deflate")
MAX_MESSAGE = 64 * 2**20  # bytes a decoder accepts


def turn_from_radians(angle: NDArray[np.float64]) -> list[int | None]:
    """Returns angles [rad] as whole 1/65536 turns in [0, 65536), None for NaN."""
    known = ~np.isnan(angle)
    counts: list[int | None] = (
        np.rint(np.where(known, angle, 0.0) * (TURN / (2.0 * np.pi))).astype(np.int64) % TURN
    ).tolist()
    return counts if known.all() else [count if is_known else None for count, is_known in zip(counts, known, strict=True)]


def radians_from_turn(counts: NDArray[np.integer[Any]] | list[int | None]) -> NDArray[np.float64]:
    """Returns angles [rad, 0 to 2 pi) from whole 1/65536 turns, NaN for None."""
    return np.asarray(counts, dtype=np.float64) * (2.0 * np.pi / TURN)


def pack(message: dict[str, Any]) -> bytes:
    """Returns a message as bytes."""
    packed: bytes = msgpack.packb(message, use_bin_type=True)
    return packed


def unpack_any(data: bytes) -> Any:
    """Returns the object in `data`. Raises ValueError where it is not msgpack."""
    if len(data) > MAX_MESSAGE:
        raise ValueError(f"a message of {len(data)} bytes; at most {MAX_MESSAGE} are allowed")
    try:
        return msgpack.unpackb(data, raw=False)  # msgpack refuses lengths beyond the end of `data`
    except Exception as error:
        raise ValueError(f"not a msgpack message: {error}") from error


def unpack(data: bytes) -> dict[str, Any]:
    """Returns the message in `data`. Raises ValueError where it is not a map with a `type`."""
    message = unpack_any(data)
    if not isinstance(message, dict) or not isinstance(message.get("type"), str):
        raise ValueError("a message is a msgpack map with a string under `type`")
    return message


def samples(message: dict[str, Any]) -> NDArray[Any]:
    """Returns the samples (rows, bins) of a `spokes` message. Raises ValueError where size and shape disagree."""
    dtype = np.dtype(DTYPES[message["encoding"]])
    shape = (len(message["azimuth"]), int(message["bins"]))
    size = shape[0] * shape[1] * dtype.itemsize
    data = _unpacked(message["data"], message["compression"], size) if "compression" in message else message["data"]
    if len(data) != size:
        raise ValueError(f"data: {len(data)} bytes are not {shape[0]} x {shape[1]} samples of {dtype}")
    return np.frombuffer(data, dtype=dtype).reshape(shape)


def packed_samples(message: dict[str, Any], compression: str) -> dict[str, Any]:
    """Returns a `spokes` message with its data compressed, at the fastest level."""
    data = message["data"]
    packed = zlib.compress(data, 1) if compression == "deflate" else zstandard.ZstdCompressor(level=1).compress(data)
    return message | {"data": packed, "compression": compression}


def _unpacked(data: bytes, compression: str, size: int) -> bytes:
    """Returns at most size + 1 bytes, so that the caller sees when there are too many.

    Raises ValueError where `size` is not allowed or `data` is not compressed in this way.
    """
    if not 0 <= size <= MAX_MESSAGE:
        raise ValueError(f"data: {size} bytes; at most {MAX_MESSAGE} are allowed")
    try:
        if compression == "deflate":
            return zlib.decompressobj().decompress(data, size + 1)
        if compression == "zstd":
            with zstandard.ZstdDecompressor().stream_reader(data) as reader:
                unpacked: bytes = reader.read(size + 1)
                return unpacked
    except (zlib.error, zstandard.ZstdError) as error:
        raise ValueError(f"data: not {compression}: {error}") from error
    raise ValueError(f'compression: "{compression}" is not one of {", ".join(COMPRESSIONS)}')
