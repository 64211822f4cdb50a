"""Packages outside the tree, installed by pip: a port, a reader of several bodies, a tracker, a command, and a broken one."""

import json
import socket
import subprocess
from pathlib import Path

import pytest

from tests.plug_ins.fixtures import Foreign

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
from radar_service.bench import TrackerInput
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.trackers import program_digest, tracker_for
tracker = tracker_for("still", {"type": "header"})
ship = dict(east=3.0, north=4.0, heading=0.0, course=0.0, speed=0.0, plots=())
tracks = tracker.update(TrackerInput(scan=0, time=2.5, **ship))
print([(track.east, track.north) for track in tracks], bool(program_digest("still")))
tracker.close()
try:
    tracker_for("broken", {"type": "header"})
except TrackerError as error:
    print(error)
"""


BROKEN = (
    "broken of radar_service.{}: the package broken-parts 1.0 is broken (RuntimeError: it needs another version); "
    "update or uninstall it"
)
REFUSED = """
import radar_service as rs
def refused(**keys):
    body = {"name": "one", "position_m": [0, 500, 0], **keys.pop("body", {})}
    try:
        rs.Simulator(rs.load_scene({**keys, "body": [body]}, folder="."))
    except Exception as error:
        print(error)
refused(body={"mesh": "one.broken"})
refused(body={"heightmap": "one.broken", "extent_m": [100, 100]})
refused(body={"mesh": "one.obj", "scattering": "broken"})
refused(body={"shape": "point", "rcs_dbsm": 0, "broken": 1})
refused(body={"shape": "point", "rcs_dbsm": 0}, broken=1)
"""

PARTS = {"read": READ, "track": TRACK, "refused": REFUSED} | {
    name: f"from radar_service.__main__ import main\nmain({words})"
    for name, words in {"help": ["--help"], "replay help": ["replay", "--help"]}.items()
}
TOLD = f"""
import contextlib, io, json
said = {{}}
for name, part in {PARTS}.items():
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.suppress(SystemExit):
        exec(part, {{}})
    said[name] = out.getvalue()
print(json.dumps(said))
"""


@pytest.fixture(scope="module")
def told(foreign: Foreign, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What each of PARTS prints, in one process that has the packages."""
    folder = tmp_path_factory.mktemp("told")
    (folder / "scene.toml").write_text(SCENE)
    (folder / "fleet.tetra").write_text("tetra\none 0 0 0 1\ntwo 10 20 1 2\n")
    (folder / "one.broken").write_text("one")
    (folder / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
    done = foreign.ended(folder, "-c", TOLD)
    assert not done.returncode, done.stderr
    return dict(json.loads(done.stdout))


def test_what_is_broken_ends_in_a_sentence_and_all_others_work(
    foreign: Foreign, told: dict[str, str], tmp_path: Path
) -> None:
    """A command, readers, a scattering model, an effect; the other parts are those of the other tests."""
    command = foreign.ended(tmp_path, "-m", "radar_service", "broken")
    assert (command.returncode, command.stderr) == (2, BROKEN.format("commands") + "\n")
    expected = [
        f"body[0].mesh: one.broken: {BROKEN.format('readers')}",
        f"body[0].heightmap: one.broken: {BROKEN.format('rasters')}",
        BROKEN.format("scattering"),
        f"body[0].broken: {BROKEN.format('effects')}",
        f"broken: {BROKEN.format('effects')}",
    ]
    assert told["refused"].splitlines() == expected


def test_a_command(foreign: Foreign, told: dict[str, str], tmp_path: Path) -> None:
    assert foreign.ended(tmp_path, "-m", "radar_service", "hello", "sea").stdout == "hello sea\n"
    assert "hello          says a word\n" in told["help"]


def test_a_reader_of_several_bodies_in_process_and_in_the_sandbox(told: dict[str, str]) -> None:
    once = "fleet [100.0, 500.0, 0.0] 4\nfleet two [120.0, 490.0, 1.0] 4\n"
    assert told["read"] == 2 * once


def test_a_tracker(told: dict[str, str]) -> None:
    right, broken = told["track"].splitlines()
    assert right == "[(3.0, 4.0)] True" and broken.startswith(
        "broken of radar_service.trackers: the package broken-parts 1.0 is broken (TrackerError: tracker: "
        "'broken_parts:Tracker' made no tracker: "
    )


def test_a_port_beside_a_broken_one(foreign: Foreign, told: dict[str, str]) -> None:
    """The broken one is told in a sentence with its package; the service and the other port run."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind(("127.0.0.1", 0))
        ear.settimeout(60)
        words = ["-m", "radar_service", "serve", "worked-example", "--port", "0", "--count", str(ear.getsockname()[1])]
        pipe = subprocess.PIPE
        with subprocess.Popen([foreign.python, *words], stdout=pipe, stderr=pipe, text=True) as service:
            try:
                message = json.loads(ear.recv(1000))
            finally:
                service.terminate()
            _, errors = service.communicate(timeout=60)
    assert message["first"] == 0 and message["shape"][0] == message["count"]
    (line,) = errors.splitlines()
    assert line == BROKEN.format("ports")
    assert "--count PORT" in told["replay help"] and "--nmea-in-tcp" not in told["replay help"]
