"""A world that others made for Bridge Command, with five ships on its water, against the clock:
`python -m tests.measurements.fetched_world FOLDER [--processes 2] [--scans 10] [--scene-file FILE.json]`.

FOLDER has terrain.ini, the height map that it names, buoy.ini and landobject.ini, as the folders of that program's worlds do
(bin/World); none of it is part of this project. Marks are points of 8 dBsm, buildings boxes that rise 9 m above the ground.
Own ship makes 8 kn from the water nearest to the middle, at 2048 azimuths, with noise, multipath and sea state 2.
"""

import argparse
import json
import shutil
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt

import radar_service as rs
from radar_service.numerics.types import Floats
from tests.measurements.places import SCENES
from tests.real.places import east_north, entries_of

SHIPS = ("coaster", "ferry", "freighter", "tanker", "coaster")
NEAREST, FARTHEST = 700.0, 5000.0  # m off own ship, of ships
ROOM, FAIRWAY = 100.0, 250.0  # m of water around a ship, and around own ship
HOUSE = {"shape": "box", "material": "building", "length_m": 14.0, "width_m": 9.0}
RISE = 9.0  # m of a house above the ground


def world(source: Path, folder: Path) -> dict[str, Any]:
    """The scene of a world in `source`; its files are written into `folder`."""
    (terrain, *_) = entries_of(source / "terrain.ini")
    south, west, north_extent, east_extent, top, depth = (
        float(terrain[key]) for key in
        ("TerrainLat", "TerrainLong", "TerrainLatExtent", "TerrainLongExtent", "TerrainMaxHeight", "SeaMaxDepth")
    )  # fmt: skip
    grey = Image.open(source / terrain["HeightMap"].strip('"')).convert("L")
    grey.save(folder / "height.png")
    height = np.asarray(grey, dtype=np.float64) / 255.0 * (top + depth) - depth
    rows, columns = height.shape
    latitude = south + north_extent * np.linspace(1.0, 0.0, rows)
    longitude = west + east_extent * np.linspace(0.0, 1.0, columns)
    side, _ = east_north(latitude[:1], longitude[-1:], (float(latitude[0]), west))[0] / (columns - 1)
    off_shore: Floats = distance_transform_edt(height < 0.0) * side

    def places(room: float, origin: tuple[float, float]) -> tuple[Floats, Floats]:
        """Water with that much room [m]: latitude and longitude (N, 2) [degrees], distance (N,) from `origin` [m]."""
        row, column = np.nonzero(off_shore > room)
        return np.column_stack([latitude[row], longitude[column]]), np.hypot(
            *east_north(latitude[row], longitude[column], origin).T
        )

    middle = (south + north_extent / 2.0, west + east_extent / 2.0)
    water, off = places(FAIRWAY, middle)
    origin = tuple(water[np.argmin(off)].tolist())
    land = {"name": "land", "heightmap": "height.png", "low_m": -depth, "high_m": top, "material": "land",
            "south_west_deg": [south, west], "north_east_deg": [south + north_extent, west + east_extent]}  # fmt: skip
    bodies: list[dict[str, Any]] = [land]
    for number, mark in enumerate(entries_of(source / "buoy.ini")):
        at = {"latitude_deg": float(mark["Lat"]), "longitude_deg": float(mark["Long"])}
        bodies.append({"name": f"mark {number}", "shape": "point", "rcs_dbsm": 8.0, "swerling": 1, **at})
    for number, house in enumerate(entries_of(source / "landobject.ini")):
        at = {"latitude_deg": float(house["Lat"]), "longitude_deg": float(house["Long"])}
        row, column = np.rint([(south + north_extent - at["latitude_deg"]) / north_extent * (rows - 1),
                               (at["longitude_deg"] - west) / east_extent * (columns - 1)]).astype(int)  # fmt: skip
        if 0 <= row < rows and 0 <= column < columns:
            rise = {"height_m": max(float(height[row, column]), 0.0) + RISE, "heading_deg": float(house["Rotation"]) % 360.0}
            bodies.append({"name": f"building {number}", **HOUSE, **rise, **at})
    water, off = places(ROOM, origin)
    water = np.random.default_rng(6).permutation(water[(off > NEAREST) & (off < FARTHEST)])
    for number, (mesh, (north, east)) in enumerate(zip(SHIPS, water.tolist(), strict=False)):
        shutil.copy(SCENES / f"{mesh}.obj", folder)
        ship = {
            "name": f"ship {number}",
            "mesh": f"{mesh}.obj",
            "scattering": "optics",
            "latitude_deg": north,
            "longitude_deg": east,
        }
        bodies.append({**ship, "course_deg": 72.0 * number, "speed_kn": 2.0 * number})
    return {
        "name": source.name,
        "origin": {"latitude_deg": origin[0], "longitude_deg": origin[1]},
        "radar": {"range_max_m": 5556.2, "beamwidth_deg": 1.2, "height_m": 15.0, "rpm": 24, "azimuths": 2048},
        "environment": {"noise": True, "sea_state": 2, "multipath": True},
        "own_ship": {"course_deg": 200.0, "speed_kn": 8.0},
        "body": bodies,
    }


def main() -> None:
    """Prints what each scan takes on the clock, against its rotation; or writes the scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--scans", type=int, default=10)
    parser.add_argument(
        "--scene-file", type=Path, help="write the scene here, its meshes and heights beside it; run nothing"
    )
    asked = parser.parse_args()
    if asked.scene_file:
        asked.scene_file.parent.mkdir(parents=True, exist_ok=True)
        asked.scene_file.write_text(json.dumps(world(asked.folder, asked.scene_file.parent), indent=1), encoding="utf-8")
        return
    with TemporaryDirectory() as folder:
        sim = rs.Simulator(
            rs.load_scene(world(asked.folder, Path(folder)), folder=Path(folder)), seed=1, threads=asked.processes
        )
        took, begun = list[float](), time.perf_counter()
        for _ in range(asked.scans):
            for _ in sim.blocks(scans=1):
                pass
            took.append(time.perf_counter() - begun)
            begun += took[-1]
        sim.close()
    period = sim.scene.radar.rotation_period
    print(f"{sim.scene}\nseconds a scan by {asked.processes} processes, of {period:.2f}: {np.round(took, 2).tolist()}")
    print(f"the median after the first two is {period / float(np.median(took[2:])):.2f} x real time")


if __name__ == "__main__":
    main()
