"""The reflectivity that is measured is the engine's law, whatever beam, pulse and power."""

from pathlib import Path

import pytest

from radar_service.believed.run import NotExpressed, Run
from radar_service.believed.sea import MEASUREMENTS, reflectivity, seen_in_clutter, wave_heights
from radar_service.believed.targets import X


@pytest.mark.parametrize(("state", "published"), [(1, -56.55), (3, -43.74)])
def test_sigma0_is_that_of_the_law(tmp_path: Path, state: int, published: float) -> None:
    """NRL 2012 at 9.41 GHz, HH, 1 degree (docs/accuracy.md); 0.1 dB of speckle."""
    assert reflectivity(Run(tmp_path), 9.41e9, "h", 1.0, state) == pytest.approx(published, abs=0.1)


def test_wave_heights_are_those_of_the_scale(tmp_path: Path) -> None:
    """Within 5 %, as two hours of 64 waves scatter."""
    assert wave_heights(Run(tmp_path), (3, 5)) == pytest.approx([1.04, 2.98], rel=0.05)


@pytest.mark.study
def test_a_larger_target_is_seen_more_often_in_clutter(tmp_path: Path) -> None:
    small, large = (seen_in_clutter(Run(tmp_path), X, section, 1296.0, 2.0, 2) for section in (1.0, 1e3))
    assert small < 0.7 < large


def test_wave_age_is_not_expressed(tmp_path: Path) -> None:
    with pytest.raises(NotExpressed, match="wind and waves of different ages"):
        MEASUREMENTS["W02"](Run(tmp_path))
