"""Where chunks are: whole files, files cut anywhere, damaged ones, and files that are no recordings."""

import random
from pathlib import Path

import pytest

from radar_service.recording import RecordingError, read
from radar_service.recording.chunk_table import ChunkTable
from radar_service.recording.mcap_library import Writer


def test_a_file_that_is_cut_anywhere_opens_up_to_its_last_whole_chunk(recording: Path, tmp_path: Path) -> None:
    data, cut = recording.read_bytes(), tmp_path / "cut.mcap"
    chunks = ChunkTable(recording).chunks
    assert len(chunks) >= 3  # one a scan: what is lost is never more
    ends, whole = [place.offset + place.length for place in chunks], list(read(recording).spokes())
    drawn = random.Random(1).sample(range(len(data)), 60)
    index = range(ends[1], ends[1] + 240, 9)  # of its messages, behind the second chunk
    for size in sorted(
        {*drawn, *index, 0, 1, 7, 8, *ends, *(end - 1 for end in ends), *(end + 1 for end in ends), len(data) - 1}
    ):
        cut.write_bytes(data[:size])
        count = sum(end <= size for end in ends)
        if not count:
            with pytest.raises(RecordingError, match="no MCAP file" if size < 8 else "ends before its first chunk"):
                ChunkTable(cut)
            continue
        assert len(ChunkTable(cut).chunks) == count
        got = list(read(cut).spokes())
        assert [spoke.field.tobytes() for spoke in got] == [spoke.field.tobytes() for spoke in whole[: len(got)]]
        assert len(got) == 64 * count  # each scan ends a chunk
        assert len(read(cut).truth_lines(count - 1)) == len(read(recording).truth_lines(count - 1))


@pytest.mark.parametrize("tail", [b"\0" * 5000, b"\x06" + b"\xff" * 400, b"rubbish" * 100], ids=["zeros", "endless", "text"])
def test_rubbish_behind_the_last_whole_chunk_is_ignored(recording: Path, tail: bytes, tmp_path: Path) -> None:
    second = ChunkTable(recording).chunks[1]
    (path := tmp_path / "tail.mcap").write_bytes(recording.read_bytes()[: second.offset + second.length] + tail)
    assert len(list(read(path).spokes())) == 128


def test_a_long_tail_of_zeros_is_not_searched(recording: Path, tmp_path: Path) -> None:
    """As of a file whose space was reserved: 2 GiB, which would take minutes."""
    second = ChunkTable(recording).chunks[1]
    (path := tmp_path / "tail.mcap").write_bytes(recording.read_bytes()[: second.offset + second.length])
    with path.open("r+b") as file:
        file.truncate(2**31)
    assert len(ChunkTable(path).chunks) == 2


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
