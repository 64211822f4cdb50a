"""The real input of ../shared/real as plain data, read without the loader; and scenes made of it."""

import re
import shutil
from collections import defaultdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pyproj import Geod

Floats = NDArray[np.float64]

REAL = Path(__file__).parents[3] / "shared" / "real"
EARTH = Geod(ellps="WGS84")
present = pytest.mark.skipif(not (REAL / "README.md").is_file(), reason=f"the real input is not at {REAL}")

CHANNEL = (48.39, -122.495)  # latitude, longitude in Swinomish Channel, off La Conner
SOUTH_WEST, SIZE = (32.58333, -119.0), 1.0009765625  # of catalina.png, degrees
NORTH_EAST = (SOUTH_WEST[0] + SIZE, SOUTH_WEST[1] + SIZE)


def entries(name: str) -> list[dict[str, str]]:
    """The entries of an .ini file of the Swinomish area, as of `entries_of`."""
    return entries_of(REAL / "swinomish" / name)


def entries_of(path: Path) -> list[dict[str, str]]:
    """The numbered entries of an .ini file, in order: key without number to value."""
    result: dict[int, dict[str, str]] = defaultdict(dict)
    text = path.read_text()
    for key, number, part, value in re.findall(r"^(\w+)\((\d+)(,\d+)?\) *= *(\S+)", text, re.MULTILINE):
        result[int(number)][key + part] = value
    return [result[number] for number in sorted(result)]


def tiles() -> list[tuple[str, float, float]]:
    """Name, latitude and longitude [degrees] of the building tiles that exist."""
    read = [(e["Type"], float(e["Lat"]), float(e["Long"])) for e in entries("landobject.ini")]
    return [tile for tile in read if tile[1] != 0.0]  # a tile without buildings lies at latitude 0 and has no file


def buoys() -> list[tuple[float, float]]:
    """Latitude and longitude [degrees] of the navigation marks."""
    return [(float(e["Lat"]), float(e["Long"])) for e in entries("buoy.ini")]


def pontoons() -> list[Floats]:
    """The pontoons, each a polyline (n, 2) of latitude, longitude [degrees]."""
    lines = [
        [[float(e[f"{key},{k}"]) for key in ("Lat", "Long")] for k in range(1, int(e["Nodes"]) + 1)]
        for e in entries("pontoon.ini")
    ]
    return [np.array(line) for line in lines]


def east_north(latitude: Floats, longitude: Floats, origin: tuple[float, float]) -> Floats:
    """East and north (n, 2) [m] from `origin` by geodesic distance and bearing."""
    home = np.broadcast_to(origin[1], latitude.shape), np.broadcast_to(origin[0], latitude.shape)
    bearing_deg, _, distance = EARTH.inv(*home, longitude, latitude)
    bearing = np.deg2rad(bearing_deg)
    return np.stack([distance * np.sin(bearing), distance * np.cos(bearing)], axis=-1)


@cache
def buildings(origin: tuple[float, float]) -> list[Floats]:
    """Every building (an object of the files) as triangles (n, 3, 3): east, north from `origin`, up [m]."""
    result: list[Floats] = []
    for name, latitude, longitude in tiles():
        corners, faces = [], defaultdict(list)
        label = ""
        for line in (REAL / "swinomish" / f"{name}.obj").read_text().splitlines():
            words = line.split()
            if words[:1] == ["o"]:
                label = words[1]
            elif words[:1] == ["v"]:
                x, y, z = map(float, words[1:4])
                corners.append((x, -z, y))
            elif words[:1] == ["f"]:
                faces[label].append([int(word.split("/")[0]) - 1 for word in words[1:4]])
        position = east_north(np.array([latitude]), np.array([longitude]), origin)[0]
        points = np.array(corners) + (*position, 0.0)
        result += [points[np.array(triangles)] for triangles in faces.values()]
    return result


def swinomish(folder: Path, **changes: dict[str, Any]) -> dict[str, Any]:
    """A scene of the Swinomish Channel whose meshes are copied into `folder`. changes: sections to update."""
    folder.mkdir(parents=True, exist_ok=True)
    body: list[dict[str, Any]] = []
    for name, latitude, longitude in tiles():
        shutil.copy(REAL / "swinomish" / f"{name}.obj", folder)
        position = {"latitude_deg": latitude, "longitude_deg": longitude}
        body.append({"name": name, "mesh": f"{name}.obj", "up": "y", "material": "building", **position})
    shutil.copy(REAL / "light_buoy.stl", folder)
    for k, (latitude, longitude) in enumerate(buoys()):
        position = {"latitude_deg": latitude, "longitude_deg": longitude}
        body.append({"name": f"mark {k + 1}", "mesh": "light_buoy.stl", "rcs_dbsm": 10.0, **position})
    for k, line in enumerate(pontoons()):
        body += [_pontoon(f"pontoon {k + 1}.{j + 1}", a, b) for j, (a, b) in enumerate(zip(line, line[1:], strict=False))]
    scene: dict[str, Any] = {
        "name": "Swinomish Channel",
        "origin": {"latitude_deg": CHANNEL[0], "longitude_deg": CHANNEL[1]},
        "radar": {
            "range_max_m": 6000.0,
            "beamwidth_deg": 0.9,
            "azimuths": 2048,
            "height_m": 40.0,
            "power_w": 100.0,
            "window": "blackman",
            "pattern": "taylor",
        },
        "environment": {"noise": True},
        "body": body,
    }
    return updated(scene, changes)


def _pontoon(name: str, start: Floats, end: Floats) -> dict[str, Any]:
    bearing_deg, _, length = EARTH.inv(start[1], start[0], end[1], end[0])
    middle = (start + end) / 2.0
    position = {"latitude_deg": float(middle[0]), "longitude_deg": float(middle[1]), "heading_deg": bearing_deg}
    size = {"length_m": max(length, 0.5), "width_m": 2.5, "height_m": 0.6}
    return {"name": name, "shape": "box", "material": "wood", **position, **size}


def catalina(folder: Path, origin: tuple[float, float], **changes: dict[str, Any]) -> dict[str, Any]:
    """A scene of the southern Channel Islands, the height map copied into `folder`, radar out to 24 NM."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(REAL / "catalina.png", folder)
    land = {"name": "islands", "heightmap": "catalina.png", "low_m": -2063.0, "high_m": 633.0, "material": "land",
            "south_west_deg": list(SOUTH_WEST), "north_east_deg": list(NORTH_EAST)}  # fmt: skip
    scene: dict[str, Any] = {
        "name": "Southern Channel Islands",
        "origin": {"latitude_deg": origin[0], "longitude_deg": origin[1]},
        "radar": {
            "range_max_m": 44448.0,
            "bandwidth_hz": 10e6,
            "beamwidth_deg": 1.2,
            "height_m": 30.0,
            "azimuths": 1024,
            "window": "blackman",
            "pattern": "taylor",
        },
        "environment": {"noise": True},
        "body": [land],
    }
    return updated(scene, changes)


def updated(scene: dict[str, Any], changes: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The scene with sections updated."""
    return scene | {key: scene.get(key, {}) | change for key, change in changes.items()}
