"""The scenes that benchmarks are run on."""

import shutil
import tomllib
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter, zoom

import radar_service as rs
from radar_service.numerics.types import Singles
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


def low_coast(
    folder: Path, speed_kn: float = 8.0, samples: int = 640, reach: float = 5556.2, top: float = 5.0, built: bool = False
) -> rs.Scene:
    """A fractal coast of 1 m to `top` [m] about a bay, half a million triangles and half a million echoes, own ship under way,
    noise, multipath, sea state 2, 2048 azimuths x 2780 cells.

    samples: of the height map each way; reach: of the radar [m]; built: with 300 buildings and 60 buoys. The map is drawn in a
    process of its own, so that what this one takes is the scene's.
    """
    coast, heights = _coast(folder, samples, reach, top)
    radar = {"azimuths": 2048, "range_max_m": reach, "beamwidth_deg": 1.2, "rpm": 24}
    table = {
        "name": "low coast",
        "radar": radar,
        "own_ship": {"course_deg": 200.0, "speed_kn": speed_kn},
        "environment": {"noise": True, "sea_state": 2, "multipath": True},
        "body": [coast, *(_town(heights, reach) if built else [])],
    }
    return rs.load_scene(table, folder=folder)


def low_channel(folder: Path) -> rs.Scene:
    """The real buildings, marks and pontoons of the Swinomish Channel on a low coast of 1 to 5 m, half a million triangles; five
    ships by optics on open water 1 to 5 km off, four of them under way; own ship at 8 kn, noise, multipath, sea state 2, 2048
    azimuths."""
    reach = 5556.2
    coast, heights = _coast(folder, 640, reach, 5.0)
    row, column = np.nonzero(distance_transform_edt(heights < 0.0) > 100.0 / (2.0 * reach / 639.0))
    water = np.column_stack([(2.0 * column / 639.0 - 1.0) * reach, (1.0 - 2.0 * row / 639.0) * reach])
    off = np.hypot(*water.T)
    water = np.random.default_rng(6).permutation(water[(off > 1000.0) & (off < 5000.0)])
    radar = {"range_max_m": reach, "beamwidth_deg": 1.2, "height_m": 15.0, "rpm": 24}
    environment = {"sea_state": 2, "multipath": True}
    table = places.swinomish(folder, radar=radar, environment=environment, own_ship={"course_deg": 200.0, "speed_kn": 8.0})
    for ship, (east, north) in zip(five_ships(folder), water[:5].tolist(), strict=True):
        table["body"].append({**ship, "position_m": [east, north, 0.0]})
    table["body"].append(coast)
    return rs.load_scene(table, folder=folder)


def five_ships(folder: Path) -> list[dict[str, Any]]:
    """Ships by optics without a place, four of them under way; their meshes are copied into `folder`."""
    ships = []
    for k, mesh in enumerate(("coaster", "ferry", "freighter", "tanker", "coaster")):
        shutil.copy(SCENES / f"{mesh}.obj", folder)
        kind = {"name": f"ship {k}", "mesh": f"{mesh}.obj", "scattering": "optics"}
        ships.append({**kind, "course_deg": 72.0 * k, "speed_kn": 2.0 * k})
    return ships


def _coast(folder: Path, samples: int, reach: float, top: float) -> tuple[dict[str, Any], Singles]:
    """A low coast as a body, and its heights [m]."""
    path = folder / f"coast-{samples}-{top:g}.npy"
    with ProcessPoolExecutor(1, get_context("spawn")) as other:
        other.submit(draw_coast, path, samples, top).result()
    body = {"name": "coast", "heightmap": path.name, "extent_m": [2 * reach, 2 * reach], "material": "land"}
    return body, np.load(path)


