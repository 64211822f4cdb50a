"""Effects of another package: birds with echoes and truth, a jammer, and a radome, without a line in the product."""

import ast
import json
from typing import Any

import numpy as np
import pytest

from tests.plug_ins.effects.played import plain
from tests.plug_ins.fixtures import PACKAGES, ROOT, Foreign

KNOT = 1852.0 / 3600.0


def along(course: float) -> Any:
    """East and north of a course in degrees."""
    return np.array([np.sin(np.deg2rad(course)), np.cos(np.deg2rad(course))])


@pytest.fixture(scope="module")
def package(foreign: Foreign) -> dict[str, Any]:
    """What the scenes of `played` give in a process where the package is installed."""
    done = foreign.ended(ROOT, "-m", "tests.plug_ins.effects.played")
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout.splitlines()[-1]))


def test_the_package_knows_nothing_of_the_product_but_its_facade() -> None:
    for file in (PACKAGES / "radar_hazards" / "radar_hazards").glob("*.py"):
        modules = [node.module for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.ImportFrom)]
        assert {name for name in modules if name and name.startswith("radar_service")} <= {"radar_service.effects"}, file


def test_birds_and_a_jammer_are_echoes_labels_powers_costs_truth_and_keys(package: dict[str, Any]) -> None:
    both = package["both"]
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


def test_a_service_serves_them(package: dict[str, Any]) -> None:
    """The processes of the service find the package by its entry points; clients get labels and truth."""
    assert package["served"] == {"same bytes": True, "names": ["birds", "birds"], "same truth": True}


def test_a_bird_is_a_point_that_moves_over_the_sea(package: dict[str, Any]) -> None:
    """The same range, phase, beam, spread and sea as of a body: single precision and the steps of visibility are between them."""
    assert package["one_db"] < -70.0


def test_a_radome_takes_from_the_beam(package: dict[str, Any]) -> None:
    """3 dB one way are 6 dB there and back, in echoes at rest and in the truth."""
    radome = package["radome"]
    assert radome["weaker_db"] == pytest.approx(6.0, abs=0.05) and radome["truth_db"] == pytest.approx(6.0, abs=1e-6)
    assert radome["plan"] == "29% of the field one way, in its sector" and radome["hash"]


def test_what_is_wrong_with_its_keys_is_said_as_of_all_others(package: dict[str, Any]) -> None:
    misspelt, few, unknown, narrow = package["refusals"]
    assert misspelt.startswith('flok: this is not a known key; did you mean "flock"?')
    assert few == "flock[0].birds: 0 is not allowed; a whole number from 1 to 2000; raise it"
    assert unknown.startswith('flock[0].bird: this is not a known key; did you mean "birds"?')
    assert narrow == "radar.radome.width_deg: 1 is less than a beamwidth; widen it"
    assert package["schema"]["properties"]["birds"]["maximum"] == 2000


def test_other_scenes_do_not_know_that_it_is_installed(package: dict[str, Any]) -> None:
    """Field, labels, powers, truth, hash, names and plan."""
    assert package["plain"] == json.loads(json.dumps(plain()))
