"""Height maps as terrain meshes: grey PNG, .npy, TIFF. Row 0 is the north edge, column 0 the west edge.

A sample stands at each vertex; the corners that place a map are the outer pixels' centres. The mesh is flat east, north,
up: the earth's curvature is applied later, as seen from the antenna. Sea bed and land out of reach are left out.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.scene.error import SceneError
from radar_service.scene.geo import Origin, map_from_geographic
from radar_service.scene.mesh import LoadedMesh
from radar_service.scene.model import BodyModel
from radar_service.scene.raster import Raster
from radar_service.scene.world import Mesh

Floats = NDArray[np.float64]
Corners = tuple[tuple[float, float], tuple[float, float]]

LOWEST, HIGHEST = -11_000.0, 20_000.0  # m, as for any height of a scene
REACH = 2e6  # m, as for any coordinate of a scene
COARSE = 129  # samples a side at which the geodesic is solved


class Sight(NamedTuple):
    """What the radar can see of the ground: everything within `distance` [m] of a place east, north [m]."""

    east: float
    north: float
    distance: float


class Terrain(NamedTuple):
    """A loaded height map: its mesh in its own frame, and where that frame's origin stands (3,) [m]."""

    loaded: LoadedMesh
    position: Floats


def heightmap_terrain(
    body: BodyModel, raster: Raster, start: Floats, origin: Origin | None, sight: Sight, place: str
) -> Terrain:
    """The terrain of a height map: east, north by its extent or corners, heights in metres.

    raster: the file's samples; start: (3,) position_m [m], whose height is added; sight: beyond it triangles are dropped.
    Raises SceneError naming `place` and key where placement or heights are missing, contradictory or absurd.
    """
    heights = heights_from_raster(body, raster, place) + start[2]
    places = _placement(body, raster, start, origin, place)(heights.shape)
    if not np.abs(places).max() <= REACH:
        raise SceneError(f"{place}.heightmap: reaches {np.abs(places).max():g} m from the origin, not {REACH:g}; move it")
    corners = places[[0, 0, -1, -1], [0, -1, 0, -1]]
    middle = np.array([*corners.mean(axis=0), start[2]])
    faces, total = _seen_faces(places, heights, sight)
    if len(faces) == 0:
        raise SceneError(
            f"{place}.heightmap: none of its {total} triangles rises above the sea within {sight.distance:g} m of own "
            "ship; check low_m, high_m and where the map lies"
        )
    used = np.zeros(heights.size, dtype=np.bool_)
    used[faces] = True
    points = np.column_stack([places.reshape(-1, 2)[used], heights.ravel()[used]]) - middle
    compact = np.cumsum(used) - 1  # a large map has 100 million corners: too many to sort
    findings = list(raster.findings)
    if len(faces) < total:
        findings.append(f"{len(faces)} of {total} triangles kept, those above the sea and within reach of the radar")
    return Terrain(LoadedMesh(Mesh(points, compact[faces]), tuple(findings)), middle)


def heights_from_raster(body: BodyModel, raster: Raster, place: str) -> Floats:
    """Heights (rows, columns) [m]: greys scaled from low_m to high_m over the range of their type, or metres."""
    samples = raster.samples
    if body.low_m is None or body.high_m is None:
        if raster.grey:
            raise SceneError(f"{place}.low_m: missing; greys are no metres: give low_m (black) and high_m (white)")
        heights = samples.astype(np.float64)
        low, high = float(heights.min()), float(heights.max())
        if not (LOWEST <= low and high <= HIGHEST):
            raise SceneError(
                f"{place}.heightmap: heights from {low:g} to {high:g} m; a finite number from {LOWEST:g} to {HIGHEST:g}: "
                "replace marks for missing data, or scale with low_m and high_m"
            )
        return heights
    if not np.issubdtype(samples.dtype, np.integer):
        raise SceneError(f"{place}.low_m: {samples.dtype} samples are metres already; remove low_m and high_m")
    limits = np.iinfo(samples.dtype)
    share = (samples.astype(np.float64) - limits.min) / (float(limits.max) - float(limits.min))
    return body.low_m + share * (body.high_m - body.low_m)


