"""Texture of land: what stands on height maps, against the published law and without it."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest, weibull_min

import radar_service as rs
from radar_service.numerics.types import Floats
from radar_service.scattering.land_texture import AREAS, CELL, RURAL, rms_slope, texture_shape, with_texture
from radar_service.scattering.surface_sampling import Scatterers

GAMMA = 10.0**-1.2  # of vegetation
# module: land_texture


def flat_ground(count: int, area: float = 1.0) -> Scatterers:
    """Points of level ground, each of an area [m^2]."""
    up, zeros, ones = np.tile([0.0, 0.0, 1.0], (count, 1)), np.zeros(count), np.ones(count)
    return Scatterers(np.zeros((count, 3)), up, area * ones, np.zeros(count, dtype=np.int64), ones + 0j, zeros, zeros)


@pytest.mark.parametrize("aw", [1.5, 2.6])
def test_a_texture_has_the_median_of_the_published_law(aw: float) -> None:
    """Speckle times texture, 400,000 draws, whose median errs by 0.5 %; nine tenths of the Weibull law lie below its own."""
    rng, shape = np.random.default_rng(1), texture_shape(aw)
    power = rng.exponential(size=400_000) * rng.standard_gamma(shape, 400_000) / shape
    law = weibull_min(1.0 / aw, scale=1.0 / math.gamma(1.0 + aw))
    assert np.median(power) == pytest.approx(law.median(), rel=0.02)
    assert law.cdf(np.quantile(power, 0.9)) == pytest.approx(0.9, abs=0.02)


@pytest.mark.parametrize(("area", "aw"), [(AREAS[0], 2.6), (AREAS[1], 1.5)])
def test_points_of_a_cell_together_have_the_texture(area: float, aw: float) -> None:
    """Twenty points make up the independent area of each of 10,000 cells; they stand up to 4 m above the ground."""
    points = flat_ground(200_000, CELL * area / 20)
    marked = with_texture(points, RURAL, GAMMA, np.full(200_000, area), np.random.default_rng(2))
    power, shape = (np.abs(marked.phasor) ** 2).reshape(-1, 20).mean(axis=1), texture_shape(aw)
    assert kstest(power, "gamma", args=(shape, 0.0, 1.0 / shape)).pvalue > 1e-3
    assert 0.0 <= marked.position[:, 2].min() < 0.1 < 3.9 < marked.position[:, 2].max() <= 4.0


def test_parts_have_the_published_mean_at_grazing_angles() -> None:
    """gamma max(slope, 0) of 200,000 parts along any level line of sight: -33 dB within 0.05 dB, 3.4 sigma of their mean."""
    marked = with_texture(flat_ground(200_000), RURAL, GAMMA, np.full(200_000, 1e6), np.random.default_rng(3))
    for azimuth in (0.0, 1.0, 4.0):
        facing = np.maximum(marked.normal @ [math.sin(azimuth), math.cos(azimuth), 0.0], 0.0)
        assert 10.0 * np.log10(GAMMA * facing.mean()) == pytest.approx(-33.0, abs=0.05)
    assert rms_slope(RURAL, GAMMA) == pytest.approx(0.0199, abs=1e-4)


def scan_of(folder: Path, material: str, **body: Any) -> Floats:
    """Mean power of a scan of level land 5 m up, 300 to 700 m off, by an antenna 30 m up; of each spoke and cell."""
    np.save(folder / "level.npy", np.full((21, 21), 5.0))
    kind = body or {"heightmap": "level.npy", "extent_m": [400, 400]}
    land = kind | {"name": "land", "position_m": [0, 500, 0], "material": material}
    radar = {"range_max_m": 900, "height_m": 30}
    made = rs.load_scene({"radar": radar, "environment": {"earth": "flat"}, "body": [land]}, folder=folder)
    return np.asarray(rs.Simulator(made, "balanced", 1).scan().power, dtype=np.float64)


def test_only_height_maps_of_measured_land_have_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sand, and a slab of vegetation, have the power of no texture to the bit; a height map of vegetation has another."""
    slab = {"shape": "box", "length_m": 400, "width_m": 400, "height_m": 5}
    cases = {"sand": {}, "vegetation": slab}
    kept = {name: scan_of(tmp_path, name, **body) for name, body in cases.items()}
    with_parts = scan_of(tmp_path, "vegetation")
    monkeypatch.setattr("radar_service.scattering.fixed_scatterers.terrain_of", lambda body: None)
    assert all(np.array_equal(power, scan_of(tmp_path, name, **cases[name])) for name, power in kept.items())
    without = scan_of(tmp_path, "vegetation")
    assert not np.array_equal(with_parts, without)
