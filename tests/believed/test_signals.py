"""Measurements of the signal: each finds what its scene has."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.believed.run import Run
from radar_service.believed.signals import MEASUREMENTS, rain_loss, slow_dots, width


@pytest.mark.parametrize(("frequency", "polarization", "rain", "loss"), [(9.41e9, "v", 16, 0.274), (9.41e9, "h", 50, 1.443)])
def test_rain_weakens_by_the_recommendation(
    tmp_path: Path, frequency: float, polarization: str, rain: float, loss: float
) -> None:
    assert rain_loss(Run(tmp_path), frequency, polarization, rain) == pytest.approx(loss, rel=0.005)


@pytest.mark.parametrize("vertical", [False, True])
def test_a_beam_has_its_width(tmp_path: Path, vertical: bool) -> None:
    """A wrong width is seen as what it is."""
    key = "beamwidth_el_deg" if vertical else "beamwidth_deg"
    assert width(Run(tmp_path), {key: 2.0}, 3.0, vertical) == pytest.approx(2.0, rel=0.01)


def test_slow_dots_are_the_stronger_ones() -> None:
    distance = np.arange(0.0, 4000.0, 10.0)
    power = np.zeros(400)
    power[[100, 220, 340]], power[[60, 180, 300]] = 1.0, 0.2
    np.testing.assert_array_equal(slow_dots(distance, power), [1000.0, 2200.0, 3400.0])


@pytest.mark.parametrize("row", ["P04", "T06", "E01", "E03"])
def test_rows_give_the_same_verdict(tmp_path: Path, row: str) -> None:
    """Cheap rows."""
    assert all(figure.inside for figure in MEASUREMENTS[row](Run(tmp_path)))
