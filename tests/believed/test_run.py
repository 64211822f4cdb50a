"""Figures and their limits, and the scenes that a run keeps."""

from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.believed.run import BARE, Figure, Run, around, sections


@pytest.mark.parametrize(
    ("figure", "inside", "deviation"),
    [
        (Figure.near("", 103.0, 100.0, 0.02), False, 1.5),
        (Figure.within("", -61.0, -60.0, 2.0), True, -0.5),
        (Figure.by_factor("", 1.9, 2.0, 4.0, 2.0), True, 2.0 * 0.9 / 7.0 - 1.0),
        (Figure.least("", 0.6, 0.8), False, -1.5),
        (Figure.most("", 5.0, 10.0), True, 0.0),
        (Figure.most("", 12.0, 10.0), False, 1.4),
        (Figure.least("", 9.0, 0.8), True, 1.0),
        (Figure("", 2.0, 2.0, 2.0), True, 0.0),
    ],
)
def test_a_figure_is_inside_its_limits(figure: Figure, inside: bool, deviation: float) -> None:
    assert figure.inside is inside and figure.deviation == pytest.approx(deviation)
    assert (abs(figure.deviation) <= 1.0) is inside


def test_a_run_keeps_each_scene_as_a_file_that_gives_the_same_bytes(tmp_path: Path) -> None:
    bodies = [{"shape": "point", "rcs_dbsm": 10, "position_m": [0, 800, 4]}]
    simulator = Run(tmp_path).simulator(
        BARE | {"azimuths": 120, "beamwidth_deg": 6, "range_max_m": 1500}, {}, bodies, fidelity="fast"
    )
    scan = simulator.scan()
    again = rs.Simulator(rs.load_scene(tmp_path / "scene-1.json"), "fast").scan()
    np.testing.assert_array_equal(scan.power, again.power)
    assert around(scan.power, simulator, 0.0, 800.0).max() == scan.power.max()


def test_sections_are_those_of_the_bodies(tmp_path: Path) -> None:
    """A body behind the horizon has none."""
    bodies = [
        {"shape": "point", "rcs_dbsm": s, "position_m": p}
        for s, p in ((7, [0, 900, 4]), (-3, [800, 0, 4]), (9, [0, -40e3, 1]))
    ]
    found = sections(Run(tmp_path), BARE | {"range_max_m": 45e3, "bandwidth_hz": 5e6}, {}, bodies)
    np.testing.assert_allclose(found, [7.0, -3.0, -100.0], atol=0.1)  # of the gate, 20 dB below the peak
