"""Real buildings on the screen: 19 tiles of OpenStreetMap buildings, 201 pontoons and 22 marks of the Swinomish Channel."""

import functools
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import radar_service as rs
from radar_service.radar.parameters import Radar
from tests.real import places

pytestmark = places.present
Floats = NDArray[np.float64]

EARTH_RADIUS = 4.0 / 3.0 * 6_371_000.0  # m, effective
GUARD_BINS, GUARD_BEAMS = 8, 2.0  # empty margin about a building: beyond the main lobes, 4 bins and 1.13 beamwidths wide
REACH = 3500.0  # m, of the radar: the tiles round the channel
SAMPLES = 300  # points on a building: on the 200 m^2 that show of it, one every 0.8 m, a third of a range bin


class Extent(NamedTuple):
    """Ranges [m] and bearings [rad] between which things lie, each (n,)."""

    near: Floats
    far: Floats
    left: Floats
    right: Floats


def polar(points: Floats, height: float) -> Floats:
    """Slant range [m], bearing and elevation [rad] (..., 3) of places, from `height` over the origin
    (docs/conventions.md)."""
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
    """Which points (n, 3) no triangle (m, 3, 3) hides from the antenna, by signed volumes over all pairs: a ray goes
    through a triangle where it passes all three edges on one side."""
    antenna = np.array([0.0, 0.0, height])
    ray, corners = bent(points) - antenna, bent(triangles) - antenna
    sides = np.stack([ray @ np.cross(corners[:, i], corners[:, (i + 1) % 3]).T for i in range(3)])
    through = (sides >= 0).all(axis=0) | (sides <= 0).all(axis=0)
    total = sides.sum(axis=0)
    where = np.linalg.det(corners) / np.where(total == 0, np.inf, total)  # share of the way to the point
    # what a point lies on does not hide it: a millionth of the way is 4 mm at 4 km, against buildings of metres
    hidden: NDArray[np.bool_] = np.any(through & (where > 0) & (where < 1 - 1e-6), axis=1)
    return ~hidden


def bent(points: Floats) -> Floats:
    """Places (..., 3) lowered by the earth's drop as seen from the origin (docs/conventions.md)."""
    lowered = points.copy()
    lowered[..., 2] -= (points[..., 0] ** 2 + points[..., 1] ** 2) / (2.0 * EARTH_RADIUS)
    return lowered


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


@functools.cache
def channel() -> rs.Scene:
    """The scene, as the files have it."""
    with tempfile.TemporaryDirectory() as folder:
        return rs.load_scene(places.swinomish(Path(folder)), folder=Path(folder))


def scanned(folder: Path, speed_kn: float, beamwidth_deg: float, azimuths: int) -> tuple[rs.Scene, rs.Scan]:
    """The scene, and its first scan with own ship going down the channel."""
    radar = {"range_max_m": REACH, "beamwidth_deg": beamwidth_deg, "azimuths": azimuths}
    changes = {"radar": radar, "own_ship": {"course_deg": 200.0, "speed_kn": speed_kn}}
    empty = rs.load_scene(places.swinomish(folder, **changes) | {"body": []}, folder=folder)
    scene = empty.with_world(bodies=channel().bodies)
    return scene, rs.Simulator(scene, seed=1).scan()


def test_pontoons_lie_by_the_buildings() -> None:
    # README of the input: 53 m says that north is north; with the files' Rotation of 180 degrees it would be 311 m
    middles = np.array([b.reshape(-1, 3).mean(axis=0)[:2] for b in places.buildings(places.CHANNEL)])
    lines = [places.east_north(line[:, 0], line[:, 1], places.CHANNEL) for line in places.pontoons()]
    distance = np.asarray(cKDTree(middles).query(np.array([line.mean(axis=0) for line in lines]))[0])
    assert len(lines) == 201 and 50.0 < np.median(distance) < 56.0


def test_loaded_buildings_stand_where_the_files_put_them() -> None:
    scene = channel()
    mine = np.concatenate(places.buildings(places.CHANNEL)).reshape(-1, 3)
    bodies = [body for body in scene.bodies if body.name.startswith("osm_")]
    loaded = np.concatenate([body.mesh.vertices + body.motion.position[0] for body in bodies if body.mesh is not None])
    apart = np.asarray(cKDTree(mine).query(loaded)[0])
    assert len(bodies) == 19 and apart.max() < 1e-6  # m, the rounding of sums of 10 km in float64 is 2e-12
    faces = sum(len(body.mesh.faces) for body in bodies if body.mesh is not None)
    assert 0.99 * len(mine) < 3 * faces <= len(mine)  # what is dropped has no area or stands there twice
    assert not scene.warnings and not any("not watertight (" in note for note in scene.notes)


