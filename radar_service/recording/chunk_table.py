"""Where the chunks of an MCAP file are. A file that was cut short has those that are whole, and the beginning of one more.

The table comes from the records' heads alone, not from the index at the end, which such a file lacks; this takes two reads a
chunk. The package `mcap` takes chunks apart and checks their sums.

A chunk within which a file ends is one frame of zstd, whose blocks hold at most 128 KiB: what the file has of whole blocks can
be read.
"""

import contextlib
import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import zstandard

from radar_service.recording.error import RecordingError
from radar_service.recording.mcap_library import (
    MCAP0_MAGIC,
    Channel,
    Chunk,
    Header,
    Message,
    Opcode,
    ReadDataStream,
    breakup_chunk,
)
from radar_service.recording.recording_file import NANOSECONDS, PROFILE

HEAD = struct.Struct("<BQ")  # of a record: opcode, length
TIMES = struct.Struct("<QQQ")  # of a chunk: first and last log time [ns], size [bytes] before compression
INDEXED = struct.Struct("<H")  # the channel of a message index
MAX_CHUNK = 2**30  # bytes before compression; a recording's are of 1 MiB
FORMAT = 1  # of the scene's messages that this version reads


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


@dataclass(frozen=True)
class ChunkPlace:
    """A chunk: where its record's content begins and its length [bytes], and log times of its first and last message [s].

    is_cut: whether the file ends within it; channels: numbers of those that it has messages of, empty where their index was cut
    off.
    """

    offset: int
    length: int
    start: float
    end: float
    is_cut: bool = False
    channels: set[int] = field(default_factory=set)


class ChunkTable:
    """The chunks of a recording in their order, and the numbers of its channels by topic.

    Raises RecordingError where the file is no recording, or ends before its first message, and OSError.
    """

    def __init__(self, path: Path) -> None:
        self._path, self.chunks = path, list[ChunkPlace]()
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise RecordingError(f"{path}: this is no MCAP file; give one that `radar-service record` wrote")
            if not self._fill(file) and self.chunks:
                self.chunks[-1].channels.clear()  # its index may not be whole
        if not self.chunks:
            raise RecordingError(
                f"{path}: the file ends before its first message, so nothing of it can be read; record again"
            )
        self.channels: dict[str, int] = {}
        for place in self.chunks:
            if place is self.chunks[0] or not place.channels <= set(self.channels.values()):  # another scene brings radars
                channels = [record for record in self.records(place) if isinstance(record, Channel)]
                self.channels.update((channel.topic, channel.id) for channel in channels)

    def records(self, place: ChunkPlace) -> list[Channel | Message]:
        """Returns the channels and messages of a chunk. Raises RecordingError where it is damaged."""
        with self._path.open("rb") as file:
            file.seek(place.offset)
            content = file.read(place.length)
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(content)))
            records = breakup_chunk(whole_records(chunk) if place.is_cut else chunk, validate_crc=True)
        except Exception as error:  # the package raises what its parts raise
            raise RecordingError(
                f"{self._path}: the chunk at byte {place.offset} is damaged ({error}); copy the file again"
            ) from None
        return [record for record in records if isinstance(record, Channel | Message)]

    def messages(self, topic: str, chunks: range | None = None, start: float = 0.0) -> Iterator[Message]:
        """Yields the messages of a channel in their order; none where the file ends before it names that channel.

        chunks: by their indices, by default all; start: chunks that end before it are left out [s].
        """
        channel = self.channels.get(topic)
        for k in range(len(self.chunks)) if chunks is None else chunks:
            place = self.chunks[k]
            if place.end >= start and (channel in place.channels or not place.channels):
                yield from (
                    record for record in self.records(place) if isinstance(record, Message) and record.channel_id == channel
                )

    def _fill(self, file: BinaryIO) -> bool:
        """Reads the heads of the records up to the end, or to the first that is not whole; returns whether it is the end."""
        size, position = file.seek(0, 2), len(MCAP0_MAGIC)
        while position + HEAD.size <= size:
            file.seek(position)
            opcode, length = HEAD.unpack(file.read(HEAD.size))
            position += HEAD.size
            if position + length > size and opcode == Opcode.CHUNK:
                return self._add_cut(file, position, size - position)
            if position + length > size or opcode in (0, Opcode.DATA_END):
                return bool(opcode == Opcode.DATA_END)
            if opcode == Opcode.HEADER:
                self._check_profile(file.read(length))
            elif opcode == Opcode.CHUNK and length >= TIMES.size:
                self.chunks.append(self._place(file, position, length, False))
            elif opcode == Opcode.MESSAGE_INDEX and self.chunks and length >= INDEXED.size:
                self.chunks[-1].channels.update(INDEXED.unpack(file.read(INDEXED.size)))
            position += length
        return False

    def _place(self, file: BinaryIO, position: int, length: int, is_cut: bool) -> ChunkPlace:
        """Returns the chunk whose content begins there, where the file is. Raises RecordingError."""
        start, end, unpacked = TIMES.unpack(file.read(TIMES.size))
        if unpacked > MAX_CHUNK:
            raise RecordingError(
                f"{self._path}: the chunk at byte {position} has {unpacked} bytes; at most {MAX_CHUNK} are allowed"
            )
        return ChunkPlace(position, length, start / NANOSECONDS, end / NANOSECONDS, is_cut)

    def _add_cut(self, file: BinaryIO, position: int, length: int) -> bool:
        """Adds the chunk within which the file ends, where some of it can be read; returns whether it does."""
        with contextlib.suppress(RecordingError):
            if length >= TIMES.size and self.records(place := self._place(file, position, length, True)):
                self.chunks.append(place)
                return True  # the index of the chunk before it is whole
        return False

    def _check_profile(self, content: bytes) -> None:
        try:
            profile = Header.read(ReadDataStream(BytesIO(content))).profile
        except Exception as error:  # as above
            raise RecordingError(f"{self._path}: the head of the file is damaged ({error}); copy the file again") from None
        if profile != PROFILE:
            raise RecordingError(
                f'{self._path}: an MCAP file of profile "{profile[:40]}", not "{PROFILE}"; give a recording of a radar'
            )


