"""Samplers of diffuse surfaces: windows, settings, and two independent samplers on one plate."""

import numpy as np
import pytest

from radar_service.echo.echoes import Echoes
from radar_service.study.chart.frozen_scene import frozen, occlusion_of, only_diffuse
from radar_service.study.chart.reference_surface import Window
from radar_service.study.chart.samplers import powers_in, ray_powers, samplers, scatterer_powers
from tests.scenes import scene
from tests.study.chart.settings import PLATE, SMALL

WINDOW = Window(-0.1, 0.2, 700.0, 900.0)


def test_a_window_has_the_power_of_its_echoes() -> None:
    """|1|^2 + |2i|^2 = 5; the third echo is too far, the fourth on another bearing."""
    echoes = Echoes(np.array([800.0, 750.0, 950.0, 800.0]), np.array([0.0, 0.05, 0.0, 1.0]), np.array([1.0, 2.0j, 4.0, 8.0]))
    assert powers_in([WINDOW], echoes) == pytest.approx([5.0])


def test_scatterers_and_rays_agree_on_a_plate() -> None:
    """The mean of 32 draws of some 50 echoes each errs by 0.15 dB for both; 1 dB are more than 4 sigma."""
    world = only_diffuse(frozen(scene([{**PLATE, "width_m": 60, "height_m": 30}], radar=SMALL)))
    occlusion = occlusion_of(world)
    scatterers = [scatterer_powers(world, [WINDOW], occlusion, 4.0, seed)[0] for seed in range(32)]
    rays = [ray_powers(world, [WINDOW], occlusion, "sobol", 8000, seed)[0] for seed in range(32)]
    assert len(set(scatterers)) == len(set(rays)) == 32
    assert 10 * np.log10(np.mean(scatterers) / np.mean(rays)) == pytest.approx(0.0, abs=1.0)


def test_settings_end_at_the_largest_number_of_rays() -> None:
    world = only_diffuse(frozen(scene([PLATE], radar=SMALL)))
    chosen = samplers(world, [WINDOW], occlusion_of(world), 2000)
    settings = {(s.family, s.setting): s.preset for s in chosen}
    assert {setting for family, setting in settings if "rays" in family} == {"500", "2000"}
    presets = {settings["scatterers", f"{density} per cell"] for density in (1, 4, 16)}
    assert presets == {"fast", "balanced", "reference"} and settings["documented rays", "2000"] == "documented"
