"""Real buildings on the screen: 19 tiles of OpenStreetMap buildings, 201 pontoons and 22 marks of the Swinomish Channel."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import radar_service as rs
from tests.real import places

pytestmark = places.present
Floats = NDArray[np.float64]

EARTH_RADIUS = 4.0 / 3.0 * 6_371_000.0  # m, effective
GUARD_BINS, GUARD_BEAMS = 8, 2.0  # empty margin about a building: beyond the main lobes, 4 bins and 1.13 beamwidths wide
SAMPLES = 500  # points on a building: on the 200 m^2 that show of it, one every 0.6 m, a third of a range bin


class Extent(NamedTuple):
    """Ranges [m] and bearings [rad] between which things lie, each (n,)."""

    near: Floats
    far: Floats
    left: Floats
    right: Floats


def polar(points: Floats, height: float) -> Floats:
    """Slant range [m], bearing and elevation [rad] (..., 3) of places, from `height` over the origin (DESIGN section 2)."""
    distance = np.hypot(points[..., 0], points[..., 1])
    z = points[..., 2] - distance**2 / (2.0 * EARTH_RADIUS) - height
    return np.stack([np.hypot(distance, z), np.arctan2(points[..., 0], points[..., 1]), np.arctan2(z, distance)], axis=-1)


def extent(things: list[Floats], height: float) -> Extent:
    """Where each of `things` (their points) lies; none of them may surround the radar."""
    rows = []
    for thing in things:
        seen = polar(thing.reshape(-1, 3), height)
        turned = (seen[:, 1] - seen[0, 1] + np.pi) % (2 * np.pi) - np.pi + seen[0, 1]
        rows.append((seen[:, 0].min(), seen[:, 0].max(), turned.min(), turned.max()))
    return Extent(*np.array(rows).T)


def isolated(candidates: Extent, others: Extent, bins: float, beams: float) -> NDArray[np.int64]:
    """Which candidates nothing but themselves comes near: `bins` [m] along range, `beams` [rad] along bearing."""
    alone = []
    for k in range(len(candidates.near)):
        middle = (candidates.left[k] + candidates.right[k]) / 2.0
        half = (candidates.right[k] - candidates.left[k]) / 2.0
        offset = ((others.left + others.right) / 2.0 - middle + np.pi) % (2 * np.pi) - np.pi
        beside = np.abs(offset) <= half + (others.right - others.left) / 2.0 + beams
        level = (others.near <= candidates.far[k] + bins) & (others.far >= candidates.near[k] - bins)
        if np.count_nonzero(beside & level) == 1:
            alone.append(k)
    return np.array(alone)


def sight_free(points: Floats, triangles: Floats, height: float) -> NDArray[np.bool_]:
    """Which points (n, 3) no triangle (m, 3, 3) hides from the antenna: Moeller and Trumbore (1997), pair by pair."""
    bent_points, bent = (a - np.array([0, 0, 1]) * (np.sum(a[..., :2] ** 2, axis=-1, keepdims=True) / (2 * EARTH_RADIUS))
                         for a in (points, triangles))  # fmt: skip
    antenna = np.array([0.0, 0.0, height])
    free = np.ones(len(points), dtype=np.bool_)
    first, second = bent[:, 1] - bent[:, 0], bent[:, 2] - bent[:, 0]
    for k, point in enumerate(bent_points):
        ray = point - antenna
        cross = np.cross(ray, second)
        det = np.einsum("ij,ij->i", first, cross)
        with np.errstate(divide="ignore", invalid="ignore"):
            to = antenna - bent[:, 0]
            u = np.einsum("ij,ij->i", to, cross) / det
            turned = np.cross(to, first)
            v = turned @ ray / det
            t = np.einsum("ij,ij->i", second, turned) / det
        # 1e-6 of the way: what the point lies on does not hide it; 4 mm at 4 km, against buildings of metres
        free[k] = not np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 1 - 1e-6))
    return free


def visible_points(building: Floats, around: Floats, height: float, rng: np.random.Generator) -> Floats:
    """Range and bearing (n, 2) of those of SAMPLES random points of a building's surface that the radar sees."""
    a, b, c = building[:, 0], building[:, 1], building[:, 2]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    triangle = rng.choice(len(building), SAMPLES, p=area / area.sum())
    u, v = rng.random((2, SAMPLES, 1))
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    points = a[triangle] + u * (b - a)[triangle] + v * (c - a)[triangle]
    return polar(points[sight_free(points, around, height)], height)[:, :2]


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[rs.Scene, rs.Scan]]:
    """The scene at rest and its first scan. 0.9 degrees is the finest beam that marine radars have (an antenna of 2.4 m); it
    leaves more buildings alone in their cells than a wider one, and 2048 azimuths step by a fifth of it."""
    folder = tmp_path_factory.mktemp("swinomish")
    scene = rs.load_scene(places.swinomish(folder, radar={"range_max_m": 4000.0}), folder=folder)
    yield scene, rs.Simulator(scene, seed=1).scan()


