"""A real coast on the screen: the southern Channel Islands as terrain, held against a ray march over the PNG by own code."""

import functools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import radar_service as rs
from tests.real import places

pytestmark = places.present
Floats = NDArray[np.float64]

EARTH_RADIUS = 4.0 / 3.0 * 6_371_000.0  # m, effective
HERE = (33.08, -118.5)  # latitude, longitude between the two islands
POST = 111.3  # m from post to post: 1.0009765625 degrees over 1024 steps, along the meridian; 91 m along the parallel
STRIDE, SOLVED = 20.0, 25  # m from sample to sample of the march; the geodesic is solved at every SOLVED-th
CLEAR_DB = 15.0  # above the noise: one false alarm in exp(31) cells
FINE = 5  # bearings of the march per spoke
FALL_DB = 25.0  # below the strongest of a spoke: sidelobes in range (Blackman: -58 dB) and the skirts of the beam stay out


def geographic(points: Floats, origin: tuple[float, float]) -> Floats:
    """Latitude and longitude (n, 2) [degrees] of places east, north [m] of `origin`, by geodesic distance and bearing."""
    bearing_deg = np.rad2deg(np.arctan2(points[:, 0], points[:, 1]))
    home = np.full(len(points), origin[1]), np.full(len(points), origin[0])
    longitude, latitude, _ = places.EARTH.fwd(*home, bearing_deg, np.hypot(points[:, 0], points[:, 1]))
    return np.stack([latitude, longitude], axis=-1)


def ground(latlon: Floats) -> Floats:
    """Height [m] at latitude, longitude (..., 2): bilinear between the pixels, whose outermost lie on the corners."""
    heights = np.asarray(Image.open(places.REAL / "catalina.png"), dtype=np.float64) / 255.0 * (633.0 + 2063.0) - 2063.0
    last = heights.shape[0] - 1
    row = np.clip((places.NORTH_EAST[0] - latlon[..., 0]) / places.SIZE, 0, 1) * last
    column = np.clip((latlon[..., 1] - places.SOUTH_WEST[1]) / places.SIZE, 0, 1) * last
    i, j = (np.minimum(k.astype(np.int64), last - 1) for k in (row, column))
    s, t = row - i, column - j
    north = heights[i, j] * (1 - t) + heights[i, j + 1] * t
    south = heights[i + 1, j] * (1 - t) + heights[i + 1, j + 1] * t
    return np.asarray(north * (1 - s) + south * s)


@functools.cache
def coast(bearings: int, own: tuple[float, float], origin: tuple[float, float], height: float, reach: float) -> Floats:
    """Slant range (bearings,) [m] of the nearest land in sight along bearings all round, inf where there is none.

    own: east, north of the radar [m]; height: of the antenna [m]. A place is in sight where nothing nearer stands higher.
    """
    bearing = np.arange(bearings) * (2 * np.pi / bearings)
    distance = np.arange(0.0, reach, STRIDE)[1:]
    coarse = np.arange(0.0, reach + STRIDE * SOLVED, STRIDE * SOLVED)
    ahead = np.stack([np.sin(bearing), np.cos(bearing)], axis=-1)
    solved = geographic((own + coarse[:, None, None] * ahead).reshape(-1, 2), origin).reshape(len(coarse), len(bearing), 2)
    index = distance / (STRIDE * SOLVED)
    k = index.astype(np.int64)
    share = (index - k)[:, None, None]
    up = ground(solved[k] * (1 - share) + solved[k + 1] * share)
    z = np.maximum(up, 0.0) - (distance**2 / (2 * EARTH_RADIUS))[:, None] - height
    slope = z / distance[:, None]
    before = np.maximum.accumulate(slope, axis=0)
    in_sight = (up > 0) & (slope >= before)
    slant = np.where(in_sight, np.hypot(distance[:, None], z), np.inf)
    return np.asarray(slant.min(axis=0))


def nearest_echo(scan: rs.Scan, noise: float) -> Floats:
    """Range (A,) [m] of the first clear echo on each spoke, inf where there is none."""
    level = np.maximum(noise * 10 ** (CLEAR_DB / 10), scan.power.max(axis=1, keepdims=True) * 10 ** (-FALL_DB / 10))
    clear = scan.power > level
    return np.where(clear.any(axis=1), scan.range[np.argmax(clear, axis=1)], np.inf)


def scene(folder: Path, origin: tuple[float, float], **own_ship: Any) -> rs.Scene:
    """Own ship between the islands. From 5 m the far shores lie up to 50 m under the horizon: a flat earth would show."""
    own = places.east_north(np.array([HERE[0]]), np.array([HERE[1]]), origin)[0]
    changes = {"own_ship": {"position_m": own.tolist(), **own_ship}, "radar": {"azimuths": 360, "height_m": 5.0}}
    return rs.load_scene(places.catalina(folder, origin, **changes), folder=folder)


@pytest.mark.sample(2)
@pytest.mark.parametrize("origin", [HERE, places.CHANNEL], ids=["origin here", "origin 1,700 km away"])
@pytest.mark.parametrize("speed_kn", [0.0, 20.0])
def test_echoes_begin_at_the_coast(tmp_path: Path, origin: tuple[float, float], speed_kn: float) -> None:
    sea = scene(tmp_path, origin, course_deg=205.0, speed_kn=speed_kn)
    simulator = rs.Simulator(sea, seed=1)
    scan = simulator.scan()
    measured = nearest_echo(scan, simulator.noise_power)
    own = float(scan.position[0, 0]), float(scan.position[0, 1])
    shore = coast(FINE * sea.radar.azimuths, own, origin, sea.radar.height, sea.radar.range_max - 100.0)
    near, _ = within(shore, sea.radar.beamwidth)  # there the beam is 28.6 dB down, out and back: below FALL_DB
    _, far = within(shore, 0.25 * sea.radar.beamwidth)
    slack = POST / 2 + 3 * scan.range_step + scan.time[-1] * speed_kn * 1852 / 3600  # 3 bins: half a Blackman main lobe
    hit = np.isfinite(far)
    assert hit.sum() > 75  # spokes that look at land with a quarter of the beam on either side
    assert np.all(measured[hit] >= near[hit] - slack)
    assert np.all(measured[hit] <= far[hit] + slack)
    assert np.median(np.abs(measured[hit] - shore[::FINE][hit])) < 2 * POST  # most coasts here lie oblique to the beam
    assert np.all(measured[np.isinf(near)] == np.inf)


def within(shore: Floats, reach: float) -> tuple[Floats, Floats]:
    """The nearest and the farthest coast [m] within `reach` [rad] of each spoke, and half a post more: the contour of a
    bilinear surface and that of two triangles over the same posts lie at most that far apart."""
    step = 2 * np.pi / len(shore)
    bounds = []
    for k in range(0, len(shore), FINE):
        about = np.take(shore, np.arange(k - 4 * FINE, k + 4 * FINE + 1), mode="wrap").min()
        half = int(np.ceil((reach + POST / 2 / about) / step))
        wide = np.take(shore, np.arange(k - half, k + half + 1), mode="wrap")
        bounds.append((wide.min(), wide.max()))
    nearest, farthest = np.array(bounds).T
    return nearest, farthest