def _placement(
    body: BodyModel, raster: Raster, start: Floats, origin: Origin | None, place: str
) -> Callable[[tuple[int, ...]], Floats]:
    """What gives the east, north (rows, columns, 2) [m] of every sample."""
    if body.extent_m is not None:
        extent = body.extent_m
        x, y = (start[k] + extent[k] * np.array([-0.5, 0.5]) for k in range(2))
        return lambda shape: _grid(x, y, shape)
    corners = raster.corners
    if body.south_west_deg is not None and body.north_east_deg is not None:
        corners = (body.south_west_deg, body.north_east_deg)
    if corners is None:
        raise SceneError(
            f"{place}.extent_m: missing; the file does not place itself: give extent_m, or south_west_deg and north_east_deg"
        )
    if origin is None:
        raise SceneError(f"{place}.heightmap: a map in latitude and longitude needs an [origin] in the scene; add one")
    (south, west), (north, east) = corners
    if not (south < north and west < east):
        raise SceneError(
            f"{place}.south_west_deg: [{south:g}, {west:g}] is not south and west of north_east_deg "
            f"[{north:g}, {east:g}]; exchange them"
        )
    home = origin

    def geographic(shape: tuple[int, ...]) -> Floats:
        grid = _grid(np.array([west, east]), np.array([south, north]), shape)
        return _mapped(grid, home)

    return geographic


def _grid(x: Floats, y: Floats, shape: tuple[int, ...]) -> Floats:
    """(rows, columns, 2): x from west to east along columns, y from north to south along rows."""
    rows, columns = shape
    across, down = np.linspace(x[0], x[1], columns), np.linspace(y[1], y[0], rows)
    return np.stack(np.broadcast_arrays(across[None, :], down[:, None]), axis=-1)


def _mapped(grid: Floats, origin: Origin) -> Floats:
    """East, north [m] of a grid of longitude, latitude [degrees].

    The geodesic is solved on at most 129 samples a side, and cubic splines laid through them: a step h of that grid errs by
    about h^4 / ae^3, under a millimetre for maps up to 10 degrees across; 4097 samples a side take a second, not ten.
    """
    rows, columns = (np.unique(np.linspace(0, side - 1, min(side, COARSE)).astype(np.int64)) for side in grid.shape[:2])
    coarse = grid[np.ix_(rows, columns)]
    places = map_from_geographic(coarse[..., 1], coarse[..., 0], origin)
    if coarse.shape == grid.shape:
        return places
    from scipy.interpolate import RectBivariateSpline  # here: it would take a sixth of every start

    every = np.arange(grid.shape[0]), np.arange(grid.shape[1])
    degree = min(3, len(rows) - 1), min(3, len(columns) - 1)
    parts = [RectBivariateSpline(rows, columns, places[..., k], kx=degree[0], ky=degree[1])(*every) for k in range(2)]
    return np.stack(parts, axis=-1)


def _seen_faces(places: Floats, heights: Floats, sight: Sight) -> tuple[NDArray[np.int64], int]:
    """Faces (F, 3), normals up, that reach above the sea and into sight; and how many there are without that."""
    rows, columns = heights.shape
    index = np.arange(rows * columns, dtype=np.int64).reshape(rows, columns)
    near = np.hypot(places[..., 0] - sight.east, places[..., 1] - sight.north) <= sight.distance
    high = heights >= 0.0
    kept = []
    for corners in (_upper, _lower):
        seen = _any(corners(high)) & _any(corners(near))
        kept.append(np.stack([corner[seen] for corner in corners(index)], axis=1))
    return np.concatenate(kept), 2 * (rows - 1) * (columns - 1)


def _any(corners: tuple[NDArray[np.bool_], ...]) -> NDArray[np.bool_]:
    a, b, c = corners
    return a | b | c


def _upper(grid: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    return grid[:-1, :-1], grid[1:, :-1], grid[:-1, 1:]


def _lower(grid: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    return grid[1:, 1:], grid[:-1, 1:], grid[1:, :-1]
