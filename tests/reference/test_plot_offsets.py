"""Plots of extended ships lie where the truth says that their power lies; the table of docs/plots.md is made of that."""

import numpy as np
import pytest

from tests.reference.plot_offsets import ASPECTS, Offsets, measured, rows

HULL = {"shape": "hull", "length_m": 140, "beam_m": 21, "height_m": 20, "rcs_dbsm": 30}


def biases(every: list[Offsets]) -> np.ndarray:
    """Mean error of plots (K, 2) in range and across the line of sight [m]."""
    return np.array([(one.in_range.mean(), one.in_bearing.mean()) for one in every])


def test_plots_of_a_declared_hull_lie_where_its_power_lies() -> None:
    """0.25 m: a twentieth of a range cell. Its power lies up to 60 m from the middle of its waterline."""
    every = measured((20.0, 100.0), 4, HULL)
    assert [len(one.along) for one in every] == [4, 4]
    assert (abs(biases(every)) < 0.25).all()
    assert max(abs(one.along).max() for one in every) > 5.0


@pytest.mark.study
def test_plots_of_a_freighter_lie_where_its_power_lies() -> None:
    every = measured(ASPECTS, 10, {"mesh": "freighter.obj", "scattering": "optics"})
    assert all(len(one.along) == 10 for one in every) and (abs(biases(every)) < 0.25).all()
    assert max(one.along.std() for one in every) > 20.0  # glint


def test_a_row_has_means_and_deviations() -> None:
    made = Offsets(15.0, np.array([1.0, 3.0]), np.array([0.0, 0.0]), np.array([0.1, 0.3]), np.array([0.0, 0.0]))
    assert "| 15 | 2.0 | 1.4 | 0.0 | 0.0 | +0.20 ± 0.10 | +0.00 ± 0.00 |" in rows([made])
