"""The options of the command `serve`: who may do what."""

import argparse
import json
import math
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI

from radar_service.__main__ import main
from radar_service.commands.command_line import parser
from radar_service.commands.serve import OTHERS_NEED, SCENES_NEED, AccessError, StartError, access_for, serve
from radar_service.ports.http.server import MAX_PER_ADDRESS, Server
from radar_service.ports.port_host import PortHost
from radar_service.ports.registry import opened
from radar_service.service.access import Access
from radar_service.service.radio.scene_process import SceneProcess
from radar_service.service.radio.station import Stations
from radar_service.world.error import SceneError
from radar_service.world.scene import Scene
from tests.service.fake import FakeEngine

TOKEN = "0123456789abcdef"
SCENE = {"name": "empty", "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600}}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "one.json"
    path.write_text(json.dumps(SCENE))
    return path


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--host", "0.0.0.0"], ["--host: 0.0.0.0", "--token-file", "--insecure"]),
        (["--host", "::"], ["--host: ::"]),
        (["--host", "radar.example"], ["--host: radar.example"]),
        (["--token-file", "short"], ["short: token: 12 characters; 16 to 512"]),
        (["--token-file-for-reading", "long"], ["--token-file-for-reading: protects nothing"]),
        (["--token-file", "missing"], ["missing: No such file"]),
        (["--token-file", "empty"], ["empty: token: 0 characters"]),
    ],
)
def test_a_server_that_others_reach_is_protected_or_does_not_start(
    arguments: list[str], words: list[str], scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    for name, content in (("empty", ""), ("short", "short-secret"), ("long", TOKEN)):
        (tmp_path / name).write_text(content)
    monkeypatch.delattr("radar_service.commands.serve.ForkServer")
    assert main(["serve", str(scene), *arguments]) == 2
    message = capsys.readouterr().err
    assert all(word in message for word in words) and "short-secret" not in message and TOKEN not in message


def test_what_the_command_line_allows(tmp_path: Path) -> None:
    (tmp_path / "token").write_text(f"{TOKEN}\nnot this\n")

    def access(*arguments: str) -> Access:
        return access_for(parser().parse_args(["serve", *arguments]))

    assert access() == Access(None, None, frozenset({"127.0.0.1"}))
    assert access("--host", "0.0.0.0", "--insecure") == Access(None, None, frozenset({"0.0.0.0"}))
    guarded = access("--host", "0.0.0.0", "--token-file", str(tmp_path / "token"), "--allow-host", "Radar.LAN")
    assert guarded == Access(TOKEN, None, frozenset({"0.0.0.0", "radar.lan"}))
    (tmp_path / "reading").write_text(TOKEN[::-1])
    both = access("--token-file", str(tmp_path / "token"), "--token-file-for-reading", str(tmp_path / "reading"))
    assert both == Access(TOKEN, TOKEN[::-1], frozenset({"127.0.0.1"}))


def options(*arguments: str) -> argparse.Namespace:
    chosen = parser().parse_args(["serve", *arguments])
    chosen.scenes = chosen.scenes or ["harbour"]
    return chosen


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the server is given, as it runs its start and stops at once. "gives up": whether radars fail meanwhile."""
    seen: dict[str, Any] = {"gives up": False}

    async def at_once(self: Server, sockets: list[socket.socket]) -> None:
        self.started = True
        for listener in sockets:
            listener.close()
        seen["limits"] = self.config.http.keywords  # type: ignore[union-attr]
        if seen["gives up"]:
            for station in seen["stations"].values():
                station.failed()

    def app(stations: Stations, ports: PortHost, **others: Any) -> FastAPI:
        seen.update(others, stations=stations)
        return FastAPI()

    monkeypatch.setattr(Server, "serve", at_once)
    monkeypatch.setattr("radar_service.ports.running.create_app", app)
    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.setattr("gc.freeze", lambda: None)
    monkeypatch.setattr("radar_service.service.logs.configure", lambda style: None)
    return seen


def test_options_reach_radars_and_server(scene: Path, seen: dict[str, Any]) -> None:
    seen["gives up"] = True
    chosen = options(str(scene), str(scene), "--pace", "max", "--truth", "--port", "0", "--connections", "7",
                     "--exit-when-failed")  # fmt: skip
    assert serve(chosen, FakeEngine, opened) == 1  # as all radars have failed
    assert [station.identity for station in seen["stations"].values()] == ["0", "1"]
    assert all(station.allow_truth and math.isinf(station.settings.pace.factor) for station in seen["stations"].values())
    assert (seen["limits"]["connections"], seen["limits"]["per_address"]) == (7, MAX_PER_ADDRESS)
    assert seen["access"] == access_for(chosen)


def test_with_blind_nobody_commands_and_readers_may_be_lossless(scene: Path, seen: dict[str, Any]) -> None:
    assert serve(options(str(scene), "--port", "0", "--blind", "--exit-when-failed"), FakeEngine, opened) == 0
    assert seen["access"].lossless and not seen["access"].may("read", "command")
    assert all(station.epoch.is_blind for station in seen["stations"].values())
    with pytest.raises(AccessError, match="--blind: --truth tells all; leave one of them out"):
        serve(options(str(scene), "--blind", "--truth"), FakeEngine, opened)


def several(tmp_path: Path, *ids: str) -> str:
    path = tmp_path / f"{'-'.join(ids)}.json"
    path.write_text(json.dumps(SCENE | {"radar": [{"id": each, **SCENE["radar"]} for each in ids]}))  # type: ignore[dict-item]
    return str(path)


def test_each_radar_of_a_scene_is_on_the_air(scene: Path, tmp_path: Path, seen: dict[str, Any]) -> None:
    """Radars of one scene share a world under their ids; that of a scene without ids has the number of its scene."""
    chosen = options(several(tmp_path, "bow", "0"), str(scene), several(tmp_path, "mast"), "--port", "0")
    assert serve(chosen, FakeEngine, opened) == 0
    stations = list(seen["stations"].values())
    assert [station.identity for station in stations] == ["bow", "0", "1", "mast"]
    assert [station.name for station in stations] == ["radar bow", "radar 0", "radar 1", "radar mast"]
    assert [station.epoch.info.scene.radar_id for station in stations] == ["bow", "0", "0", "mast"]
    assert stations[0].group is stations[1].group and len({station.group for station in stations}) == 3
    assert stations[0].transmitter.pacer.group_clock is stations[1].transmitter.pacer.group_clock
    assert len({station.epoch.spoke_source.process for station in stations}) == 4


def test_two_radars_with_one_id_are_refused(tmp_path: Path, seen: dict[str, Any]) -> None:
    chosen = options(several(tmp_path, "bow", "aft"), several(tmp_path, "mast", "aft"), "--port", "0")
    with pytest.raises(SceneError, match='radar.id: "aft" is the id of two radars; ids are unique on a server'):
        serve(chosen, FakeEngine, opened)


NOT_AT_A_START = {"PIL", "matplotlib", "pyproj", "scipy.interpolate", "scipy.ndimage", "scipy.stats",
                  "trimesh"}  # fmt: skip


def imported(*modules: tuple[str, ...]) -> list[set[str]]:
    """What a process has imported after some modules, and after others too."""
    code = "import sys\n" + "\n".join(f"import {', '.join(some)}; print(*sys.modules)" for some in modules)
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    return [set(line.split()) for line in printed.splitlines()]


def test_a_start_waits_for_no_module_that_it_does_not_need() -> None:
    """What only some scenes need comes when there is nothing to do: else each process of such a scene would import it again."""
    scenes, others = imported(SCENES_NEED, OTHERS_NEED)
    assert not ({"fastapi", "uvicorn"} | NOT_AT_A_START) & scenes
    assert {"pyproj", "scipy.interpolate", "trimesh", "PIL"} <= others
    (serving,) = imported(("radar_service.__main__", "radar_service.ports.app"))
    assert not ({"scipy", "embreex", "radar_service.simulator"} | NOT_AT_A_START) & serving


def failing(of: Scene) -> FakeEngine:
    """An engine that the radar "mast" cannot have; another process finds it by its name."""
    if of.radar_id == "mast":
        raise RuntimeError("the mast is down")
    return FakeEngine(of)


def test_where_one_radar_of_a_scene_fails_at_the_start_all_are_ended(
    tmp_path: Path, seen: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    ended: list[str] = []
    close = SceneProcess.close

    def noted(self: SceneProcess) -> None:
        ended.append(self.info.scene.radar_id)
        close(self)

    monkeypatch.setattr(SceneProcess, "close", noted)
    with pytest.raises(StartError, match="the mast is down"):
        serve(options(several(tmp_path, "bow", "mast", "aft"), "--port", "0"), failing, opened)
    assert sorted(ended) == ["aft", "bow"]
