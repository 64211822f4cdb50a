"""The command `replay` as a user runs it, and its arguments."""

import argparse
import asyncio
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import pytest

from clients.ppi.client import FeedClient
from radar_service import wire
from radar_service.__main__ import main
from radar_service.commands.command_line import parser
from radar_service.commands.replay import seconds
from radar_service.recording import read
from radar_service.recording.chunk_table import ChunkTable
from radar_service.recording.replay_station import ReplaySpokeSource
from radar_service.records import SpokeBlock
from tests.ports.asterix.reading import videos
from tests.ports.nmea.test_senders import free_port
from tests.ports.udp.test_capture import frames
from tests.recording.scenes import AZIMUTHS, MOVING, spokes_of


def test_a_running_service_is_recorded_and_replayed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over sockets: what a lossless client of `serve --record` receives is what one of `replay` receives."""
    (tmp_path / "scene.json").write_text(json.dumps(MOVING))
    path = tmp_path / "live.mcap"
    video = ["--asterix", str(free_port()), "--pcap"]
    captures = [tmp_path / name for name in ("live.pcap", "again.pcap")]
    live = listened(
        ["serve", str(tmp_path / "scene.json"), "--record", str(path), "--truth", *video, str(captures[0])], 3 * AZIMUTHS
    )
    again = listened(["replay", str(path), *video, str(captures[1])], 3 * AZIMUTHS)
    assert len(live) == 3 * AZIMUTHS and again == live
    sent, replayed = (
        {each.sequence: each for each in videos([frame[42:] for _, frame in frames(file)])} for file in captures
    )
    both = sent.keys() & replayed.keys()
    assert len(both) >= 3 * AZIMUTHS and all(sent[number] == replayed[number] for number in both)
    assert next(later(path, monkeypatch)).field[0].tobytes() == next(spoke["data"] for spoke in live if spoke["time"] >= 2)
    assert read(path).truth_lines(0) and ChunkTable(path).channels["/radar/0/ppi"]


def later(path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SpokeBlock]:
    """The spokes that `replay --from 2` hands to its server."""
    given: list[ReplaySpokeSource] = []

    def serve(options: Any, access: Any, scenes: Callable[[], list[list[ReplaySpokeSource]]], *others: Any) -> int:
        given.extend(source for scene in scenes() for source in scene)
        return 0

    monkeypatch.setattr("radar_service.ports.running.run", serve)
    monkeypatch.setattr("radar_service.commands.replay.ForkServer", lambda *modules: MagicMock())
    assert main(["replay", str(path), "--from", "2"]) == 0
    return given[0].blocks(size=1)


def listened(command: list[str], count: int) -> list[dict[str, Any]]:
    """The first spokes of a service that waits for its client; the service is stopped and must end well."""
    options = ["--port", "0", "--pace", "max", "--wait-for", "1"]
    service = subprocess.Popen(
        [sys.executable, "-m", "radar_service", *command, *options], stdout=subprocess.PIPE, text=True
    )
    assert service.stdout is not None
    try:
        address = service.stdout.readline().split("open http://")[1].strip().rstrip("/")
        return asyncio.run(asyncio.wait_for(_listen(address, count), 60))
    finally:
        service.terminate()
        service.communicate(timeout=60)
        assert service.returncode in (0, -15)


async def _listen(address: str, count: int) -> list[dict[str, Any]]:
    got: list[bytes] = []
    async with FeedClient(f"ws://{address}", encoding="c64", mode="lossless") as messages:
        number = 0
        async for message in messages.messages():
            if message["type"] == "spokes":
                got.append(wire.pack(message))
                number += message["count"]
            if number >= count:
                break
    return [spoke for spoke in spokes_of(got) if spoke["number"] < count]


def test_the_command_refuses_rubbish(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path := tmp_path / "a.mcap").write_text("rubbish")
    assert main(["replay", str(path)]) == 2
    assert capsys.readouterr().err == f"{path}: this is no MCAP file; give one that `radar-service record` wrote\n"
    assert main(["replay", str(tmp_path / "none.mcap")]) == 2
    assert "none.mcap: there is no such file; give a recording" in capsys.readouterr().err


def test_what_it_takes() -> None:
    options = ["replay", "a.mcap", "--from", "2.5", "--epoch", "1", "--pace", "max", "--wait-for", "2"]
    replay = parser("replay").parse_args(options)
    assert (replay.recording, replay.start, replay.epoch, replay.wait_for) == (Path("a.mcap"), 2.5, 1, 2)
    with pytest.raises(SystemExit):
        parser("replay").parse_args(["replay"])


def test_a_time_is_a_number_from_0() -> None:
    assert seconds("0") == 0.0 and seconds("1e3") == 1000.0
    for text in ("-1", "nan", "inf", "soon"):
        with pytest.raises(argparse.ArgumentTypeError, match=f"{text} is not allowed; a time of 0 s or more"):
            seconds(text)
