"""Scenes drawn at random for the benchmark of predicted times: all that costs time, in any mixture."""

from pathlib import Path
from typing import Any

import numpy as np

import radar_service as rs
from radar_service.numerics.constants import SPEED_OF_LIGHT

WAVEFORMS = (
    {"bandwidth_hz": 50e6, "pulse_s": 10e-6},
    {"bandwidth_hz": 20e6, "pulse_s": 5e-6, "window": "taylor"},
    {"bandwidth_hz": 40e6, "pulse_s": 1e-6},
    {"modulation": "none", "pulse_s": 80e-9, "sample_rate_hz": 50e6},
    {"modulation": "none", "pulse_s": 250e-9, "sample_rate_hz": 20e6},
)
BEAMS = ((720, 3.9), (360, 5.0), (1440, 1.9), (2048, 1.2))  # azimuths and beamwidth [degrees]


def drawn_scene(seed: int, folder: Path) -> rs.Scene:
    """A scene; equal for equal seeds. Height maps are written to the folder."""
    rng = np.random.default_rng([1946, seed])
    reach = float(np.exp(rng.uniform(np.log(1500.0), np.log(18_000.0))))
    spread = float(rng.choice([30.0, 180.0]))  # degrees about north-east within which all bodies are: some tiles have none
    made: list[dict[str, Any]] = [_point(rng, k, reach, spread) for k in range(int(rng.integers(0, 60)))]
    made += [_hull(rng, f"ship {k}", reach, spread, scattering="optics") for k in range(_some(rng, 4))]
    made += [
        _hull(rng, f"declared {k}", reach, spread, rcs_dbsm=30.0, swerling=int(rng.integers(0, 3)))
        for k in range(_some(rng, 8))
    ]
    made += [_house(rng, k, reach, spread) for k in range(_some(rng, 40))]
    if rng.random() < 0.4:
        made.append(_land(rng, reach, folder))
    under_way = (
        {"speed_kn": float(rng.uniform(5, 30)), "course_deg": float(rng.uniform(0, 360))} if rng.random() < 0.5 else {}
    )
    sway = {"roll_deg": 8.0, "roll_period_s": 9.0} if rng.random() < 0.2 else {}
    environment = {
        "noise": bool(rng.random() < 0.7),
        "multipath": bool(rng.random() < 0.4),
        "sea_state": int(rng.choice([0, 0, 2, 4])),
        "rain_mm_h": float(rng.choice([0.0, 0.0, 5.0])),
    }
    return rs.load_scene(
        {"radar": _radar(rng, reach), "own_ship": under_way | sway, "environment": environment, "body": made,
         "interference": [{"bearing_deg": 40.0, "prf_hz": 1800.0, "rpm": 30, "level_db": 50}] * int(rng.random() < 0.2)},
        folder=folder,
    )  # fmt: skip


def _some(rng: np.random.Generator, maximum: int) -> int:
    """Half of the time none, otherwise 1 to `maximum`."""
    return int(rng.integers(1, maximum + 1)) if rng.random() < 0.5 else 0


def _radar(rng: np.random.Generator, reach: float) -> dict[str, Any]:
    azimuths, beamwidth = BEAMS[int(rng.integers(len(BEAMS)))]
    waveform = WAVEFORMS[int(rng.integers(len(WAVEFORMS)))]
    rate = waveform.get("sample_rate_hz", 1.5 * float(waveform.get("bandwidth_hz", 0.0)))
    bins = int(reach * 2.0 * rate / SPEED_OF_LIGHT)
    pattern = str(rng.choice(["sinc2", "taylor", "gaussian"]))
    return {**waveform, "azimuths": azimuths, "beamwidth_deg": beamwidth, "rpm": float(rng.choice([20, 24, 48])),
            "range_max_m": bins * SPEED_OF_LIGHT / (2.0 * rate), "pattern": pattern}  # fmt: skip


def _location(rng: np.random.Generator, reach: float, spread: float, height: float) -> list[float]:
    bearing, distance = np.deg2rad(45.0 + rng.uniform(-spread, spread)), rng.uniform(0.1, 0.95) * reach
    return [float(distance * np.sin(bearing)), float(distance * np.cos(bearing)), height]


def _motion(rng: np.random.Generator) -> dict[str, Any]:
    return {"course_deg": float(rng.uniform(0, 360)), "speed_kn": float(rng.choice([0.0, 6.0, 14.0]))}


def _point(rng: np.random.Generator, k: int, reach: float, spread: float) -> dict[str, Any]:
    return {
        "name": f"point {k}",
        "shape": "point",
        "position_m": _location(rng, reach, spread, 5.0),
        "rcs_dbsm": 10.0,
        **_motion(rng),
    }


def _hull(rng: np.random.Generator, name: str, reach: float, spread: float, **kind: Any) -> dict[str, Any]:
    length = float(rng.uniform(15, 120))
    size = {"length_m": length, "beam_m": 0.17 * length, "height_m": 0.2 * length}
    return {"name": name, "shape": "hull", "position_m": _location(rng, reach, spread, 0.0), **size, **_motion(rng), **kind}


def _house(rng: np.random.Generator, k: int, reach: float, spread: float) -> dict[str, Any]:
    size = {
        "length_m": float(rng.uniform(8, 40)),
        "width_m": float(rng.uniform(8, 20)),
        "height_m": float(rng.uniform(5, 15)),
    }
    return {
        "name": f"house {k}",
        "shape": "box",
        "position_m": _location(rng, reach, spread, 0.0),
        "material": "concrete",
        **size,
    }


def _land(rng: np.random.Generator, reach: float, folder: Path) -> dict[str, Any]:
    """Hills of 120 x 120 heights in one quarter, of a few waves each way."""
    x, y = np.meshgrid(np.linspace(0, 1, 120), np.linspace(0, 1, 120))
    waves = sum(np.sin(2 * np.pi * (a * x + b * y + c)) / 3 for a, b, c in rng.uniform(0.5, 4.0, (3, 3)))
    np.save(folder / "land.npy", np.clip(120.0 * waves, -1.0, 120.0))
    side = [float(s) for s in rng.choice([-1.0, 1.0], 2)]
    return {"name": "land", "heightmap": "land.npy", "extent_m": [0.6 * reach, 0.6 * reach],
            "position_m": [0.55 * reach * side[0], 0.55 * reach * side[1], 0.0], "material": "land"}  # fmt: skip
