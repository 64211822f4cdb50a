"""Speckle of homogeneous land: exponential intensity, but for what so few scatterers to a cell add to it.

For scatterers strewn at random, lambda to a unit of area, of random phase, the intensity has <I^2>/<I>^2 = 2 + integral w^2
/ (lambda (integral w)^2), w being the power with which a position is received (fourth cumulant of a compound Poisson sum; Oliver
and Quegan, Understanding Synthetic Aperture Radar Images, 2004, ch. 5): w = pulse^2 G^2. A cell is a range bin by
a beamwidth. Where triangles are smaller than cells scatterers are spread more evenly than at random, and less is added.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import radar_service as rs
from radar_service.records.fidelity import PRESETS
from tests.reference.compressed_pulse import compressed_pulse, sinc2_beam

Floats = np.ndarray[Any, np.dtype[np.float64]]
RADAR = {"range_max_m": 1600, "pulse_s": 1e-6, "bandwidth_hz": 20e6, "azimuths": 72, "beamwidth_deg": 5,
         "beamwidth_el_deg": 60, "height_m": 200}  # fmt: skip
EVERY = 3  # bins from one sample to the next: the compressed pulse is 30 dB down there, as the beam is 10 degrees off
LEVEL = 1e-4


def level_land(folder: Path, posts: int = 9) -> rs.Scene:
    """Four kilometres of level land round the antenna; 9 posts a side make triangles of some 290 cells."""
    np.save(folder / "level.npy", np.full((posts, posts), 1.0, dtype=np.float32))
    land = {"name": "land", "heightmap": "level.npy", "extent_m": [4000, 4000], "material": "land"}
    return rs.load_scene({"radar": RADAR, "body": [land], "environment": {"earth": "flat"}}, folder=folder)


def intensities(made: rs.Scene, per_cell: float, seeds: range) -> Floats:
    """Independent intensities of the ring from 800 to 1500 m, each over the mean at its range."""
    fidelity = replace(PRESETS["balanced"], scatterers_per_cell=per_cell)
    first, last = (int(r / made.radar.range_step) for r in (800, 1500))
    power = np.array([rs.Simulator(made, fidelity, seed).scan().power[::2, first:last:EVERY] for seed in seeds], float)
    return (power / power.mean(axis=(0, 1))).ravel()


def excess(made: rs.Scene) -> float:
    """What one scatterer to a cell adds to <I^2>/<I>^2."""
    radar = made.radar
    position = np.linspace(-150, 150, 20_001)
    received = np.abs(compressed_pulse(2 * position / 299_792_458.0, radar.bandwidth, radar.pulse, (0.54, 0.46))) ** 2
    angle = np.linspace(-np.pi, np.pi, 200_001)
    beam = sinc2_beam(angle, radar.beamwidth) ** 2
    along = np.sum(received**2) / np.sum(received) ** 2 / (position[1] - position[0]) * radar.range_step
    across = np.sum(beam**2) / np.sum(beam) ** 2 / (angle[1] - angle[0]) * radar.beamwidth
    return float(along * across)


@pytest.mark.parametrize("per_cell", [0.5, 2.0])
def test_speckle_has_the_moments_of_so_many_scatterers(per_cell: float, tmp_path: Path) -> None:
    """<I^2>/<I>^2 over 3 seeds, 5 sigma: its standard error is that of exponential draws, sqrt(20 / M) and a half more for
    the heavier tail. On triangles smaller than a cell the moment lies between that of random and of even spacing."""
    made = level_land(tmp_path)
    drawn = intensities(made, per_cell, range(3))
    assert np.mean(drawn**2) == pytest.approx(2 + excess(made) / per_cell, abs=5 * 1.5 * np.sqrt(20 / len(drawn)))
    finer = intensities(level_land(tmp_path, posts=161), per_cell, range(3))
    assert abs(np.mean(finer**2) - 2) < excess(made) / per_cell + 5 * 1.5 * np.sqrt(20 / len(finer))


def test_intensity_of_the_balanced_preset_is_exponential(tmp_path: Path) -> None:
    """At most 2 % of the samples lie on the wrong side of any level: Kolmogorov's distance less its 1e-4 quantile."""
    made = level_land(tmp_path)
    drawn = intensities(made, PRESETS["balanced"].scatterers_per_cell, range(4))
    away = stats.kstest(drawn, stats.expon().cdf).statistic
    assert away - stats.kstwo(len(drawn)).ppf(1 - LEVEL) < 0.02
