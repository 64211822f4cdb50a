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
from tests.ports.nmea.test_senders import free_port


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


def test_sockets_are_open_while_their_ports_are() -> None:
    given = {f"--{name}": str(free_port()) for name in ("nmea-tcp", "ais-tcp", "nmea-in-tcp", "nmea-in-udp")}
    words, free = [word for option in given.items() for word in option], str(free_port())
    with opened(parser().parse_args(["serve", *words, "--nmea-udp", "9", "--ais-udp", "9"])) as ports:
        assert [port.name for port in ports] == ["ais", "feed", "nmea", "nmea-in", "rest"]
        for option, port in given.items():
            with pytest.raises(UsageError, match=f"{option}: 127.0.0.1:{port} cannot be opened"):
                names("--nmea-tcp", free, option, port)
    assert len(names(*words)) == len(names("--nmea-tcp", free)) + 2 == 5  # all were closed


@pytest.mark.parametrize(
    "option", [*(f"{name}-{by}" for name in ("nmea", "ais", "nmea-in") for by in ("tcp", "udp")), "asterix", "asterix-plots"]
)
def test_beyond_this_machine_no_option_opens_a_port_alone(option: str) -> None:
    others_come = "-in-" in option or option.endswith("tcp")
    allow = "--asterix-allow" if option.startswith("asterix") else "--nmea-allow"
    needs = f"--{option}: .* beyond this machine, and nothing asks for a login.*{allow}"
    where = f"{'0.0.0.0' if others_come else '10.0.0.2'}:{free_port()}"
    for token in ([], ["--token-file", "t"]):
        with pytest.raises(UsageError, match=needs):
            names(f"--{option}", where, *token)
    for also in (["--nmea-allow", "10.0.0.2"], ["--insecure"]) if others_come else ():
        assert len(names(f"--{option}", where, *also)) == 3


def test_options_of_ports_cost_no_command_the_import_of_a_server() -> None:
    code = "import sys; from radar_service.commands.command_line import parser; parser('serve'); print(*sys.modules)"
    imported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    packages = {plug_ins.entry("ports", name).module for name in plug_ins.names("ports")}
    assert packages <= set(imported) and not {"numpy", "fastapi", "uvicorn", "mcap", "trimesh"} & set(imported)
