"""Patterns, nulls and land, against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest

from radar_service.believed.bodies import ASPECTS, land_sigma0, nulls, octahedral, pattern, ship_sections, tri_lens
from radar_service.believed.run import Run


@pytest.mark.parametrize(
    ("weak", "expected"),
    [("0011", (180.0, 180.0)), ("1001", (180.0, 180.0)), ("0000", (0.0, 360.0)), ("1111", (360.0, 0.0))],
)
def test_nulls_close_round_the_circle(weak: str, expected: tuple[float, float]) -> None:
    assert nulls(np.array([letter == "1" for letter in weak])) == expected


def test_a_lens_has_its_closed_form_and_stands_aside(tmp_path: Path) -> None:
    """4 pi^3 r^4 / lambda^2 ahead of one of three, and cos^2 of the angle off it while the others are behind."""
    lens, wavelength = tri_lens(0.1), 299792458.0 / 9.41e9
    found = pattern(Run(tmp_path), lens[:1], 0.0)
    assert len(found) == 2 * ASPECTS and found[0] == pytest.approx(4.0 * math.pi**3 * 0.1**4 / wavelength**2, rel=0.02)
    assert found[12] / found[0] == pytest.approx(math.cos(math.radians(30.0)) ** 2, rel=0.03)
    assert found[ASPECTS] < 1e-6 * found[0]


@pytest.mark.study
def test_heel_weakens_an_octahedral_reflector(tmp_path: Path) -> None:
    upright, heeled = (float(np.mean(pattern(Run(tmp_path), octahedral(0.8), heel) >= 7.5)) * 360.0 for heel in (0.0, 10.0))
    assert upright == pytest.approx(300.0, abs=8.0) and heeled == pytest.approx(284.0, abs=8.0)  # docs/scenes.md


def test_ships_stand_round_the_antenna_at_the_aspects_asked_for(tmp_path: Path) -> None:
    """A corner reflector has an echo ahead alone."""
    corner = {"shape": "reflector", "reflector": "corner", "edge_m": 0.3}
    found = ship_sections(Run(tmp_path), corner, np.array([0.0, 90.0, 180.0, 270.0]), air={})
    assert found.argmax() == 0 and np.sort(found)[-2] < found[0] - 20.0


def test_land_has_sigma0_of_its_material(tmp_path: Path) -> None:
    """Vegetation has -12 dB sin(psi): of low relief seen from 5 degrees above, where nothing is in shadow, within 1 dB."""
    mean, spread = land_sigma0(Run(tmp_path), 5.0)
    assert mean == pytest.approx(-12.0 + 10.0 * math.log10(math.sin(math.radians(5.0))), abs=1.0)
    assert 0.7 < spread < 1.5  # exponential speckle has 1
