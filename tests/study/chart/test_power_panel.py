"""Samplers and their panel, against the reference lattice and the binomial law."""

import numpy as np
import pytest

from radar_service.study.chart.frozen_scene import all_echoes, frozen, occlusion_of, only_diffuse
from radar_service.study.chart.power_panel import mean_and_spread, power_points, target_windows
from radar_service.study.chart.reference_surface import ReferenceSurface
from radar_service.study.chart.samplers import samplers
from tests.scenes import scene
from tests.study.chart.settings import PLATE, SMALL


def test_samplers_agree_with_the_lattice_and_documented_rays_miss() -> None:
    """A plate of 200 m^2: scatterers have its mean power within their noise, 0.5 dB. Of 2000 documented rays in a box of 36 x 75
    degrees, 0.82 sr, at least one meets its 0.00031 sr with probability 0.54: 0.46 of 170 draws miss, 4 sigma are 0.15."""
    world = only_diffuse(frozen(scene([PLATE], radar=SMALL)))
    windows = target_windows(world, all_echoes(world, 0), 1)
    truth = np.array([ReferenceSurface(world).power(windows[0], 64, 128)])
    chosen = [s for s in samplers(world, windows, occlusion_of(world), 2000) if s.setting in ("4 per cell", "2000")]
    points = {p.family: p for p in power_points(chosen, truth, 170, 0, lambda: None)}
    assert points["scatterers"].error_db == pytest.approx(0.0, abs=0.5) and points["scatterers"].missed == 0.0
    assert points["documented rays"].missed == pytest.approx((1 - 200 / 640000 / 0.823) ** 2000, abs=0.15)
    assert points["documented rays"].preset == "documented" and points["scatterers"].preset == "balanced"


def test_misses_bias_and_spread_are_separate() -> None:
    """Draws of 2 and 4 for a truth of 1: mean 3 (4.77 dB), deviation sqrt 2, spread 10 log10(1 + sqrt 2 / 3)."""
    error, spread, missed = mean_and_spread(np.array([[2.0, 0.0], [4.0, 0.0]]), np.array([1.0, 1.0]))
    assert error == pytest.approx(4.771, abs=1e-3) and spread == pytest.approx(1.678, abs=1e-3) and missed == 0.5
    assert mean_and_spread(np.zeros((2, 1)), np.ones(1)) == (None, None, 1.0)


def test_each_draw_has_its_own_truth() -> None:
    """Every draw is twice its truth: 3.01 dB in the mean; the errors of the draws are 1 and 3."""
    error, spread, missed = mean_and_spread(np.array([[2.0], [6.0]]), np.array([[1.0], [3.0]]))
    assert error == pytest.approx(3.0103, abs=1e-4) and missed == 0.0
    assert spread == pytest.approx(10 * np.log10(1 + np.sqrt(2) / 4), abs=1e-9)
