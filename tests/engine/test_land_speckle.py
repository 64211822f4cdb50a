"""Speckle of land under way by how many scatterers a resolution cell has."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import ks_2samp

import radar_service as rs
from radar_service.engine import land_rows
from radar_service.engine.preparation import prepare
from radar_service.numerics.types import Floats
from radar_service.records.fidelity import PRESETS
from tests.engine.land_scenes import OWN_SHIP, RADAR, fields

APART = (
    16,
    4,
)  # azimuths and bins between cells: 2.8 beamwidths and more than two widths of the pulse, so they are independent


def flat_coast(folder: Path) -> rs.Scene:
    """Land 3 m high about a bay of 140 m: no cell is in a shadow, and the mean power is smooth."""
    east, north = np.meshgrid(np.linspace(-1400, 1400, 57), np.linspace(1400, -1400, 57))
    np.save(folder / "flat.npy", np.where(np.hypot(east, north) < 140.0, -1.0, 3.0).astype(np.float32))
    land = {"name": "coast", "heightmap": "flat.npy", "extent_m": [2800.0, 2800.0], "material": "land"}
    return rs.load_scene({"name": "flat", "radar": RADAR, "own_ship": OWN_SHIP, "body": [land]}, folder=folder)


def cell_powers(made: rs.Scene, per_cell: float, seed: int, tiles: int) -> Floats:
    """Powers (C,) of independent cells of the first scan."""
    prepared = prepare(made, replace(PRESETS["balanced"], scatterers_per_cell=per_cell), seed)
    assert prepared.land is not None
    near, far = np.searchsorted((np.arange(made.radar.bins) + 0.5) * made.radar.range_step, [400.0, 1350.0])
    power: Floats = np.abs(fields(prepared, 0, tiles)[:: APART[0], near : far : APART[1]]).astype(np.float64) ** 2
    return power.ravel()


def pooled(made: rs.Scene, per_cell: tuple[float, float], seeds: int, tiles: int) -> tuple[Floats, Floats]:
    """Powers of all cells and seeds over the mean of each cell, for two densities with seeds of their own."""
    draws = [
        np.array([cell_powers(made, n, 1 + seed + 1000 * k, tiles) for seed in range(seeds)]) for k, n in enumerate(per_cell)
    ]
    mean = np.concatenate(draws).mean(axis=0)
    return (draws[0] / mean).ravel(), (draws[1] / mean).ravel()


@pytest.mark.study
def test_four_scatterers_a_cell_have_the_speckle_of_eight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kolmogorov-Smirnov over 3094 cells and 20 seeds, pooled: p > 0.01 (required); it was 0.35."""
    monkeypatch.setattr(land_rows, "ROW_SECONDS", 0.0)
    coarse, finer = pooled(flat_coast(tmp_path), (4.0, 8.0), 20, 13)
    assert len(coarse) >= 20 * 3000
    result = ks_2samp(coarse, finer)
    print(f"\n{len(coarse)} powers: D = {result.statistic:.4f}, p = {result.pvalue:.3f}")
    assert result.pvalue > 0.01


def test_half_a_scatterer_a_cell_has_other_speckle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the study measures, it can tell: most cells have one scatterer or none. Some 1100 powers each."""
    monkeypatch.setattr(land_rows, "ROW_SECONDS", 0.0)
    few, more = pooled(flat_coast(tmp_path), (0.25, 1.0), 2, 4)
    assert len(few) > 500 and ks_2samp(few, more).pvalue < 1e-6
