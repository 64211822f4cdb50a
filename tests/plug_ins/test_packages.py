"""Packages outside the tree, installed by pip: a port, a reader of several bodies, a tracker, a command, and a broken one."""

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

PACKAGES = Path(__file__).parent / "packages"
SCENE = """
[[body]]
name = "fleet"
mesh = "fleet.tetra"
position_m = [100, 500, 0]
heading_deg = 90
"""
READ = """
import radar_service as rs
from radar_service.scene_file.readers.sandbox import Sandbox
sandbox = Sandbox()
for reader in ({}, {"mesh_reader": sandbox}):
    for body in rs.load_scene("scene.toml", **reader).bodies:
        print(body.name, body.motion.position[0].round(6).tolist(), body.mesh.faces.shape[0])
sandbox.close()
"""
TRACK = """
from radar_service.bench import TrackerInput, load_scenario
from radar_service.bench.trackers.trackers import program_digest, tracker_for
tracker = tracker_for("still", load_scenario("crossing-cpa-500"), {"type": "header"})
ship = dict(east=3.0, north=4.0, heading=0.0, course=0.0, speed=0.0, plots=())
tracks = tracker.update(TrackerInput(scan=0, time=2.5, **ship))
print([(track.east, track.north) for track in tracks], bool(program_digest("still")))
tracker.close()
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, str]:
    """The environment of programs that find the packages, which pip has installed in a folder of their own."""
    pytest.importorskip("setuptools", minversion="77", reason="setuptools 77 or newer is needed to build offline")
    folder = tmp_path_factory.mktemp("packages")
    copies = shutil.copytree(PACKAGES, folder / "sources", ignore=shutil.ignore_patterns("__pycache__"))
    install = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index", "--no-build-isolation"]
    there = folder / "installed"
    subprocess.run([*install, "--target", there, *sorted(copies.iterdir())], check=True, capture_output=True)
    return {**os.environ, "PYTHONPATH": str(there)}


def ended(environment: Mapping[str, str], folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *words], env=environment, cwd=folder, capture_output=True, text=True)


def test_a_command(environment: Mapping[str, str], tmp_path: Path) -> None:
    assert ended(environment, tmp_path, "-m", "radar_service", "hello", "sea").stdout == "hello sea\n"
    listed = ended(environment, tmp_path, "-m", "radar_service", "--help")
    assert "hello          says a word\n" in listed.stdout and not listed.stderr


def test_a_reader_of_several_bodies_in_process_and_in_the_sandbox(environment: Mapping[str, str], tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "fleet.tetra").write_text("tetra\none 0 0 0 1\ntwo 10 20 1 2\n")
    once = "fleet [100.0, 500.0, 0.0] 4\nfleet two [120.0, 490.0, 1.0] 4\n"
    read = ended(environment, tmp_path, "-c", READ)
    assert read.stdout == 2 * once, read.stderr


def test_a_tracker(environment: Mapping[str, str], tmp_path: Path) -> None:
    tracked = ended(environment, tmp_path, "-c", TRACK)
    assert tracked.stdout == "[(3.0, 4.0)] True\n", tracked.stderr


def test_a_port_beside_a_broken_one(environment: Mapping[str, str], tmp_path: Path) -> None:
    """The broken one is told in a sentence with its package; the service and the other port run."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind(("127.0.0.1", 0))
        ear.settimeout(60)
        words = ["-m", "radar_service", "serve", "worked-example", "--port", "0", "--count", str(ear.getsockname()[1])]
        pipe = subprocess.PIPE
        with subprocess.Popen([sys.executable, *words], env=environment, stdout=pipe, stderr=pipe, text=True) as service:
            try:
                message = json.loads(ear.recv(1000))
            finally:
                service.terminate()
            _, errors = service.communicate(timeout=60)
    assert message["first"] == 0 and message["shape"][0] == message["count"]
    (line,) = errors.splitlines()
    assert line.startswith(
        "broken of radar_service.ports: the package broken-port 1.0 is broken (RuntimeError: it needs another"
    )
    options = ended(environment, tmp_path, "-m", "radar_service", "replay", "--help").stdout
    assert "--count PORT" in options and "--nmea-tcp" not in options
