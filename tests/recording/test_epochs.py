"""The epochs of a recording."""

import json
from pathlib import Path

import pytest

from radar_service.recording import RecordingError
from radar_service.recording.chunk_table import ChunkTable, epochs_of, radars_with_epoch, recorded_radars
from radar_service.recording.recording_file import RecordingFile


def written(path: Path, *scenes: dict[str, object]) -> ChunkTable:
    """A file with the scenes of a radar and nothing else, each in a chunk of its own."""
    with RecordingFile(path) as file:
        file.channel("/radar/west/feed", "msgpack")
        write = file.channel("/radar/west/scene", "json")
        for scene in scenes:
            write(0.0, 0.0, json.dumps(scene).encode())
            file.flush()
    return ChunkTable(path)


def test_an_epoch_reaches_into_the_chunk_of_the_next(tmp_path: Path) -> None:
    table = written(tmp_path / "a.mcap", {"format": 1, "epoch": "x"}, {"format": 1, "epoch": "y"})
    assert recorded_radars(table) == ["west"]
    assert [(epoch.name, list(epoch.chunks)) for epoch in epochs_of(table, "west")] == [("x", [0, 1]), ("y", [1])]


def test_another_format_is_refused(tmp_path: Path) -> None:
    table = written(tmp_path / "a.mcap", {"format": 2, "epoch": "x"})
    with pytest.raises(RecordingError, match="format: 2 is not 1; read it with the version that recorded it"):
        epochs_of(table, "west")


def test_another_radar_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match='has no "0"; it has west'):
        epochs_of(written(tmp_path / "a.mcap", {"format": 1, "epoch": "x"}), "0")


def test_a_radar_whose_epoch_was_cut_off_is_left_out(tmp_path: Path) -> None:
    with RecordingFile(path := tmp_path / "two.mcap") as file:
        writers = {}
        for radar in ("east", "west"):
            file.channel(f"/radar/{radar}/feed", "msgpack")
            writers[radar] = file.channel(f"/radar/{radar}/scene", "json")
        for radar, epoch in (("east", "x"), ("west", "x"), ("west", "y")):
            writers[radar](0.0, 0.0, json.dumps({"format": 1, "epoch": epoch}).encode())
            file.flush()
    table = ChunkTable(path)
    assert [radars_with_epoch(table, number) for number in range(3)] == [["east", "west"], ["west"], ["east", "west"]]
    path.write_bytes(path.read_bytes()[: table.chunks[1].offset])
    cut = ChunkTable(path)
    assert recorded_radars(cut) == ["east", "west"] and radars_with_epoch(cut, 0) == ["east"]
