"""The beginning of a chunk within which a file ends.

A chunk is one frame of zstd, whose blocks hold at most 128 KiB: what the file has of whole blocks can be read.
"""

import struct
from dataclasses import replace
from io import BytesIO

import zstandard

from radar_service.recording.mcap_library import Chunk

HEAD = struct.Struct("<BQ")  # of a record: opcode, length


def whole_records(chunk: Chunk) -> Chunk:
    """Returns a plain chunk of the records that are whole, without a sum: that in the file is of all of them.

    Raises zstandard.ZstdError where the file holds something else, and ValueError for another compression.
    """
    data = _unpacked(chunk)
    return replace(chunk, compression="", uncompressed_crc=0, data=data[: _end_of_records(data)])


def _unpacked(chunk: Chunk) -> bytes:
    match chunk.compression:
        case "":
            return bytes(chunk.data)
        case "zstd":
            with zstandard.ZstdDecompressor().stream_reader(BytesIO(chunk.data)) as reader:
                return bytes(reader.read(chunk.uncompressed_size))
    raise ValueError(f'the beginning of a chunk that is compressed by "{chunk.compression}" cannot be read')


def _end_of_records(data: bytes) -> int:
    """Returns where the last whole record ends [bytes]."""
    end = 0
    while end + HEAD.size <= len(data):
        after = end + HEAD.size + HEAD.unpack_from(data, end)[1]
        if after > len(data):
            break
        end = after
    return end
