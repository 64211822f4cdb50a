"""The bytes of the native feed: every websocket message is one msgpack map with a `type` and an `epoch`. No I/O here.

Messages and their fields: docs/feed.md#messages. Angles are whole numbers of 1/65536 turn, clockwise from true north; everything
else is SI, or carries its unit in its name.
"""

import zlib
from typing import Any

import msgpack
import numpy as np
import zstandard
from numpy.typing import NDArray

from radar_service.strict_json import unique_keys

PROTOCOL = 1
TURN = 65_536  # wire units per revolution
DTYPES = {"u8": "|u1", "u8-log": "|u1", "f16": "<f2", "f32": "<f4", "c64": "<c8"}
ARRAYS = ("data", "labels", "powers")  # of a `spokes` message; a row of each for each spoke
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
    """Returns the object in `data`. Raises ValueError where it is not msgpack, or a map has a key twice."""
    if len(data) > MAX_MESSAGE:
        raise ValueError(f"a message of {len(data)} bytes; at most {MAX_MESSAGE} are allowed")
    try:
        return msgpack.unpackb(
            data, raw=False, object_pairs_hook=unique_keys
        )  # msgpack refuses lengths beyond the end of `data`
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
    return _array(message, "data", DTYPES[message["encoding"]]).reshape(_rows(message), int(message["bins"]))


def labels(message: dict[str, Any]) -> NDArray[np.uint32] | None:
    """Returns the labels (rows, bins) of a `spokes` message, None where it has none. Raises ValueError as `samples` does."""
    if "labels" not in message:
        return None
    return _array(message, "labels", "<u4").reshape(_rows(message), int(message["bins"]))


def powers(message: dict[str, Any]) -> dict[int, NDArray[np.float32]] | None:
    """Returns the power (rows, bins) [W] of each source of a `spokes` message by its number, None where it has none.

    Raises ValueError as `samples` does.
    """
    if "powers" not in message:
        return None
    numbers = message["power_sources"]
    power = _array(message, "powers", "<f4").reshape(_rows(message), len(numbers), int(message["bins"]))
    return {int(number): power[:, k] for k, number in enumerate(numbers)}


def packed(message: dict[str, Any], compression: str) -> dict[str, Any]:
    """Returns a `spokes` message with its arrays compressed, at the fastest level; "": as they are."""
    if not compression:
        return message
    arrays = {key: _packed(message[key], compression) for key in ARRAYS if key in message}
    return message | arrays | {"compression": compression}


def unpacked(message: dict[str, Any]) -> dict[str, Any]:
    """Returns a `spokes` message whose arrays are not compressed. Raises ValueError as `samples` does."""
    if "compression" not in message:
        return message
    plain = {key: value for key, value in message.items() if key != "compression"}
    return plain | {key: _bytes(message, key) for key in ARRAYS if key in message}


def _rows(message: dict[str, Any]) -> int:
    """How many rows the arrays have. A view may have fewer than there are spokes."""
    return len(message["azimuth"]) if "azimuth" in message else int(message["count"])


def _array(message: dict[str, Any], key: str, dtype: str) -> NDArray[Any]:
    return np.frombuffer(_bytes(message, key), dtype=np.dtype(dtype))


def _bytes(message: dict[str, Any], key: str) -> bytes:
    """The bytes of an array, not compressed. Raises ValueError where they are not as many as its shape says."""
    rows, row = _rows(message), _row_bytes(message, key)
    data: bytes = message[key]
    if "compression" in message:
        data = _unpacked(key, data, message["compression"], rows * row)
    if len(data) != rows * row:
        raise ValueError(f"{key}: {len(data)} bytes are not {rows} rows of {row} bytes")
    return data


def _row_bytes(message: dict[str, Any], key: str) -> int:
    """Bytes of a row of an array, not compressed."""
    bins = int(message["bins"])
    if key == "data":
        return bins * np.dtype(DTYPES[message["encoding"]]).itemsize
    return 4 * bins * (len(message["power_sources"]) if key == "powers" else 1)


def _packed(data: bytes, compression: str) -> bytes:
    return zlib.compress(data, 1) if compression == "deflate" else zstandard.ZstdCompressor(level=1).compress(data)


def _unpacked(key: str, data: bytes, compression: str, size: int) -> bytes:
    """Returns at most size + 1 bytes, so that the caller sees when there are too many.

    Raises ValueError where `size` is not allowed or `data` is not compressed in this way.
    """
    if not 0 <= size <= MAX_MESSAGE:
        raise ValueError(f"{key}: {size} bytes; at most {MAX_MESSAGE} are allowed")
    try:
        if compression == "deflate":
            return zlib.decompressobj().decompress(data, size + 1)
        if compression == "zstd":
            with zstandard.ZstdDecompressor().stream_reader(data) as reader:
                return reader.read(size + 1)
    except (zlib.error, zstandard.ZstdError) as error:
        raise ValueError(f"{key}: not {compression}: {error}") from error
    raise ValueError(f'compression: "{compression}" is not one of {", ".join(COMPRESSIONS)}')
