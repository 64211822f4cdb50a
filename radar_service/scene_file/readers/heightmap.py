"""Builds terrain meshes from height maps. Row 0 is the north edge, column 0 the west edge.

Each sample is a vertex; the corners of a map are the centres of its outer pixels. The mesh is in flat east, north, up
coordinates: the engine applies the earth's curvature. Sea bed and land outside radar coverage are removed. Where the rim of a
map stands above the sea, a skirt closes it: a wall, which faces outward, from the rim down below the sea.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import MAX_COORDINATE, Flags, Floats, Indices
from radar_service.scene_file.model.body import HeightMapBodyModel
from radar_service.scene_file.readers.file_format import LoadedBody
from radar_service.scene_file.readers.formats import examples
from radar_service.scene_file.readers.raster import Raster, raster_from_bytes
from radar_service.stages.fields import MAX_HEIGHT, MIN_HEIGHT
from radar_service.world import Mesh, Origin, SceneError, map_from_geographic

SEA_BED = -1.0  # m, height of samples without data: land beside them ends at the sea
SKIRT_FOOT = -1.0  # m, height of the lower end of skirts: below the sea, so that nothing shows between them and it
MAX_GEODESIC_SAMPLES = 129  # per side; between them the positions are interpolated


class Coverage(NamedTuple):
    """The area that the radar can reach: a circle of `radius` [m] about the position east, north [m]."""

    east: float
    north: float
    radius: float


@dataclass(frozen=True)
class HeightMapFile:
    """A height map that is to be read. body, start, origin, coverage: as for heightmap_terrain.

    body_location: key path of its body.
    """

    max_bodies: ClassVar[int] = 1
    placed: ClassVar[bool] = True

    content: bytes
    name: str
    body: HeightMapBodyModel
    start: Floats
    origin: Origin | None
    coverage: Coverage
    body_location: str

    @property
    def location(self) -> str:
        """Key path and name of the file."""
        return f"{self.body_location}.heightmap: {self.name}"

    def read(self) -> tuple[LoadedBody, ...]:
        """Returns its land; errors as raster_from_bytes and heightmap_terrain."""
        raster = raster_from_bytes(self.content, self.name, self.location)
        return (heightmap_terrain(self.body, raster, self.start, self.origin, self.coverage, self.body_location),)

    @classmethod
    def examples(cls) -> list["HeightMapFile"]:
        """Returns a small file of each format whose reader works."""
        keys = {"low_m": 0.0, "high_m": 9.0, "south_west_deg": (50.0, 1.0), "north_east_deg": (50.1, 1.1)}
        body = HeightMapBodyModel.model_validate({"name": "example", "heightmap": "example", **keys})
        around, reached = (50.0, 1.0), Coverage(0.0, 0.0, 1e5)
        return [cls(content, name, body, np.zeros(3), around, reached, "example") for name, content in examples("rasters")]


def heightmap_terrain(
    body: HeightMapBodyModel, raster: Raster, start: Floats, origin: Origin | None, coverage: Coverage, location: str
) -> LoadedBody:
    """Returns the terrain of a height map: east, north by its extent or corners, heights in metres.

    raster: the file's samples. start: position_m (3,) [m]; its height is added to the samples. coverage: triangles
    outside it are removed. Raises SceneError at `location` if the placement or the heights are missing or invalid.
    """
    heights = heights_from_raster(body, raster, location) + start[2]
    if raster.empty is not None:
        heights[raster.empty] = SEA_BED
    positions = _placement(body, raster, start, origin, location)
    if not np.abs(positions).max() <= MAX_COORDINATE:
        raise SceneError(
            f"{location}.heightmap: the map extends {np.abs(positions).max():g} m from the origin; at most "
            f"{MAX_COORDINATE:g} m are allowed: move it"
        )
    corners = positions[[0, 0, -1, -1], [0, -1, 0, -1]]
    middle = np.array([*corners.mean(axis=0), start[2]])
    faces, rim = _faces_in_coverage(positions, heights, coverage)
    total = 2 * (heights.shape[0] - 1) * (heights.shape[1] - 1)
    if len(faces) == 0:
        reach = f" within {coverage.radius:g} m of own ship" if np.isfinite(coverage.radius) else ""
        raise SceneError(
            f"{location}.heightmap: none of the {total} triangles rises above the sea{reach}; check low_m, high_m and the "
            "position of the map"
        )
    used = np.zeros(heights.size, dtype=np.bool_)
    used[faces] = True
    points = np.column_stack([positions.reshape(-1, 2)[used], heights.ravel()[used]]) - middle
    compact = np.cumsum(used) - 1  # np.unique would sort the 100 million corners of a large map
    findings = list(raster.findings)
    mesh = with_skirt(Mesh(points, compact[faces]), compact[rim], SKIRT_FOOT - start[2])
    if len(rim):
        findings.append(f"its rim stands up to {heights.ravel()[rim].max():.3g} m above the sea: a wall closes it")
    if len(faces) < total:
        findings.append(f"{len(faces)} of {total} triangles kept, those above the sea and within radar coverage")
    return LoadedBody(mesh, tuple(findings), middle)


def heights_from_raster(body: HeightMapBodyModel, raster: Raster, location: str) -> Floats:
    """Returns heights (rows, columns) [m]: greys scaled from low_m to high_m over the range of their type, or metres.

    Those of samples without data mean nothing.
    """
    samples = raster.samples if raster.empty is None else np.where(raster.empty, 0, raster.samples)
    if body.low_m is None or body.high_m is None:
        if raster.grey:
            raise SceneError(f"{location}.low_m: missing; grey values are not metres: give low_m (black) and high_m (white)")
        heights = samples.astype(np.float64)
        low, high = float(heights.min()), float(heights.max())
        if not (MIN_HEIGHT <= low and high <= MAX_HEIGHT):
            raise SceneError(
                f"{location}.heightmap: heights from {low:g} to {high:g} m are not allowed; {MIN_HEIGHT:g} to "
                f"{MAX_HEIGHT:g} m: replace missing-data values, or scale with low_m and high_m"
            )
        return heights
    if not np.issubdtype(samples.dtype, np.integer):
        raise SceneError(f"{location}.low_m: {samples.dtype} samples are already metres; remove low_m and high_m")
    limits = np.iinfo(samples.dtype)
    share = (samples.astype(np.float64) - limits.min) / (float(limits.max) - float(limits.min))
    return body.low_m + share * (body.high_m - body.low_m)


def _placement(
    body: HeightMapBodyModel, raster: Raster, start: Floats, origin: Origin | None, location: str
) -> Floats:  # fmt: skip
    """Returns the east, north (rows, columns, 2) [m] of the samples of a map."""
    shape = raster.samples.shape
    if body.extent_m is not None:
        extent = body.extent_m
        x, y = (start[k] + extent[k] * np.array([-0.5, 0.5]) for k in range(2))
        return _grid(x, y, shape)
    corners = raster.corners
    if body.south_west_deg is not None and body.north_east_deg is not None:
        corners = (body.south_west_deg, body.north_east_deg)
    if corners is None:
        raise SceneError(f"{location}.extent_m: missing; {raster.unplaced} extent_m, or south_west_deg and north_east_deg")
    if origin is None:
        raise SceneError(f"{location}.heightmap: a map in latitude and longitude needs an [origin] in the scene; add one")
    (south, west), (north, east) = corners
    if not (south < north and west < east):
        remedy = "exchange them"
        if south < north and west - east > 180.0:
            remedy = (
                f"the map crosses 180 degrees, where these keys end: gdal_translate -a_srs EPSG:4326 -a_ullr {west:g} {north:g} "
                f"{east + 360.0:g} {south:g} IN OUT.tif makes a file that needs none of them"
            )
        raise SceneError(
            f"{location}.south_west_deg: [{south:g}, {west:g}] is not south and west of north_east_deg "
            f"[{north:g}, {east:g}]; {remedy}"
        )
    return _map_positions(_grid(np.array([west, east]), np.array([south, north]), shape), origin)


def _grid(x: Floats, y: Floats, shape: tuple[int, ...]) -> Floats:
    """Returns (rows, columns, 2): x from west to east along columns, y from north to south along rows."""
    rows, columns = shape
    across, down = np.linspace(x[0], x[1], columns), np.linspace(y[1], y[0], rows)
    return np.stack(np.broadcast_arrays(across[None, :], down[:, None]), axis=-1)


def _map_positions(grid: Floats, origin: Origin) -> Floats:
    """Returns east, north [m] of a grid of longitude, latitude [degrees].

    The geodesic is solved on at most 129 samples per side; cubic splines interpolate between them. A step h of that grid
    gives an error of about h^4 / ae^3: below 1 mm for maps of up to 10 degrees. 4097 samples per side take 1 s, not 10 s.
    """
    rows, columns = (
        np.unique(np.linspace(0, side - 1, min(side, MAX_GEODESIC_SAMPLES)).astype(np.int64)) for side in grid.shape[:2]
    )
    coarse = grid[np.ix_(rows, columns)]
    positions = map_from_geographic(coarse[..., 1], coarse[..., 0], origin)
    if coarse.shape == grid.shape:
        return positions
    from scipy.interpolate import RectBivariateSpline  # here, because it takes a sixth of the start-up time

    every = np.arange(grid.shape[0]), np.arange(grid.shape[1])
    degree = min(3, len(rows) - 1), min(3, len(columns) - 1)
    parts = [RectBivariateSpline(rows, columns, positions[..., k], kx=degree[0], ky=degree[1])(*every) for k in range(2)]
    return np.stack(parts, axis=-1)


def with_skirt(mesh: Mesh, rim: Indices, foot: float) -> Mesh:
    """Returns a mesh with a wall from its rim down to the height `foot` [m], where the rim is higher.

    rim: edges (E, 2) as vertices, with the surface to their left as seen from above.
    """
    above, upper = np.unique(rim), mesh.vertices[np.unique(rim)]
    lower = np.column_stack([upper[:, :2], np.minimum(upper[:, 2], foot)])
    first = len(mesh.vertices)
    begin, end = rim.T
    under_begin, under_end = (first + np.searchsorted(above, corner) for corner in (begin, end))
    walls = np.concatenate(
        [
            np.stack([end, begin, under_begin], axis=1)[mesh.vertices[begin, 2] > foot],
            np.stack([end, under_begin, under_end], axis=1)[mesh.vertices[end, 2] > foot],
        ]
    )
    return Mesh(np.concatenate([mesh.vertices, lower]), np.concatenate([mesh.faces, walls]))


def _faces_in_coverage(positions: Floats, heights: Floats, coverage: Coverage) -> tuple[Indices, Indices]:
    """Returns faces (F, 3), normals up, that rise above the sea inside the coverage, and their edges (E, 2) on the rim of the map
    that do, with the land to their left."""
    rows, columns = heights.shape
    index = np.arange(rows * columns, dtype=np.int64).reshape(rows, columns)
    near = np.hypot(positions[..., 0] - coverage.east, positions[..., 1] - coverage.north) <= coverage.radius
    high = heights >= 0.0
    upper, lower = (_any(corners(high)) & _any(corners(near)) for corners in (_upper, _lower))
    kept = [
        np.stack([corner[inside] for corner in corners(index)], axis=1)
        for corners, inside in ((_upper, upper), (_lower, lower))
    ]
    sides = (
        (index[0, ::-1], upper[0, ::-1]),
        (index[-1], lower[-1]),
        (index[:, 0], upper[:, 0]),
        (index[::-1, -1], lower[::-1, -1]),
    )
    edges = np.concatenate([np.stack([side[:-1], side[1:]], axis=1)[inside] for side, inside in sides])
    return np.concatenate(kept), edges[(heights.ravel()[edges] > 0.0).any(axis=1)]


def _any(corners: tuple[Flags, ...]) -> Flags:
    a, b, c = corners
    return a | b | c


def _upper(grid: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    return grid[:-1, :-1], grid[1:, :-1], grid[:-1, 1:]


def _lower(grid: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    return grid[1:, 1:], grid[:-1, 1:], grid[1:, :-1]