def draw_coast(path: Path, samples: int, top: float) -> None:
    """Writes heights (samples, samples) [m] of a low coast, -1 where it is sea. What is larger than 4 of 640 samples is the same
    at any number of them; the heights of neighbours differ by up to two fifths."""
    rng, across = np.random.default_rng(4), np.linspace(-1.0, 1.0, 640)
    octaves = (4, 8, 16, 32, 64)
    rough = [gaussian_filter(rng.standard_normal((640, 640)), s, mode="wrap") for s in octaves]
    field = np.sum([layer * s**1.5 for layer, s in zip(rough, octaves, strict=True)], axis=0)
    bay = 6.0 * np.exp(-((np.hypot(*np.meshgrid(across, across)) / 0.12) ** 2))
    land = (field - field.mean()) / field.std() - bay + 0.35
    if samples != len(land):
        land = zoom(land, samples / len(land), order=1)
    height = 1.0 + (top - 1.0) * np.clip(land / 2.5, 0.0, 1.0) * (0.6 + 0.4 * rng.random(land.shape))
    np.save(path, np.where(land > 0.0, height, -1.0).astype(np.float32))


def _town(heights: Singles, reach: float) -> list[dict[str, Any]]:
    """300 buildings that rise 8 m above a map of heights (N, N) [m], and 60 buoys in its bay."""
    rng, samples = np.random.default_rng(5), len(heights)
    rows, columns = rng.permutation(np.argwhere(heights > 1.2))[:300].T
    bodies: list[dict[str, Any]] = []
    for k, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        east, north = (2.0 * column / (samples - 1) - 1.0) * reach, (1.0 - 2.0 * row / (samples - 1)) * reach
        house = {"shape": "box", "length_m": 14.0, "width_m": 9.0, "height_m": float(heights[row, column]) + 8.0}
        where = {"position_m": [east, north, 0.0], "heading_deg": 37.0 * k % 360.0}
        bodies.append({"name": f"building {k}", "material": "building", **house, **where})
    for k, (east, north) in enumerate(_spread(rng, 60, 250.0, 900.0)):
        buoy = {"shape": "point", "rcs_dbsm": 5.0, "swerling": 1, "position_m": [east, north, 2.0]}
        bodies.append({"name": f"buoy {k}", **buoy})
    return bodies


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


def strait(folder: Path, metal: str) -> rs.Scene:
    """60 ships of the five hull types under way, 100 buoys and a low coast about a bay; sea state 3, own ship at 8 kn, noise,
    multipath, 2048 azimuths at 24 rpm.

    metal: "declared" (cross-sections, Swerling 1), "optics", or "seaway" (optics, and all ships are moved by the sea).
    """
    reach = 5556.2
    coast, _ = _coast(folder, 320, reach, 5.0)
    rng = np.random.default_rng(9)
    kinds = {
        "cargo": (150, 22, 25),
        "ferry": (90, 16, 14),
        "fishing": (24, 7, 8),
        "pilot": (14, 4.5, 5),
        "yacht": (12, 4, 4),
    }
    bodies: list[dict[str, Any]] = [coast]
    for k, (east, north) in enumerate(_spread(rng, 60, 400.0, 2400.0)):
        kind = list(kinds)[k % len(kinds)]
        size = dict(zip(("length_m", "beam_m", "height_m"), kinds[kind], strict=True))
        echo: dict[str, Any] = {"rcs_dbsm": 30.0, "swerling": 1} if metal == "declared" else {"scattering": "optics"}
        way = {
            "position_m": [east, north, 0.0],
            "course_deg": float(rng.uniform(0, 360)),
            "speed_kn": float(rng.uniform(4, 14)),
        }
        bodies.append({"name": f"{kind} {k}", "shape": "hull", "hull_type": kind, **size, **echo, **way})
    for k, (east, north) in enumerate(_spread(rng, 100, 250.0, 2400.0)):
        buoy = {"shape": "point", "rcs_dbsm": 5.0, "swerling": 1, "position_m": [east, north, 2.0]}
        bodies.append({"name": f"buoy {k}", **buoy})
    table = {
        "name": f"strait, {metal}",
        "radar": {"azimuths": 2048, "range_max_m": reach, "beamwidth_deg": 1.2, "rpm": 24},
        "own_ship": {"course_deg": 200.0, "speed_kn": 8.0},
        "environment": {"noise": True, "multipath": True, "sea_state": 3, "seaway": metal == "seaway"},
        "body": bodies,
    }
    return rs.load_scene(table, folder=folder)


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
