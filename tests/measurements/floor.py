"""The floor: the work of a scan in libraries, repeated by the libraries alone.

A scan is watched once: every FFT by its shape, every draw of normal numbers by its count, every batch of rays by itself, every
product with which the beam sums rows of clutter, every sample of clutter that texture modulates, the echoes spread azimuth by
azimuth, and the bytes of the profiles handed over. The floor is the time of the same FFTs and products over other numbers,
the same draws, the same rays through the same trees, and of moving the bytes: one pass over the profiles for each time that a
scan must touch them (rest added, clutter added, power taken), one over the draws (each has its weight in the spectrum), one
look-up and one product for each modulated sample, and one pass over the grid cells that each spread echo must touch at each
azimuth, in pieces that stay in the cache.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.fft

import radar_service as rs
from radar_service.kernels.library import KERNELS
from radar_service.numerics.random import normals
from radar_service.receive import compression, noise
from radar_service.receive.gridding import spread_moving
from radar_service.stages.clutter import clutter, sea_clutter, texture, texture_rows
from radar_service.stages.clutter.azimuth_rows import weight_rows
from radar_service.trace.embree import TriangleScene

CACHED = 2**14  # grid cells, 128 KiB


@dataclass
class Work:
    """The work of one scan."""

    ffts: list[tuple[str, tuple[int, ...], np.dtype[Any], int | None, int]] = field(default_factory=list)
    draws: list[tuple[int, int]] = field(default_factory=list)
    products: list[tuple[int, int, int]] = field(default_factory=list)
    textures: list[tuple[int, int]] = field(default_factory=list)
    cells: int = 0  # of grids, that echoes were spread on
    rays: list[tuple[Any, ...]] = field(default_factory=list)  # tree, origins and directions in float32
    profiles: list[tuple[int, int]] = field(default_factory=list)

    @property
    def ray_count(self) -> int:
        return sum(len(direction) for _, _, direction in self.rays)


@contextmanager
def watched(work: Work) -> Iterator[None]:
    """While it lasts, calls of scipy.fft, generators and Embree are noted in `work`."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("fft", "ifft"):
            patch.setattr(scipy.fft, name, _noting_fft(getattr(scipy.fft, name), name, work))
        patch.setattr(texture_rows, "normals", _noting_normals(work))
        patch.setattr(noise, "KERNELS", SimpleNamespace(weighted_normals=_noting_noise(KERNELS.weighted_normals, work)))
        for module in (clutter, sea_clutter):
            patch.setattr(module, "weight_rows", _noting_products(work))
        patch.setattr(texture.TextureTable, "roots", _noting_textures(texture.TextureTable.roots, work))
        patch.setattr(compression, "spread_moving", _noting_spread(work))
        for name in ("first_hit_of", "occluded"):
            patch.setattr(TriangleScene, name, _noting_rays(getattr(TriangleScene, name), work))
        yield


def _noting_fft(original: Callable[..., Any], name: str, work: Work) -> Callable[..., Any]:
    def noting(x: Any, n: int | None = None, axis: int = -1, **more: Any) -> Any:
        work.ffts.append((name, np.shape(x), np.asarray(x).dtype, n, axis))
        return original(x, n, axis, **more)

    return noting


def _noting_normals(work: Work) -> Callable[..., Any]:
    def noting(rng: np.random.Generator, rows: int, columns: int) -> Any:
        work.draws.append((rows, columns))
        return normals(rng, rows, columns)

    return noting


def _noting_noise(original: Callable[..., Any], work: Work) -> Callable[..., Any]:
    def noting(rows: int, above: int, gap: int, below: int, *more: Any) -> Any:
        work.draws.append((rows, above + below))
        return original(rows, above, gap, below, *more)

    return noting


def _noting_products(work: Work) -> Callable[..., Any]:
    def noting(weights: Any, rows: Any) -> Any:
        summed = weight_rows(weights, rows)
        work.products.append((*weights.shape, summed.shape[1]))
        return summed

    return noting


def _noting_textures(original: Callable[..., Any], work: Work) -> Callable[..., Any]:
    def noting(self: texture.TextureTable, gaussian: Any, direction: Any = None) -> Any:
        work.textures.append(gaussian.shape)
        return original(self, gaussian, direction)

    return noting


def _noting_spread(work: Work) -> Callable[..., Any]:
    def noting(rows: Any, column: Any, range_migration: Any, amplitude: Any, tables: Any) -> None:
        work.cells += amplitude.size * tables[0].shape[2]
        spread_moving(rows, column, range_migration, amplitude, tables)

    return noting


def _noting_rays(original: Callable[..., Any], work: Work) -> Callable[..., Any]:
    def noting(self: TriangleScene, origin: Any, direction: Any, *reach: Any) -> Any:
        if len(direction):
            centre = self.centre if reach else 0.0  # first hits are asked for about the centre already
            origins = np.broadcast_to(origin - centre, direction.shape)
            rays = (np.ascontiguousarray(array, dtype=np.float32) for array in (origins, direction))
            work.rays.append((self._tree(), *rays))
        return original(self, origin, direction, *reach)

    return noting


def scan_work(sim: rs.Simulator) -> Work:
    """The work of the next scan."""
    work = Work()
    with watched(work):
        work.profiles = [block.field.shape for block in sim.blocks(scans=1)]
    return work


def floor_seconds(work: Work) -> float:
    """CPU time [s] of doing `work` once, all arrays made beforehand."""
    rng = np.random.default_rng(0)
    transforms = [
        (getattr(scipy.fft, name), np.ones(shape, dtype), n, axis) for name, shape, dtype, n, axis in work.ffts[:200]
    ]
    share = len(work.ffts) / max(len(transforms), 1)
    total = 0.0
    start = time.process_time()
    for transform, x, n, axis in transforms:
        transform(x, n, axis)
    total += (time.process_time() - start) * share
    start = time.process_time()
    for rows, columns in work.draws:
        draws = normals(rng, rows, columns)
        np.multiply(draws, draws, out=draws)
    for tree, origins, directions in work.rays:
        tree.first_hit(origins, directions)
    total += time.process_time() - start
    factors = [(np.ones((k, j), np.float32), np.ones((j, n), np.float32)) for k, j, n in work.products[:200]]
    start = time.process_time()
    for left, right in factors:
        np.matmul(left, right)
    total += (time.process_time() - start) * len(work.products) / max(len(factors), 1)
    table = np.ones(2**15, np.float32)
    for shape in set(work.textures):
        entry = rng.integers(0, len(table), shape)
        modulation, speckle = np.ones(shape, np.float32), np.ones(shape, np.complex64)
        start = time.process_time()
        for _ in range(work.textures.count(shape)):
            table.take(entry, out=modulation, mode="clip")
            np.multiply(speckle, modulation, out=speckle)
        total += time.process_time() - start
    cached, grid = np.ones(CACHED, np.complex64), np.ones(CACHED, np.complex64)
    start = time.process_time()
    for _ in range(work.cells // CACHED):
        np.add(cached, cached, out=grid)
    total += time.process_time() - start
    for shape in set(work.profiles):
        a, b, power = np.ones(shape, np.complex64), np.ones(shape, np.complex64), np.ones(shape, np.float32)
        start = time.process_time()
        for _ in range(work.profiles.count(shape)):
            np.add(a, a, out=b)
            np.add(a, a, out=b)
            np.multiply(a.real, a.real, out=power)
        total += time.process_time() - start
    return total
