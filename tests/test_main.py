"""The command line: what it writes, what it refuses, and one whole service over loopback, from start to SIGTERM."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from websockets.asyncio.client import connect

import radar_service as rs
from radar_service import wire
from radar_service.__main__ import main
from radar_service.commands.command_line import parser
from radar_service.numerics.arithmetic_name import arithmetic
from tests.scenes import ONE_TARGET


def test_threads_reach_the_engine(one_target: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    requested: list[int] = []

    def interrupted(self: rs.Simulator, scene: rs.Scene, fidelity: str, seed: int, threads: int, **others: bool) -> None:
        requested.append(threads)
        raise KeyboardInterrupt

    monkeypatch.setattr(rs.Simulator, "__init__", interrupted)
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    for threads in ("1", "3", "auto"):
        assert main(["scan", str(one_target), "-o", str(tmp_path / "x.npz"), "--threads", threads]) == 130
    monkeypatch.setattr(
        "radar_service.commands.serve.serve", lambda options, make, ports: requested.append(make.threads) or 0
    )
    assert main(["serve", str(one_target), "--threads", "2"]) == 0
    assert requested == [1, 3, 3, 2]
    assert parser().parse_args(["serve"]).threads == 1


@pytest.mark.parametrize("command", ["check", "plan", "serve", "scan"])
def test_a_bad_scene_is_refused_on_stderr(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text("[radar]\nazimuths = 1_000_000_000\nrpm = -1\n")
    more = ["-o", str(tmp_path / "x.npz")] if command == "scan" else []
    assert main([command, str(bad), *more]) == 2
    output = capsys.readouterr()
    lines = output.err.splitlines()
    assert output.out == "" and lines[0].startswith("radar.azimuths") and lines[1].startswith("radar.rpm")
    assert not (tmp_path / "x.npz").exists()


@pytest.mark.parametrize(("option", "name"), [("-o", "x.npz"), ("--png", "x.png")])
def test_a_folder_that_cannot_be_is_named_before_anything_is_computed(
    option: str,
    name: str,
    one_target: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr(rs.Simulator, "blocks")
    missing = one_target / name
    assert main(["scan", str(one_target), "-o", str(tmp_path / "x.npz"), option, str(missing)]) == 2
    assert str(missing.parent) in capsys.readouterr().err


def test_a_port_in_use_is_named(one_target: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["serve", str(one_target), "--port", str(port)]) == 2
    assert capsys.readouterr().err.startswith(f"127.0.0.1:{port}: ")


def test_a_reader_that_has_gone_ends_a_command_without_a_word(one_target: Path) -> None:
    """As in `radar-service check SCENE | head -0`: the pipe is closed before anything is written."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "radar_service", "check", str(one_target)]
    with os.fdopen(writer, "wb") as pipe:
        ended = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE)
    assert (ended.returncode, ended.stderr) == (141, b"")


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0 and capsys.readouterr().out == f"radar-service {rs.__version__}\n"
    assert rs.__version__ == version("radar-service")


@pytest.fixture
def service(one_target: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A service with two radars on a free port, and its address."""
    words = ["serve", str(one_target), str(one_target), "--port", "0", "--pace", "5"]
    command = [sys.executable, "-W", "error", "-m", "radar_service", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("radar on the air: open http://127.0.0.1:"), process.communicate(timeout=60)
            yield process, line.split("open http://")[1].strip().rstrip("/")
        finally:
            process.kill()


def test_a_service_from_start_to_sigterm(service: tuple[subprocess.Popen[str], str]) -> None:
    process, address = service

    async def whole_scan(radar: int) -> list[dict[str, Any]]:
        got: list[dict[str, Any]] = []
        async with connect(f"ws://{address}/api/radars/{radar}/feed?encoding=f32&mode=lossless") as feed:
            while sum(m.get("count", 0) for m in got) < 120:
                got.append(wire.unpack(bytes(await feed.recv())))
        return got

    async def until_bye() -> tuple[dict[str, Any], int | None]:
        async with connect(f"ws://{address}/api/radars/1/feed") as feed:
            await feed.recv()
            process.send_signal(signal.SIGTERM)
            async for data in feed:
                message = wire.unpack(bytes(data))
            return message, feed.close_code

    with httpx.Client(base_url=f"http://{address}") as http:
        assert [radar["id"] for radar in http.get("/api/radars").json()] == ["0", "1"]
        assert http.get("/api/health").json()["status"] in ("ok", "behind")  # the latter where the machine is busy
        assert "text/html" in http.get("/").headers["content-type"]
        loaded = http.put("/api/radars/1/scene", json={"scene": ONE_TARGET}, timeout=20).json()
        assert loaded["plan"]["counts"]["resting_echoes"] == 1 and loaded["plan"]["choices"][-1]["modelled"]
    hello, *spokes = asyncio.run(asyncio.wait_for(whole_scan(0), 60))
    power = np.zeros((60, hello["encoding"]["bins"]))
    for message in spokes:
        assert message["epoch"] == hello["epoch"]
        power[message["index"] : message["index"] + message["count"]] = wire.samples(message)
    azimuth, cell = np.unravel_index(np.argmax(power), power.shape)
    assert azimuth == 0 and abs(message["range_first_m"] + cell * message["range_step_m"] - 300) < message["range_step_m"]
    simulated = rs.Simulator(rs.load_scene(ONE_TARGET)).scan()  # the target does not move: every scan is the first one
    np.testing.assert_array_equal(power, simulated.power)

    bye, code = asyncio.run(asyncio.wait_for(until_bye(), 60))
    assert hello["fidelity"] == "auto" and hello["plan"]["choices"] and not hello["truth"]
    assert hello["arithmetic"] == hello["plan"]["arithmetic"] == arithmetic()
    assert bye["type"] == "bye" and "stopping" in bye["reason"] and code == 1001
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")
