"""The epochs of one radar in a recording."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from radar_service.recording.chunk_table import ChunkTable
from radar_service.recording.error import RecordingError

FORMAT = 1  # of the scene's messages that this version reads


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