# 0.9 degrees is the finest beam that marine radars have (an antenna of 2.4 m): it leaves more buildings alone in their cells
# than a wider one, and 2048 azimuths step by a fifth of it. Under way every azimuth is gridded anew, so there are fewer.
@pytest.mark.parametrize(
    ("speed_kn", "beamwidth_deg", "azimuths"),
    [(0.0, 0.9, 2048), pytest.param(15.0, 1.2, 1024, marks=pytest.mark.study)],
    ids=["at rest", "under way"],
)
def test_isolated_buildings_show_where_they_are(
    tmp_path: Path, speed_kn: float, beamwidth_deg: float, azimuths: int
) -> None:
    scene, scan = scanned(tmp_path, speed_kn, beamwidth_deg, azimuths)
    result, faults = 0, []
    geometry = float(np.hypot(*scan.position[-1]))
    for building, around in alone_within(REACH - 100.0, scene.radar, geometry)[::3]:
        own = position_when_passed(building, scan)
        seen = visible_points(building - own, around - own, scene.radar.height, np.random.default_rng(result))
        if len(seen) < SAMPLES // 10:
            continue
        result += 1
        distance, bearing = strongest_cell(scan, extent([building - own], scene.radar.height), scene.radar.beamwidth)
        off_range = np.abs(seen[:, 0] - distance) / scan.range_step
        off_bearing = turn_between(seen[:, 1], bearing) / scene.radar.beamwidth
        if not np.any((off_range <= 1.0) & (off_bearing <= 0.25)):
            faults.append((distance, np.rad2deg(bearing), off_range.min(), off_bearing.min()))
    assert result >= 10
    assert not faults, "range, bearing [degrees] of the strongest cell; how far from anything seen in bins, in beamwidths"


def alone_within(reach: float, radar: Radar, sailed: float) -> list[tuple[Floats, Floats]]:
    """Triangles of each isolated building between 200 m and `reach` [m], and of all that might stand before it as seen from
    anywhere within `sailed` [m] of the origin."""
    buildings = places.buildings(places.CHANNEL)
    lines = [
        np.column_stack([places.east_north(a[:, 0], a[:, 1], places.CHANNEL), np.zeros(len(a))]) for a in places.pontoons()
    ]
    marks = [
        np.array([[*places.east_north(np.array([a]), np.array([b]), places.CHANNEL)[0], 0.0]]) for a, b in places.buoys()
    ]
    everything = extent([*buildings, *lines, *marks], radar.height)
    near = np.flatnonzero(
        (everything.far < reach) & (everything.near > 200.0) & (np.arange(len(everything.far)) < len(buildings))
    )
    chosen = Extent(*(column[near] for column in everything))
    alone = near[isolated(chosen, everything, GUARD_BINS * radar.range_step, GUARD_BEAMS * radar.beamwidth)]
    result = []
    for k in alone:
        turn = sailed / everything.near[k]
        left, right = everything.left[k] - turn, everything.right[k] + turn
        before = (everything.left <= right) & (everything.right >= left) & (everything.near <= everything.far[k])
        result.append((buildings[k], np.concatenate([buildings[i] for i in np.flatnonzero(before[: len(buildings)])])))
    return result


def position_when_passed(building: Floats, scan: rs.Scan) -> Floats:
    """East, north, 0 [m] of own ship when the beam looked at the building."""
    middle = building.reshape(-1, 3).mean(axis=0)
    row = np.argmin(turn_between(scan.azimuth, np.arctan2(middle[0], middle[1])))
    return np.array([*scan.position[row], 0.0])


def turn_between(a: Floats, b: Floats | float) -> Floats:
    """Angle [rad] from bearing a to b, either way."""
    return np.asarray(np.abs((a - b + np.pi) % (2 * np.pi) - np.pi))


def strongest_cell(scan: rs.Scan, within: Extent, beam: float) -> tuple[float, float]:
    """Range [m] and bearing [rad] of the strongest cell in the window about one building: its extent and half the guard."""
    middle, half = (within.left[0] + within.right[0]) / 2.0, (within.right[0] - within.left[0]) / 2.0
    rows = np.flatnonzero(turn_between(scan.azimuth, middle) <= half + GUARD_BEAMS / 2.0 * beam)
    margin = GUARD_BINS / 2.0 * scan.range_step
    columns = np.flatnonzero((scan.range >= within.near[0] - margin) & (scan.range <= within.far[0] + margin))
    window = scan.power[np.ix_(rows, columns)]
    i, j = np.unravel_index(np.argmax(window), window.shape)
    return float(scan.range[columns[j]]), float(scan.azimuth[rows[i]])
