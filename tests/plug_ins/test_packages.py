"""Packages outside the tree, installed by pip: a port, a reader of several bodies, a tracker, a command, and a broken one."""

import json
import socket
import subprocess
from pathlib import Path

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
def told(**keys):
    body = {"name": "one", "position_m": [0, 500, 0], **keys.pop("body", {})}
    try:
        rs.Simulator(rs.load_scene({**keys, "body": [body]}, folder="."))
    except Exception as error:
        print(error)
told(body={"mesh": "one.broken"})
told(body={"heightmap": "one.broken", "extent_m": [100, 100]})
told(body={"mesh": "one.obj", "scattering": "broken"})
told(body={"shape": "point", "rcs_dbsm": 0, "broken": 1})
told(body={"shape": "point", "rcs_dbsm": 0}, broken=1)
"""


def test_what_is_broken_ends_in_a_sentence_and_all_others_work(foreign: Foreign, tmp_path: Path) -> None:
    """A command, readers, a scattering model, an effect; the other parts are those of the other tests."""
    command = foreign.ended(tmp_path, "-m", "radar_service", "broken")
    assert (command.returncode, command.stderr) == (2, BROKEN.format("commands") + "\n")
    (tmp_path / "one.broken").write_text("one")
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
    refused = foreign.ended(tmp_path, "-c", REFUSED)
    expected = [
        f"body[0].mesh: one.broken: {BROKEN.format('readers')}",
        f"body[0].heightmap: one.broken: {BROKEN.format('rasters')}",
        BROKEN.format("scattering"),
        f"body[0].broken: {BROKEN.format('effects')}",
        f"broken: {BROKEN.format('effects')}",
    ]
    assert refused.stdout.splitlines() == expected, refused.stderr


def test_a_command(foreign: Foreign, tmp_path: Path) -> None:
    assert foreign.ended(tmp_path, "-m", "radar_service", "hello", "sea").stdout == "hello sea\n"
    listed = foreign.ended(tmp_path, "-m", "radar_service", "--help")
    assert "hello          says a word\n" in listed.stdout and not listed.stderr


def test_a_reader_of_several_bodies_in_process_and_in_the_sandbox(foreign: Foreign, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "fleet.tetra").write_text("tetra\none 0 0 0 1\ntwo 10 20 1 2\n")
    once = "fleet [100.0, 500.0, 0.0] 4\nfleet two [120.0, 490.0, 1.0] 4\n"
    read = foreign.ended(tmp_path, "-c", READ)
    assert read.stdout == 2 * once, read.stderr


def test_a_tracker(foreign: Foreign, tmp_path: Path) -> None:
    tracked = foreign.ended(tmp_path, "-c", TRACK)
    right, broken = tracked.stdout.splitlines()
    assert right == "[(3.0, 4.0)] True" and broken.startswith(
        "broken of radar_service.trackers: the package broken-parts 1.0 is broken (TrackerError: tracker: "
        "'broken_parts:Tracker' made no tracker: "
    )


def test_a_port_beside_a_broken_one(foreign: Foreign, tmp_path: Path) -> None:
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
    options = foreign.ended(tmp_path, "-m", "radar_service", "replay", "--help").stdout
    assert "--count PORT" in options and "--nmea-tcp" not in options
