"""Packages outside the tree, installed by pip: effects, a port, a reader, a tracker, a command, and a broken one."""

import ast
import json
import os
import socket
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.plug_ins.fixtures import PACKAGES, ROOT
from tests.plug_ins.played import plain

KNOT = 1852.0 / 3600.0
FLEET = """
[[body]]
name = "fleet"
mesh = "fleet.tetra"
position_m = [100, 500, 0]
heading_deg = 90
"""
BROKEN = (
    "broken of radar_service.{}: the package broken-parts 1.0 is broken (RuntimeError: it needs another version); "
    "update or uninstall it"
)


@pytest.fixture(scope="module")
def told(foreign: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What `played` prints in a process that has the packages."""
    folder = tmp_path_factory.mktemp("told")
    (folder / "scene.toml").write_text(FLEET)
    (folder / "fleet.tetra").write_text("tetra\none 0 0 0 1\ntwo 10 20 1 2\n")
    (folder / "one.broken").write_text("one")
    (folder / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
    words = [foreign, "-m", "tests.plug_ins.played"]
    done = subprocess.run(
        words, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout.splitlines()[-1]))


def test_what_is_broken_ends_in_a_sentence_and_all_others_work(told: dict[str, Any]) -> None:
    """A command, readers, a scattering model, an effect; the other parts are those of the other tests."""
    assert told["commands"][0] == [2, "", BROKEN.format("commands") + "\n"]
    assert told["broken"] == [
        f"body[0].mesh: one.broken: {BROKEN.format('readers')}",
        f"body[0].heightmap: one.broken: {BROKEN.format('rasters')}",
        BROKEN.format("scattering"),
        f"body[0].broken: {BROKEN.format('effects')}",
        f"broken: {BROKEN.format('effects')}",
    ]


def test_a_command(told: dict[str, Any]) -> None:
    _, (status, out, _), (_, helped, _), _ = told["commands"]
    assert (status, out) == (0, "hello sea\n") and "hello          says a word\n" in helped


def test_a_reader_of_several_bodies_in_process_and_in_the_sandbox(told: dict[str, Any]) -> None:
    assert told["bodies"] == 2 * [["fleet", [100.0, 500.0, 0.0], 4], ["fleet two", [120.0, 490.0, 1.0], 4]]


def test_a_tracker(told: dict[str, Any]) -> None:
    assert told["tracker"]["tracks"] == [[3.0, 4.0]] and told["tracker"]["has digest"]
    assert told["tracker"]["broken"].startswith(
        "broken of radar_service.trackers: the package broken-parts 1.0 is broken (TrackerError: tracker: "
        "'broken_parts:Tracker' made no tracker: "
    )


def test_a_port_beside_a_broken_one(foreign: Path, told: dict[str, Any]) -> None:
    """The broken one is told in a sentence with its package; the service and the other port run."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind(("127.0.0.1", 0))
        ear.settimeout(60)
        words = ["-m", "radar_service", "serve", "worked-example", "--port", "0", "--count", str(ear.getsockname()[1])]
        pipe = subprocess.PIPE
        with subprocess.Popen([foreign, *words], stdout=pipe, stderr=pipe, text=True) as service:
            try:
                message = json.loads(ear.recv(1000))
            finally:
                service.terminate()
            _, errors = service.communicate(timeout=60)
    assert message["first"] == 0 and message["shape"][0] == message["count"]
    (line,) = errors.splitlines()
    assert line == BROKEN.format("ports")
    assert "--count PORT" in told["commands"][3][1] and "--nmea-in-tcp" not in told["commands"][3][1]


# Effects: birds with echoes and truth, a jammer, and a radome, without a line in the product.
def along(course: float) -> Any:
    """East and north of a course in degrees."""
    return np.array([np.sin(np.deg2rad(course)), np.cos(np.deg2rad(course))])


def test_the_package_knows_nothing_of_the_product_but_its_facade() -> None:
    for file in (PACKAGES / "radar_hazards" / "radar_hazards").glob("*.py"):
        modules = [node.module for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.ImportFrom)]
        assert {name for name in modules if name and name.startswith("radar_service")} <= {"radar_service.effects"}, file


def test_birds_and_a_jammer_are_echoes_labels_powers_costs_truth_and_keys(told: dict[str, Any]) -> None:
    both = told["both"]
    assert both["numbers"] == {"birds": 128, "jammer": 129}
    assert both["labelled"]["birds"] > 20 and both["labelled"]["jammer"] > 500 and min(both["powers"].values()) > 0.0
    assert both["strobe_deg"] == pytest.approx(200.0, abs=1.0)
    assert min(both["costs"].values()) > 0.0
    assert both["documented"]["flocks"] == both["documented"]["jammers"] == "requested, but not in the specification"
    assert "1 flocks of birds, jammer" in both["check"]
    (flock,), velocity = both["truth"]["flocks"], 25 * KNOT * along(200)
    assert flock["birds"] == 25 and flock["position"] == pytest.approx([*(800, 1500) + 5.0 * velocity, 30])
    ((time, visible),) = (each.values() for each in flock["crossings"])
    east, north = (800, 1500) + time * (velocity - 10 * KNOT * along(40))
    assert visible and time == pytest.approx(
        2.5 * (1.0 + np.arctan2(east, north) / (2 * np.pi)), abs=1e-9
    )  # a turn in 2.5 s
    assert both["in two processes"]


def test_a_service_serves_them(told: dict[str, Any]) -> None:
    """The processes of the service find the package by its entry points; clients get labels and truth."""
    assert told["served"] == {"same bytes": True, "names": ["birds", "birds"], "same truth": True}


def test_a_bird_is_a_point_that_moves_over_the_sea(told: dict[str, Any]) -> None:
    """The same range, phase, beam, spread and sea as of a body: single precision and the steps of visibility are between them."""
    assert told["one_db"] < -70.0


def test_a_radome_takes_from_the_beam(told: dict[str, Any]) -> None:
    """3 dB one way are 6 dB there and back, in echoes at rest and in the truth."""
    radome = told["radome"]
    assert radome["weaker_db"] == pytest.approx(6.0, abs=0.05) and radome["truth_db"] == pytest.approx(6.0, abs=1e-6)
    assert radome["plan"] == "29% of the field one way, in its sector" and radome["hash"]


def test_what_is_wrong_with_its_keys_is_said_as_of_all_others(told: dict[str, Any]) -> None:
    misspelt, few, unknown, narrow = told["refusals"]
    assert misspelt.startswith('flok: this is not a known key; did you mean "flock"?')
    assert few == "flock[0].birds: 0 is not allowed; a whole number from 1 to 2000; raise it"
    assert unknown.startswith('flock[0].bird: this is not a known key; did you mean "birds"?')
    assert narrow == "radar.radome.width_deg: 1 is less than a beamwidth; widen it"
    assert told["schema"]["properties"]["birds"]["maximum"] == 2000


def test_other_scenes_do_not_know_that_it_is_installed(told: dict[str, Any]) -> None:
    """Field, labels, powers, truth, hash, names and plan."""
    assert told["plain"] == json.loads(json.dumps(plain()))