@dataclass(frozen=True)
class RecordedEpoch:
    """An epoch: what is computed, as `radar_recording.scene_record` says, and the indices of its chunks."""

    record: Mapping[str, Any]
    chunks: range

    @property
    def name(self) -> str:
        """The epoch's name in the feed's messages."""
        return str(self.record["epoch"])


def recorded_radars(table: ChunkTable) -> list[str]:
    """Returns the radars of a recording."""
    return [topic.split("/")[2] for topic in table.channels if topic.startswith("/radar/") and topic.endswith("/feed")]


def epochs_of(table: ChunkTable, radar: str) -> list[RecordedEpoch]:
    """Returns the epochs of a radar, none where the file ends before its first one.

    Raises RecordingError for a radar that the recording lacks, and for another format.
    """
    if radar not in recorded_radars(table):
        raise RecordingError(
            f'radar: the recording has no "{radar[:40]}"; it has {", ".join(recorded_radars(table)) or "none"}'
        )
    scenes = list[tuple[int, dict[str, Any]]]()
    for k in range(len(table.chunks)):
        scenes += [(k, json.loads(message.data)) for message in table.messages(f"/radar/{radar}/scene", range(k, k + 1))]
    for _, record in scenes:
        if record.get("format") != FORMAT:
            raise RecordingError(
                f"format: {record.get('format')} is not {FORMAT}; read it with the version that recorded it"
            )
    ends = [*(k + 1 for k, _ in scenes), len(table.chunks)][1:]
    return [RecordedEpoch(record, range(k, end)) for (k, record), end in zip(scenes, ends, strict=True)]


def radars_with_epoch(table: ChunkTable, number: int) -> list[str]:
    """Returns the radars that have an epoch of this number, from 0: a file that was cut short may lack that of some.

    Where none has it all radars are returned, so that the first one is refused with its reason. Raises RecordingError.
    """
    radars = recorded_radars(table)
    return [radar for radar in radars if number < len(epochs_of(table, radar))] or radars
