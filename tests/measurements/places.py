"""The scenes that benchmarks are run on."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter

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


def low_coast(folder: Path, speed_kn: float = 8.0, samples: int = 640, reach: float = 5556.2) -> rs.Scene:
    """A fractal coast of 1 to 5 m about a bay, half a million triangles and half a million echoes, own ship under way, noise,
    multipath, sea state 2, 2048 azimuths x 2780 cells. samples: of the height map each way; reach: of the radar [m]."""
    rng, across = np.random.default_rng(4), np.linspace(-1.0, 1.0, samples)
    octaves = (4, 8, 16, 32, 64)
    rough = [gaussian_filter(rng.standard_normal((samples, samples)), s * samples / 640, mode="wrap") for s in octaves]
    field = np.sum([layer * s**1.5 for layer, s in zip(rough, octaves, strict=True)], axis=0)
    bay = 6.0 * np.exp(-((np.hypot(*np.meshgrid(across, across)) / 0.12) ** 2))
    land = (field - field.mean()) / field.std() - bay + 0.35
    height = 1.0 + 4.0 * np.clip(land / 2.5, 0.0, 1.0) * (0.6 + 0.4 * rng.random(land.shape))
    np.save(folder / "coast.npy", np.where(land > 0.0, height, -1.0).astype(np.float32))
    coast = {"name": "coast", "heightmap": "coast.npy", "extent_m": [2 * reach, 2 * reach], "material": "land"}
    radar = {"azimuths": 2048, "range_max_m": reach, "beamwidth_deg": 1.2, "rpm": 24}
    table = {
        "name": "low coast",
        "radar": radar,
        "own_ship": {"course_deg": 200.0, "speed_kn": speed_kn},
        "environment": {"noise": True, "sea_state": 2, "multipath": True},
        "body": [coast],
    }
    return rs.load_scene(table, folder=folder)


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


def rolling_harbour() -> rs.Scene:
    """The harbour, whose ships roll by 5 degrees in 10 s."""
    table = tomllib.loads((SCENES / "harbour.toml").read_text(encoding="utf-8"))
    for body in table["body"]:
        if body.get("mesh") in ("coaster.obj", "ferry.obj", "freighter.obj", "tanker.obj"):
            body |= {"roll_deg": 5.0, "roll_period_s": 10.0}
    return rs.load_scene(table, folder=SCENES)


def coasters(at_sea: bool, count: int = 20) -> rs.Scene:
    """Steel coasters under way 0.8 to 4.5 km off, in calm water or in sea state 3, in which they roll, pitch and heave."""
    rng = np.random.default_rng(1)
    bodies = []
    for k, (east, north) in enumerate(_spread(rng, count, 800.0, 4500.0)):
        body = {"name": f"coaster {k}", "mesh": "coaster.obj", "scattering": "optics", "speed_kn": 10.0}
        sway = {
            "roll_deg": float(rng.uniform(2, 5)),
            "roll_period_s": float(rng.uniform(6, 10)),
            "pitch_deg": 1.0,
            "heave_m": 0.4,
        }
        where = {"position_m": [east, north, 0.0], "course_deg": float(rng.uniform(0, 360))}
        bodies.append(body | where | (sway if at_sea else {}))
    radar = {"range_max_m": 5000, "azimuths": 2048, "height_m": 15, "beamwidth_deg": 1.2}
    table = {"radar": radar, "environment": {"multipath": True, "sea_state": 3 if at_sea else 0}, "body": bodies}
    return rs.load_scene(table, folder=SCENES)


def steel_boxes(count: int) -> rs.Scene:
    """Moving steel boxes of 12 triangles all over 6 km."""
    rng = np.random.default_rng(1)
    bodies = [
        {"name": f"box {k}", "shape": "box", "length_m": 8 + 6 * (k % 8) / 8, "width_m": 4, "height_m": 3, "material": "steel",
         "position_m": [east, north, 0.0], "speed_kn": 5 + k % 11, "course_deg": k * 37 % 360}
        for k, (east, north) in enumerate(_spread(rng, count, 200.0, 5500.0))
    ]  # fmt: skip
    return scene(bodies, radar={"range_max_m": 6000, "azimuths": 2048}, environment={"multipath": True})


def declared_hulls(count: int) -> rs.Scene:
    """Hulls of 12 to 41 m with a declared cross-section, under way all over 5.5 km, by an antenna at rest; multipath, 2048
    azimuths."""
    rng, bodies = np.random.default_rng(1), []
    while len(bodies) < count:
        k, (east, north) = len(bodies), rng.uniform(-5500.0, 5500.0, 2).tolist()
        if np.hypot(east, north) > 300.0:
            hull = {"shape": "hull", "length_m": 12 + k % 30, "beam_m": 4, "height_m": 4, "rcs_dbsm": 15}
            motion = {"position_m": [east, north, 0.0], "speed_kn": 5 + k % 11, "course_deg": 37 * k % 360}
            bodies.append({"name": f"hull {k}", **hull, **motion})
    radar = {"range_max_m": 6000, "azimuths": 2048}
    return rs.load_scene({"name": "hulls", "radar": radar, "environment": {"multipath": True}, "body": bodies})


def _spread(rng: np.random.Generator, count: int, nearest: float, farthest: float) -> list[tuple[float, float]]:
    """Positions evenly over a ring [m]."""
    bearing, distance = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.uniform(nearest**2, farthest**2, count))
    return [(float(d * np.sin(b)), float(d * np.cos(b))) for b, d in zip(bearing, distance, strict=True)]
