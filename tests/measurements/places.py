"""The scenes that benchmarks are run on."""

from pathlib import Path
from typing import Any

import numpy as np

import radar_service as rs
from tests.real import places
from tests.scenes import scene

SCENES = Path(__file__).parents[2] / "scenes"
SLOW = {"azimuths": 720, "rpm": 24, "beamwidth_deg": 3.9}
UNDER_WAY = {"course_deg": 200.0, "speed_kn": 12.0}


def shipped(name: str) -> rs.Scene:
    """A scene of the package."""
    return rs.load_scene(SCENES / f"{name}.toml")


def buildings(folder: Path) -> rs.Scene:
    """99,000 triangles of real buildings, own ship at 12 kn, 3.9 degrees of beam, 6 km."""
    return rs.load_scene(places.swinomish(folder, radar=SLOW, own_ship=UNDER_WAY), folder=folder)


def coast(folder: Path) -> rs.Scene:
    """Two million triangles of real terrain, own ship at 12 kn, 24 NM."""
    return rs.load_scene(places.catalina(folder, (33.08, -118.5), radar=SLOW, own_ship=UNDER_WAY), folder=folder)


def many_ships(ships: int = 20, azimuths: int = 4096, bins: int = 4096, rpm: float = 48, **environment: Any) -> rs.Scene:
    """Mesh ships under way all round, half of them with a declared cross-section."""
    rng = np.random.default_rng(8)
    reach = bins * 299_792_458.0 / 150e6
    bodies = []
    for k in range(ships):
        r, bearing = rng.uniform(0.1, 0.9) * reach, rng.uniform(0, 2 * np.pi)
        body = {"name": f"ship {k}", "shape": "hull", "length_m": 90, "beam_m": 14, "height_m": 15, "speed_kn": 12}
        position = [float(r * np.sin(bearing)), float(r * np.cos(bearing)), 0.0]
        kind: dict[str, Any] = {"rcs_dbsm": 30.0, "swerling": 1} if k % 2 else {"scattering": "diffuse"}
        bodies.append({**body, "position_m": position, "course_deg": float(rng.uniform(0, 360)), **kind})
    radar = {"azimuths": azimuths, "rpm": rpm, "range_max_m": reach, "beamwidth_deg": max(0.9, 360 / azimuths)}
    return scene(bodies, radar=radar, environment={"noise": True, "sea_state": 3, **environment})
