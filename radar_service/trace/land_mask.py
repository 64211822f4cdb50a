"""The land of a scene as a raster on the map: which material its ground has, how high it is, and which landmass it belongs to."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Self

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Flags, Floats, Indices, Singles, batches, spans
from radar_service.world import MATERIALS, Body, is_diffuse_land, is_land, pose_at

CELLS, FINEST = 2**20, 1.0  # of a raster at most (9 MB), and the size of a cell of small land [m]
ROWS, COVERED = 2**16, 2**20  # of triangles (as many at most), and cells that they cover, worked on at once: 60 MB
ROUNDING = 1e-9  # of a cell, by which triangles are wider: neighbours leave no gap between them
WATER = 0  # material and landmass of what is no land


@dataclass(frozen=True)
class LandMask:
    """Cells (N, M) from south to north and from west to east. Those at the edges are water, as is all beyond.

    corner: (2,) east and north of the middle of the first cell [m].
    cell: size of a cell [m].
    material: (N, M) of the highest land in the middle of each cell, its number in MATERIALS from 1 on; WATER.
    height: (N, M) of that land above the sea [m].
    landmass: (N, M) number of the connected land that a cell belongs to, from 1 on; WATER.
    diffuse: (B,) which bodies are diffuse land.
    """

    corner: Floats
    cell: float
    material: NDArray[np.uint8]
    height: Singles
    landmass: NDArray[np.int32]
    diffuse: Flags

    @classmethod
    def of(cls, bodies: Sequence[Body]) -> Self | None:
        """The mask of those bodies that are land and always there; None without any."""
        from scipy.ndimage import label  # here: most scenes have no use for it

        land = [body for body in bodies if is_land(body) and body.at_rest]
        meshes = [(pose_at(body, 0.0).map_from_frame(body.mesh.vertices), body.mesh.faces) for body in land if body.mesh]
        if not meshes:
            return None
        low = np.min([vertices[:, :2].min(axis=0) for vertices, _ in meshes], axis=0)
        size = np.max([vertices[:, :2].max(axis=0) for vertices, _ in meshes], axis=0) - low
        cell = max(FINEST, float(np.sqrt(size[0] * size[1] / CELLS)), float(size.max()) / CELLS)
        columns, rows = np.ceil(size / cell).astype(np.int64) + 2
        material, height = np.zeros(rows * columns, dtype=np.uint8), np.zeros(rows * columns, dtype=np.float32)
        for body, (vertices, faces) in zip(land, meshes, strict=True):
            place = np.column_stack([(vertices[:, :2] - low) / cell + 0.5, vertices[:, 2]])
            parts = (_covered(place, faces[begin : begin + ROWS]) for begin in range(0, len(faces), ROWS))
            for row, column, up in chain.from_iterable(parts):
                index = row * columns + column
                higher = np.flatnonzero(up > height[index])
                higher = higher[np.argsort(up[higher], kind="stable")]  # the highest is the last, which stays
                height[index[higher]], material[index[higher]] = up[higher], list(MATERIALS).index(body.material.name) + 1
        shape = rows, columns
        diffuse = np.array([is_diffuse_land(body) for body in bodies])
        landmass = np.empty(shape, dtype=np.int32)
        label(material.reshape(shape), np.ones((3, 3)), output=landmass)
        return cls(low - cell / 2.0, cell, material.reshape(shape), height.reshape(shape), landmass, diffuse)

    def at(self, east: Floats, north: Floats) -> Indices:
        """Indices of the cells that hold positions on the map, any shape [m]; they count rows one after the other."""
        rows, columns = self.material.shape
        column, row = ((where - edge) / self.cell + 0.5 for where, edge in zip((east, north), self.corner, strict=True))
        inside = np.minimum(np.maximum(row, 0.0), rows - 1.0).astype(np.int64)
        return np.asarray(inside * columns + np.minimum(np.maximum(column, 0.0), columns - 1.0).astype(np.int64))


def _covered(place: Floats, faces: Indices) -> Iterator[tuple[Indices, Indices, Floats]]:
    """Rows and columns (P,) of raster points that triangles cover in plan, and heights (P,) of the triangles there [m].

    place: (V, 3) column, row and height of each vertex; faces: (F, 3).
    """
    y = place[faces, 1]
    first, end = np.ceil(y.min(axis=1) - ROUNDING).astype(np.int64), np.floor(y.max(axis=1) + ROUNDING).astype(np.int64) + 1
    dry = np.flatnonzero((end > first) & (place[faces, 2].max(axis=1) > 0.0))
    for some in batches((end - first)[dry], ROWS):
        triangle, row = spans(first[dry[some]], end[dry[some]])
        begin = place[faces[dry[some]]].transpose(1, 2, 0)[..., triangle]  # by corner and axis
        way, at = begin[[1, 2, 0]] - begin, np.arange(len(row))
        share = np.divide(row - begin[:, 1], way[:, 1], out=np.full((3, len(row)), -1.0), where=way[:, 1] != 0.0)
        met, (x, _, z) = np.abs(share - 0.5) < 0.5 + ROUNDING, (begin + share[:, None] * way).swapaxes(0, 1)
        ends = np.where(met, x, np.inf).argmin(axis=0), np.where(met, x, -np.inf).argmax(axis=0)
        (left, right), (low, high) = ([each[end, at] for end in ends] for each in (x, z))
        column = np.ceil(left - ROUNDING).astype(np.int64)
        count = np.where(met.any(axis=0), np.floor(right + ROUNDING).astype(np.int64) + 1 - column, 0)
        for part in batches(np.maximum(count, 0), COVERED):
            line, across = spans(column[part], (column + count)[part])
            line += part.start
            slope = (high - low)[line] / np.maximum(right - left, ROUNDING)[line]
            yield row[line], across, low[line] + np.clip(across - left[line], 0.0, (right - left)[line]) * slope
