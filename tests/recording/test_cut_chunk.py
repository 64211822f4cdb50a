"""The beginning of a chunk: its whole records, whatever its compression."""

import random

import pytest
import zstandard

from radar_service.recording.cut_chunk import HEAD, whole_records
from radar_service.recording.mcap_library import Chunk

DRAWN = random.Random(6)
RECORDS = [HEAD.pack(5, 1000) + DRAWN.randbytes(1000) for _ in range(600)]  # of any kind: 591 KiB, which do not compress


def beginning(compression: str, data: bytes) -> Chunk:
    size = sum(map(len, RECORDS))
    return Chunk(compression, data, message_end_time=0, message_start_time=0, uncompressed_crc=7, uncompressed_size=size)


@pytest.mark.parametrize("size", [0, 5, 9, 1008, 1009, 1010, 5000, 600 * 1009])
def test_plain_records_are_kept_up_to_the_last_whole_one(size: int) -> None:
    chunk = whole_records(beginning("", b"".join(RECORDS)[:size]))
    assert (chunk.data, chunk.uncompressed_crc, chunk.compression) == (b"".join(RECORDS[: size // 1009]), 0, "")


@pytest.mark.parametrize("size", [0, 10, 2**17 + 100, 300_000, 500_000, 2**20])
def test_of_compressed_records_less_than_a_block_and_a_record_are_lost(size: int) -> None:
    packed = zstandard.compress(b"".join(RECORDS))[:size]
    data = whole_records(beginning("zstd", packed)).data
    assert data == b"".join(RECORDS[: len(data) // 1009]) and len(data) > len(packed) - 2**17 - 2000


def test_what_is_not_compressed_so_is_refused() -> None:
    with pytest.raises(zstandard.ZstdError):
        whole_records(beginning("zstd", b"rubbish" * 100))
    with pytest.raises(ValueError, match='compressed by "lz4"'):
        whole_records(beginning("lz4", b""))
