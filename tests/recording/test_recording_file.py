"""The file: what other readers of MCAP find in it, and what happens where the disk refuses."""

import errno
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from radar_service.recording import read
from radar_service.recording.recording_file import RecordingFile


def test_another_reader_finds_channels_times_and_messages(tmp_path: Path) -> None:
    with RecordingFile(tmp_path / "a.mcap") as file:
        plain, described = file.channel("/x", "msgpack"), file.channel("/y", "json", {"title": "Y", "type": "object"})
        plain(1.5, 0.5, b"one")
        described(2.0, 1.0, b"{}")
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        got = [
            (schema and schema.name, channel.topic, m.log_time, m.publish_time, m.data)
            for schema, channel, m in reader.iter_messages()
        ]
        assert reader.get_header().profile == "radar-service"
    assert got == [(None, "/x", 1_500_000_000, 500_000_000, b"one"), ("Y", "/y", 2_000_000_000, 1_000_000_000, b"{}")]


def test_a_full_disk_names_the_file_and_closing_says_no_more(tmp_path: Path) -> None:
    (path := tmp_path / "full.mcap").symlink_to("/dev/full")
    with RecordingFile(path) as file:
        write = file.channel("/x", "msgpack")
        with pytest.raises(OSError, match="No space left on device") as caught:
            write(0.0, 0.0, bytes(2**20))
            file.flush()
        assert caught.value.errno == errno.ENOSPC and caught.value.filename == str(path)


def test_the_command_tells_a_limit_of_file_sizes_and_the_rest_opens(tmp_path: Path, one_target: Path) -> None:
    """As a full disk: the process may write 300 kB."""
    command = [
        sys.executable,
        "-m",
        "radar_service",
        "record",
        str(one_target),
        "--scans",
        "9",
        "-o",
        str(tmp_path / "a.mcap"),
    ]
    limit: Any = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))  # noqa: E731
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, preexec_fn=limit)
    assert result.returncode == 2 and f"{tmp_path / 'a.mcap'}: File too large" in result.stderr
    assert "Traceback" not in result.stderr
    spokes = len(list(read(tmp_path / "a.mcap").spokes()))
    assert spokes and spokes % 60 == 0
