"""Where chunks are: whole files, files cut anywhere, damaged ones, and files that are no recordings."""

import os
import random
from pathlib import Path

import pytest
import zstandard

from radar_service.recording import RecordingError, read
from radar_service.recording.chunk_table import HEAD, ChunkTable, whole_records
from radar_service.recording.mcap_library import Chunk, CompressionType, Writer
from radar_service.recording.recording_file import RecordingFile

CONTENT = 40  # bytes of a message
KINDS = {
    "compressed": (CompressionType.ZSTD, ("/radar/0/feed", "/radar/0/scene", "/radar/0/truth")),
    "plain": (CompressionType.NONE, ("/radar/0/feed", "/radar/0/scene", "/radar/0/sources")),
    "two radars": (CompressionType.NONE, ("/radar/a/feed", "/radar/b/feed", "/radar/a/scene", "/radar/b/scene")),
}


def small_file(path: Path, compression: CompressionType, topics: tuple[str, ...]) -> list[tuple[str, bytes]]:
    """Writes two chunks with messages of all topics; returns the messages in their order."""
    drawn, messages = random.Random(4), list[tuple[str, bytes]]()
    with path.open("wb") as file:
        writer = Writer(file, compression=compression)
        writer.start("radar-service")
        schema = writer.register_schema("line", "jsonschema", b"{}")
        channels = {topic: writer.register_channel(topic, "json", schema) for topic in topics}
        for time in range(2):
            for topic, channel in channels.items():
                messages.append((topic, drawn.randbytes(CONTENT)))
                writer.add_message(channel, time * 10**9, messages[-1][1], time * 10**9)
            writer.flush()  # type: ignore[no-untyped-call]
        writer.finish()  # type: ignore[no-untyped-call]
    return messages


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_that_is_cut_at_any_byte_has_the_messages_before_it(kind: str, tmp_path: Path) -> None:
    compression, topics = KINDS[kind]
    messages = small_file(path := tmp_path / "whole.mcap", compression, topics)
    data, chunks = path.read_bytes(), ChunkTable(path).chunks
    ends = [data.index(content) + CONTENT if kind != "compressed" else 0 for _, content in messages]
    if kind == "compressed":  # each chunk is one block of zstd
        ends = [place.offset + place.length for place in chunks for _ in topics]
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data)
    for size in reversed(range(len(data))):
        os.truncate(cut, size)
        before = sum(end <= size for end in ends)
        try:
            table = ChunkTable(cut)
        except RecordingError as error:
            assert before == 0 and ("ends before its first message" in str(error) or size < 8), size
            continue
        for topic in topics:
            expected = [content for name, content in messages[:before] if name == topic]
            assert [message.data for message in table.messages(topic)] == expected, size


