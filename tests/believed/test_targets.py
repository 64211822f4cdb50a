"""Detection ranges against the radar equation, horizons against geometry, and two targets apart."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.believed.run import NM, Run
from radar_service.believed.targets import (
    PFA,
    X,
    detected,
    first_detection,
    horizon,
    local_level,
    over_beam,
    threshold_in_noise,
)
from radar_service.bench.detection.detection import Target, ground_distance, signal_to_noise, spoke_gains, steady_detection
from radar_service.scene_file.load import load_scene

BUOY = {"shape": "point", "rcs_dbsm": 10.0}


def test_first_detection_is_where_the_radar_equation_has_it(tmp_path: Path) -> None:
    """Within 0.2 NM, of Marcum's Q for the mean over the 3 spokes of the beam: steps are 0.15, and cells lose up to 1 dB."""
    radar = X | {"azimuths": 360, "beamwidth_deg": 2.0, "range_max_m": 14000}
    computed = first_detection(Run(tmp_path), radar, BUOY, 3.5, np.linspace(4.0, 7.0, 21))
    scene = load_scene({"radar": radar, "environment": {"noise": True, "multipath": True}})
    slant, gains = np.linspace(4.0, 7.0, 300) * NM, spoke_gains(scene.radar)
    ground = ground_distance(slant, 3.5, scene.radar, scene.environment)
    snr = signal_to_noise(scene.radar, scene.environment, ground, Target("buoy", 3.5, 10.0, 0, None))
    pd = steady_detection(snr * gains.mean(), PFA, len(gains))
    assert computed == pytest.approx(slant[pd >= 0.8].max() / NM, abs=0.2)


def test_the_mean_over_a_beam_of_noise_keeps_the_false_alarms(tmp_path: Path) -> None:
    """Of 280,000 cells, 4 deviations of clumps of three spokes."""
    simulator = Run(tmp_path).simulator(X | {"azimuths": 360, "beamwidth_deg": 2.0, "range_max_m": 14000}, {"noise": True})
    power = np.concatenate([over_beam(simulator.scan().power, simulator.scene.radar) for _ in range(2)])
    expected = PFA * power.size
    assert (power > threshold_in_noise(simulator)).sum() == pytest.approx(expected, abs=4.0 * np.sqrt(3.0 * expected))


def test_a_threshold_by_the_cells_beside_keeps_false_alarms_few(tmp_path: Path) -> None:
    """Of 60 faint points with 9 cells each, 10 scans, at 1e-4: 0.5 are expected, 5 or more in one run of 5000."""
    bodies = [
        {"shape": "point", "rcs_dbsm": -60, "position_m": [3000 * np.sin(a), 3000 * np.cos(a), 4]}
        for a in np.linspace(0, 6.2, 60)
    ]
    radar = X | {"azimuths": 360, "beamwidth_deg": 2.0, "range_max_m": 6000}
    assert detected(Run(tmp_path), radar, {"noise": True}, bodies, 10, level=local_level).sum() * 10 < 5


@pytest.mark.parametrize(("earth", "radius"), [("4/3", 4 / 3), (7 / 6, 7 / 6)])
def test_the_horizon_is_that_of_the_earth(tmp_path: Path, earth: float | str, radius: float) -> None:
    expected = (2.0 * radius * 6371e3) ** 0.5 * (3.0 + 4.0) / NM
    assert horizon(Run(tmp_path), 9.0, 16.0, earth) == pytest.approx(expected, rel=0.003)  # steps of 0.16 %
