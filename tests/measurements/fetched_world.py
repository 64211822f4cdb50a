"""A world that others made for Bridge Command, with five ships on its water, against the clock:
`python -m tests.measurements.fetched_world FOLDER [--top M] [--processes 2] [--scans 10] [--scene-file FILE.json]`.

FOLDER has terrain.ini, the height map that it names, buoy.ini and landobject.ini, as the folders of that program's worlds do
(bin/World); none of it is part of this project. Marks are points of 8 dBsm, buildings boxes that rise 9 m above the ground.
Own ship makes 8 kn from the water nearest to the middle, at 2048 azimuths, with noise, multipath and sea state 2.
"""

import argparse
import json
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt

import radar_service as rs
from radar_service.numerics.types import Floats
from tests.measurements.places import five_ships
from tests.real.places import east_north, entries_of

NEAREST, FARTHEST = 700.0, 5000.0  # m off own ship, of ships
ROOM, FAIRWAY = 100.0, 250.0  # m of water around a ship, and around own ship
HOUSE = {"shape": "box", "material": "building", "length_m": 14.0, "width_m": 9.0}
RISE = 9.0  # m of a house above the ground
Table = dict[str, Any]


class Ground(NamedTuple):
    """Heights (R, C) [m] over latitudes (R,), from the north on, and longitudes (C,) [degrees]."""

    height: Floats
    latitude: Floats
    longitude: Floats

    def water(self, room: float, origin: tuple[float, float]) -> tuple[Floats, Floats]:
        """Places with so much water around [m]: latitude and longitude (N, 2), and distance (N,) from `origin` [m]."""
        corner = float(self.latitude[0]), float(self.longitude[0])
        steps = east_north(np.array([self.latitude[1], corner[0]]), np.array([corner[1], self.longitude[1]]), corner)
        south, east = np.hypot(*steps.T)
        row, column = np.nonzero(distance_transform_edt(self.height < 0.0, (south, east)) > room)
        places = np.column_stack([self.latitude[row], self.longitude[column]])
        return places, np.hypot(*east_north(places[:, 0], places[:, 1], origin).T)

    def at(self, latitude: float, longitude: float) -> float | None:
        """The height at a place [m]; None beyond the map."""
        ends = ((self.latitude, latitude), (self.longitude, longitude))
        row, column = (round((each - of[0]) / (of[1] - of[0])) for of, each in ends)
        inside = 0 <= row < len(self.latitude) and 0 <= column < len(self.longitude)
        return float(self.height[row, column]) if inside else None


def world(source: Path, folder: Path, top: float | None = None) -> Table:
    """The scene of a world in `source`; its files are written into `folder`. top: height of the highest land [m], as in the
    world where it is None."""
    terrain = entries_of(source / "terrain.ini")[0]
    south, west, north_extent, east_extent, highest, depth = (
        float(terrain[key])
        for key in (
            "TerrainLat",
            "TerrainLong",
            "TerrainLatExtent",
            "TerrainLongExtent",
            "TerrainMaxHeight",
            "SeaMaxDepth",
        )
    )
    grey = np.asarray(Image.open(source / terrain["HeightMap"].strip('"')).convert("L"), dtype=np.float64)
    height = grey / 255.0 * (highest + depth) - depth
    if top is not None:
        height = np.where(height > 0.0, height * top / highest, height)
    np.save(folder / "height.npy", height.astype(np.float32))
    rows, columns = height.shape
    corners = {"south_west_deg": [south, west], "north_east_deg": [south + north_extent, west + east_extent]}
    ground = Ground(
        height,
        south + north_extent * np.linspace(1.0, 0.0, rows),
        west + east_extent * np.linspace(0.0, 1.0, columns),
    )
    fairway, off = ground.water(FAIRWAY, (south + north_extent / 2.0, west + east_extent / 2.0))
    latitude, longitude = fairway[np.argmin(off)].tolist()
    return {
        "name": source.name,
        "origin": {"latitude_deg": latitude, "longitude_deg": longitude},
        "radar": {"range_max_m": 5556.2, "beamwidth_deg": 1.2, "height_m": 15.0, "rpm": 24, "azimuths": 2048},
        "environment": {"noise": True, "sea_state": 2, "multipath": True},
        "own_ship": {"course_deg": 200.0, "speed_kn": 8.0},
        "body": [
            {"name": "land", "heightmap": "height.npy", "material": "land", **corners},
            *marks(source),
            *houses(source, ground),
            *ships(ground, (latitude, longitude), folder),
        ],
    }


def marks(source: Path) -> list[Table]:
    """The buoys of a world."""
    kind = {"shape": "point", "rcs_dbsm": 8.0, "swerling": 1}
    return [{"name": f"mark {k}", **kind, **_place(entry)} for k, entry in enumerate(entries_of(source / "buoy.ini"))]


def houses(source: Path, ground: Ground) -> list[Table]:
    """The objects on land of a world."""
    bodies = []
    for number, entry in enumerate(entries_of(source / "landobject.ini")):
        place = _place(entry)
        below = ground.at(place["latitude_deg"], place["longitude_deg"])
        if below is not None:
            pose = {"height_m": max(below, 0.0) + RISE, "heading_deg": float(entry["Rotation"]) % 360.0}
            bodies.append({"name": f"building {number}", **HOUSE, **pose, **place})
    return bodies


def ships(ground: Ground, origin: tuple[float, float], folder: Path) -> list[Table]:
    """Five ships on open water, as many as have room; their meshes are copied into `folder`."""
    places, off = ground.water(ROOM, origin)
    places = np.random.default_rng(6).permutation(places[(off > NEAREST) & (off < FARTHEST)])
    found = zip(five_ships(folder), places.tolist(), strict=False)
    return [{**ship, "latitude_deg": latitude, "longitude_deg": longitude} for ship, (latitude, longitude) in found]


def _place(entry: dict[str, str]) -> dict[str, float]:
    return {"latitude_deg": float(entry["Lat"]), "longitude_deg": float(entry["Long"])}


def main() -> None:
    """Prints what each scan takes on the clock, against its rotation; or writes the scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("--top", type=float, metavar="M", help="lower the land, so that its highest point is that high")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--scans", type=int, default=10, metavar="N")
    parser.add_argument("--scene-file", type=Path, metavar="FILE.json", help="write the scene and its files; run nothing")
    asked = parser.parse_args()
    if asked.scene_file:
        beside = asked.scene_file.parent
        beside.mkdir(parents=True, exist_ok=True)
        asked.scene_file.write_text(json.dumps(world(asked.folder, beside, asked.top), indent=1), encoding="utf-8")
        return
    with TemporaryDirectory() as folder:
        scene = rs.load_scene(world(asked.folder, Path(folder), asked.top), folder=Path(folder))
    sim = rs.Simulator(scene, seed=1, threads=asked.processes)
    took, begun = list[float](), time.perf_counter()
    for _ in range(asked.scans):
        for _ in sim.blocks(scans=1):
            pass
        took.append(time.perf_counter() - begun)
        begun += took[-1]
    sim.close()
    period = scene.radar.rotation_period
    print(f"{scene}\nseconds a scan by {asked.processes} processes, of {period:.2f}: {np.round(took, 2).tolist()}")
    print(f"the median but for the first two is {period / float(np.median(took[2:])):.2f} x real time")


if __name__ == "__main__":
    main()