@pytest.mark.parametrize("kind", ["recording", "labelled_recording", "documented_recording"])
def test_a_recording_that_is_cut_anywhere_is_read_up_to_there(
    kind: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    recording: Path = request.getfixturevalue(kind)
    data, cut, chunks = recording.read_bytes(), tmp_path / "cut.mcap", ChunkTable(recording).chunks
    assert len(chunks) == 4  # what the epoch is of, and one a scan
    ends, whole = [place.offset + place.length for place in chunks], list(read(recording).spokes())
    index = range(ends[1], ends[1] + 240, 24)  # of its messages, behind the second chunk
    near = {end + step for end in ends for step in (-1, 0, 1)}
    for size in sorted({*random.Random(1).sample(range(ends[0], len(data)), 12), *index, *near, len(data) - 1}):
        cut.write_bytes(data[:size])
        if size < ends[0]:
            with pytest.raises(RecordingError, match="ends before its first message"):
                read(cut)
            continue
        got, scans = list(read(cut).spokes()), sum(end <= size for end in ends[1:])
        assert [spoke.field.tobytes() for spoke in got] == [spoke.field.tobytes() for spoke in whole[: len(got)]]
        assert len(got) >= 64 * scans, size
        if scans:
            assert len(read(cut).truth_lines(scans - 1)) == len(read(recording).truth_lines(scans - 1))


def test_a_cut_within_a_chunk_of_many_blocks_loses_less_than_a_block(tmp_path: Path) -> None:
    """Messages of 1 KiB that do not compress, in one chunk of 800 KiB."""
    drawn, path = random.Random(3), tmp_path / "long.mcap"
    contents = [drawn.randbytes(1024) for _ in range(800)]
    with RecordingFile(path) as file:
        write = file.channel("/radar/0/feed", "msgpack")
        for content in contents:
            write(0.0, 0.0, content)
    (place,), data = ChunkTable(path).chunks, path.read_bytes()
    for size in (drawn.randrange(place.offset, place.offset + place.length) for _ in range(20)):
        path.write_bytes(data[:size])
        try:
            got = [message.data for message in ChunkTable(path).messages("/radar/0/feed")]
        except RecordingError:
            got = []
        assert got == contents[: len(got)] and 1024 * len(got) > size - place.offset - 2**17 - 2**15, size


@pytest.mark.parametrize("tail", [b"\0" * 5000, b"\x06" + b"\xff" * 400, b"rubbish" * 100], ids=["zeros", "endless", "text"])
def test_rubbish_behind_the_last_whole_chunk_is_ignored(recording: Path, tail: bytes, tmp_path: Path) -> None:
    third = ChunkTable(recording).chunks[2]
    (path := tmp_path / "tail.mcap").write_bytes(recording.read_bytes()[: third.offset + third.length] + tail)
    assert len(list(read(path).spokes())) == 128


def test_a_long_tail_of_zeros_is_not_searched(recording: Path, tmp_path: Path) -> None:
    """As of a file whose space was reserved: 2 GiB, which would take minutes."""
    third = ChunkTable(recording).chunks[2]
    (path := tmp_path / "tail.mcap").write_bytes(recording.read_bytes()[: third.offset + third.length])
    with path.open("r+b") as file:
        file.truncate(2**31)
    assert len(ChunkTable(path).chunks) == 3


def test_a_damaged_chunk_is_named(recording: Path, tmp_path: Path) -> None:
    data, place = bytearray(recording.read_bytes()), ChunkTable(recording).chunks[1]
    data[place.offset + place.length // 2] ^= 0xFF
    (path := tmp_path / "damaged.mcap").write_bytes(data)
    with pytest.raises(RecordingError, match=f"the chunk at byte {place.offset} is damaged"):
        list(read(path).spokes())


def test_a_chunk_that_claims_too_much_is_refused(recording: Path, tmp_path: Path) -> None:
    data, place = bytearray(recording.read_bytes()), ChunkTable(recording).chunks[0]
    data[place.offset + 16 : place.offset + 24] = (2**50).to_bytes(8, "little")
    (path := tmp_path / "bomb.mcap").write_bytes(data)
    with pytest.raises(RecordingError, match="at most 1073741824 are allowed"):
        read(path)


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0", b"not a recording at all", bytes(range(256)) * 40])
def test_what_is_no_recording_is_refused_in_a_sentence(content: bytes, tmp_path: Path) -> None:
    (path := tmp_path / "rubbish.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match="rubbish.mcap: this is no MCAP file; give one that"):
        read(path)


def test_a_recording_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2")
        writer.add_message(writer.register_channel("/x", "json", 0), 0, b"{}", 0)
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(RecordingError, match='profile "ros2", not "radar-service"'):
        read(path)


def test_rubbish_in_any_byte_is_a_recording_error_or_changes_nothing(recording: Path, tmp_path: Path) -> None:
    """No other exception, whatever byte is wrong; but for the sums of chunks, wrong samples would pass."""
    data, drawn = recording.read_bytes(), random.Random(2)
    path = tmp_path / "wrong.mcap"
    whole = [spoke.field.tobytes() for spoke in read(recording).spokes()]
    for _ in range(60):
        wrong = bytearray(data)
        wrong[drawn.randrange(len(data))] ^= 1 << drawn.randrange(8)
        path.write_bytes(wrong)
        try:
            got = [spoke.field.tobytes() for spoke in read(path).spokes()]
        except RecordingError:
            continue
        assert got == whole[: len(got)]


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
