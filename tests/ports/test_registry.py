"""The ports that the options of `serve` ask for."""

import subprocess
import sys
from pathlib import Path

import pytest

from radar_service import plug_ins
from radar_service.commands.command_line import parser
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.recorder.service_recorder import RecorderPort
from radar_service.ports.registry import opened
from radar_service.ports.rest.rest_port import RestPort
from radar_service.terminal.arguments import UsageError


def names(*arguments: str) -> list[str]:
    with opened(parser().parse_args(["serve", *arguments])) as ports:
        return [port.name for port in ports]


def test_a_port_is_there_where_an_option_asks_for_it(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    assert names() == ["feed", "rest"] and not path.exists()
    assert names("--record", str(path)) == ["feed", "recorder", "rest"] and path.exists()
    with pytest.raises(FileExistsError):
        names("--record", str(path))
    with opened(parser().parse_args(["replay", str(path)])) as ports:
        assert [port.name for port in ports] == ["feed", "rest"]


def test_options_reach_their_ports(tmp_path: Path) -> None:
    record = ["--record", str(tmp_path / "a.mcap"), "--labels", "--powers", "1,257"]
    options = parser().parse_args(["serve", "--sandbox-all", "--scene-folder", str(tmp_path), *record])
    (tmp_path / "mine.toml").write_text('name = "mine"\n')
    with opened(options) as (_, recorder, rest):
        assert isinstance(rest, RestPort) and isinstance(recorder, RecorderPort)
        assert rest.store.scene_request("mine").sandboxed
        assert recorder.sources.labels and recorder.sources.powers == (1, 257)


def test_what_goes_with_a_recording_needs_one() -> None:
    for option in (["--labels"], ["--powers", "all"]):
        with pytest.raises(UsageError, match=rf"^{option[0]}: goes with --record FILE\.mcap"):
            names(*option)


def test_a_port_that_cannot_open_closes_those_before_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed = []
    monkeypatch.setattr(FeedPort, "close", lambda self: closed.append(self.name))
    with pytest.raises(FileNotFoundError):
        names("--record", "/proc/none/a.mcap")
    assert closed == ["feed"]


def test_options_of_ports_cost_no_command_the_import_of_a_server() -> None:
    code = "import sys; from radar_service.commands.command_line import parser; parser('serve'); print(*sys.modules)"
    imported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    packages = {plug_ins.entry("ports", name).module for name in plug_ins.names("ports")}
    assert packages <= set(imported) and not {"numpy", "fastapi", "uvicorn", "mcap", "trimesh"} & set(imported)