def test_pontoons_lie_by_the_buildings() -> None:
    # README of the input: 53 m says that north is north; with the files' Rotation of 180 degrees it would be 311 m
    middles = np.array([b.reshape(-1, 3).mean(axis=0)[:2] for b in places.buildings(places.CHANNEL)])
    lines = [places.east_north(line[:, 0], line[:, 1], places.CHANNEL) for line in places.pontoons()]
    distance = np.asarray(cKDTree(middles).query(np.array([line.mean(axis=0) for line in lines]))[0])
    assert len(lines) == 201 and 50.0 < np.median(distance) < 56.0


def test_loaded_buildings_stand_where_the_files_put_them(real: tuple[rs.Scene, rs.Scan]) -> None:
    scene, _ = real
    mine = np.concatenate(places.buildings(places.CHANNEL)).reshape(-1, 3)
    bodies = [body for body in scene.bodies if body.name.startswith("osm_")]
    loaded = np.concatenate([body.mesh.vertices + body.motion.position[0] for body in bodies if body.mesh is not None])
    apart = np.asarray(cKDTree(mine).query(loaded)[0])
    assert len(bodies) == 19 and apart.max() < 1e-6  # m, the rounding of sums of 10 km in float64 is 2e-12


def test_isolated_buildings_show_where_they_are(real: tuple[rs.Scene, rs.Scan]) -> None:
    scene, scan = real
    radar, height = scene.radar, scene.radar.height
    step, beam = scan.range_step, radar.beamwidth
    buildings = places.buildings(places.CHANNEL)
    within = extent(buildings, height)
    near = np.flatnonzero((within.far < 3900.0) & (within.near > 200.0))
    lines = [
        np.column_stack([places.east_north(a[:, 0], a[:, 1], places.CHANNEL), np.zeros(len(a))]) for a in places.pontoons()
    ]
    marks = [
        np.array([[*places.east_north(np.array([a]), np.array([b]), places.CHANNEL)[0], 0.0]]) for a, b in places.buoys()
    ]
    everything = extent([*buildings, *lines, *marks], height)
    alone = near[isolated(Extent(*(column[near] for column in within)), everything, GUARD_BINS * step, GUARD_BEAMS * beam)]
    found, faults = 0, []
    for k in alone:
        sector = (within.left <= within.right[k]) & (within.right >= within.left[k]) & (within.near <= within.far[k])
        around = np.concatenate([buildings[i] for i in np.flatnonzero(sector)])
        seen = visible_points(buildings[k], around, height, np.random.default_rng(int(k)))
        if len(seen) < SAMPLES // 10:
            continue
        distance, bearing = strongest_cell(scan, within, int(k), beam)
        off_range = np.abs(seen[:, 0] - distance)
        off_bearing = np.abs((seen[:, 1] - bearing + np.pi) % (2 * np.pi) - np.pi)
        found += 1
        if not np.any((off_range <= step) & (off_bearing <= beam / 4.0)):
            best = np.argmin(np.hypot(off_range / step, off_bearing / (beam / 4.0)))
            faults.append((int(k), distance, np.rad2deg(bearing), off_range[best] / step, off_bearing[best] / beam))
    assert found >= 10  # 60 of them at the last count
    assert not faults, "building, range, bearing [degrees] of its strongest cell, off by bins, by beamwidths"


def strongest_cell(scan: rs.Scan, within: Extent, k: int, beam: float) -> tuple[float, float]:
    """Range [m] and bearing [rad] of the strongest cell in the window about building k: its extent and half the guard."""
    middle, half = (within.left[k] + within.right[k]) / 2.0, (within.right[k] - within.left[k]) / 2.0
    offset = np.abs((scan.azimuth - middle + np.pi) % (2 * np.pi) - np.pi)
    rows = np.flatnonzero(offset <= half + GUARD_BEAMS / 2.0 * beam)
    margin = GUARD_BINS / 2.0 * scan.range_step
    columns = np.flatnonzero((scan.range >= within.near[k] - margin) & (scan.range <= within.far[k] + margin))
    window = scan.power[np.ix_(rows, columns)]
    i, j = np.unravel_index(np.argmax(window), window.shape)
    return float(scan.range[columns[j]]), float(scan.azimuth[rows[i]])
