"""The PPI: spokes accumulated by azimuth, and turned from (range, azimuth) into (x, y). `picture` draws it for people.

An image of `size` pixels covers the square of half-width `range_max` about own ship. Row 0 is the top, and `up` is the
bearing at the top: "north", or a heading [rad]. Polar arrays are (azimuths, bins); row k looks along k x 2 pi/azimuths,
boresight centred, and sample n stands at range_first + n x range_step with a cell that reaches half a step either way.
"""

from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

Floats = NDArray[np.float64]
Reals = NDArray[np.floating[Any]] | float
Integers = NDArray[np.integer[Any]] | list[int] | int
Up = Literal["north"] | float
Interpolation = Literal["bilinear", "peak"]


class Ppi:
    """The newest sample of every cell: spokes in, a polar array (azimuths, bins) out.

    polar: the samples, zero where nothing came yet. number (azimuths,): sequence number of each row's spoke, -1 where none.
    """

    def __init__(
        self, azimuths: int, bins: int, range_first: float, range_step: float, dtype: np.dtype[Any] | type = np.uint8
    ) -> None:
        if azimuths < 1 or bins < 1:
            raise ValueError(f"a picture of {azimuths} azimuths x {bins} bins is empty: both are at least 1")
        if not range_step > 0:
            raise ValueError(f"range_step: {range_step} m; it is above 0")
        self.range_first, self.range_step = range_first, range_step
        self.polar: NDArray[Any] = np.zeros((azimuths, bins), dtype=dtype)
        self.number = np.full(azimuths, -1, dtype=np.int64)

    @property
    def filled(self) -> NDArray[np.bool_]:
        """Which rows (azimuths,) hold a spoke."""
        return self.number >= 0

    @property
    def age(self) -> NDArray[np.int64]:
        """How many spokes ago each row (azimuths,) was written; -1 where it never was."""
        return np.where(self.filled, self.number.max() - self.number, -1)

    @property
    def range_end(self) -> float:
        """Far edge of the last cell [m]."""
        return float(self.range_first + (self.polar.shape[1] - 0.5) * self.range_step)

    def add(self, index: Integers, samples: NDArray[Any], number: Integers) -> NDArray[np.bool_]:
        """Put spokes into their rows and say which (K,) were news.

        index (K,): row of each; samples (K, bins); number (K,): sequence numbers. A spoke no newer than the one already in
        its row is left out, so that repeats and late comers harm nothing. Raises ValueError where shapes or rows do not fit.
        """
        rows, numbers = np.atleast_1d(np.asarray(index, np.int64)), np.atleast_1d(np.asarray(number, np.int64))
        azimuths, bins = self.polar.shape
        if samples.shape != (len(rows), bins) or numbers.shape != rows.shape:
            raise ValueError(f"samples: {samples.shape} for {len(rows)} spokes of {bins} bins and {len(numbers)} numbers")
        if len(rows) and not 0 <= rows.min() <= rows.max() < azimuths:
            raise ValueError(f"index: {rows.min()} to {rows.max()}; this picture has rows 0 to {azimuths - 1}")
        news = np.zeros(len(rows), dtype=np.bool_)
        for k in range(len(rows)):
            if numbers[k] > self.number[rows[k]]:
                self.polar[rows[k]], self.number[rows[k]], news[k] = samples[k], numbers[k], True
        return news


class _Geometry(NamedTuple):
    """What the index maps of a scan conversion depend on."""

    azimuths: int
    bins: int
    range_first: float
    range_step: float
    size: int
    range_max: float
    top: float  # rad, bearing at the top
    reach: float  # m, nothing is seen beyond

    @property
    def pixel(self) -> float:
        """Side of a pixel [m]."""
        return 2.0 * self.range_max / self.size


def scan_convert(
    polar: NDArray[Any],
    range_first: float,
    range_step: float,
    size: int,
    range_max: float,
    up: Up = "north",
    interpolation: Interpolation = "bilinear",
) -> NDArray[np.float32]:
    """The (size, size) image of a polar array (A, N) of finite numbers (seed eqs. 21, 22: x = R sin phi, y = R cos phi).

    `bilinear` weighs the two samples and two azimuths about the pixel's centre; azimuth wraps, and within half a cell of
    the first or last sample range does not interpolate but holds. `peak` is for pixels larger than cells, where bilinear
    misses targets: the strongest of all cells whose centres lie in the pixel, and of what bilinear makes of ranges thinned
    to about a pixel each by keeping the strongest. A pixel is 0 where its centre is nearer than the first cell, beyond the
    last or beyond range_max [m] (and it holds no cell). The index maps of the last few geometries are kept, so that only
    the first call is slow. Raises ValueError for complex or empty arrays, and where a size is not above 0.
    """
    if polar.ndim != 2 or polar.size == 0 or np.iscomplexobj(polar):
        raise ValueError(f"polar: shape {polar.shape} of {polar.dtype}; a real, non-empty array (azimuths, bins) is wanted")
    if size < 1 or not range_max > 0 or not range_step > 0:
        raise ValueError(f"size {size}, range_max {range_max} m, range_step {range_step} m: all are above 0")
    top = 0.0 if isinstance(up, str) else float(up)
    first, step, far = float(range_first), float(range_step), float(range_max)
    reach = min(far, first + (polar.shape[1] - 0.5) * step)
    geometry = _Geometry(polar.shape[0], polar.shape[1], first, step, int(size), far, top, reach)
    return _CONVERSIONS[interpolation](polar, geometry)


def image_place(distance: Reals, azimuth: Reals, size: int, range_max: float, up: Up = "north") -> tuple[Floats, Floats]:
    """Row and column, in pixels with whole numbers at pixel centres, of a range [m] and azimuth [rad] (seed eqs. 21, 22)."""
    angle = np.asarray(azimuth, np.float64) - (0.0 if isinstance(up, str) else up)
    pixels = np.asarray(distance, np.float64) * (size / (2.0 * range_max))
    middle = (size - 1) / 2.0
    return middle - pixels * np.cos(angle), middle + pixels * np.sin(angle)


def _bilinear(polar: NDArray[Any], geometry: _Geometry) -> NDArray[np.float32]:
    image: NDArray[np.float32] = _weights(geometry) @ polar.astype(np.float32, copy=False).ravel()
    return image.reshape(geometry.size, geometry.size)


def _peak(polar: NDArray[Any], geometry: _Geometry) -> NDArray[np.float32]:
    group = max(1, int(geometry.pixel / geometry.range_step))
    thin, thinned = _thin(polar, geometry, group)
    image = _bilinear(thin, thinned).ravel()
    cells, starts, pixels = _cells_by_pixel(geometry)
    if len(pixels):
        strongest = np.maximum.reduceat(polar.ravel()[cells], starts)
        image[pixels] = np.maximum(image[pixels], strongest)
    return image.reshape(geometry.size, geometry.size)


_CONVERSIONS = {"bilinear": _bilinear, "peak": _peak}


def _thin(polar: NDArray[Any], geometry: _Geometry, group: int) -> tuple[NDArray[Any], _Geometry]:
    """The strongest of each `group` of samples, and the geometry of what is left."""
    if group == 1:
        return polar, geometry
    starts = np.arange(0, geometry.bins, group)
    middle = geometry.range_first + (group - 1) / 2.0 * geometry.range_step
    thin: NDArray[Any] = np.maximum.reduceat(polar, starts, axis=1)
    return thin, geometry._replace(bins=len(starts), range_first=middle, range_step=group * geometry.range_step)


@lru_cache(maxsize=4)
def _weights(geometry: _Geometry) -> "csr_array[np.float32]":
    """The sparse matrix (size^2, azimuths x bins) image_from_polar of bilinear interpolation."""
    azimuths, bins, first, step, size, _, top, reach = geometry
    offset = (np.arange(size) + 0.5 - size / 2.0) * geometry.pixel
    x, y = offset[None, :], 0.0 - offset[:, None]  # so that the middle is +0, whose bearing is 0
    distance, azimuth = np.hypot(x, y).ravel(), (np.arctan2(x, y).ravel() + top) % (2.0 * np.pi)
    seen = (distance >= first - step / 2.0) & (distance <= reach)
    n = np.clip((distance[seen] - first) / step, 0.0, bins - 1.0)
    k = azimuth[seen] * (azimuths / (2.0 * np.pi))
    n0, k0 = n.astype(np.int64), k.astype(np.int64)
    n1, k1 = np.minimum(n0 + 1, bins - 1), (k0 + 1) % azimuths
    k0 %= azimuths  # an azimuth that rounds up to a whole turn
    dn, dk = n - n0, k - np.floor(k)
    cells = np.stack([k0 * bins + n0, k0 * bins + n1, k1 * bins + n0, k1 * bins + n1], axis=1)
    shares = np.stack([(1 - dk) * (1 - dn), (1 - dk) * dn, dk * (1 - dn), dk * dn], axis=1)
    ends = np.concatenate([[0], np.cumsum(4 * seen)])
    index = np.int32 if azimuths * bins < 2**31 and ends[-1] < 2**31 else np.int64
    return csr_array(
        (shares.ravel().astype(np.float32), cells.ravel().astype(index), ends.astype(index)),
        shape=(size * size, azimuths * bins),
    )


@lru_cache(maxsize=4)
def _cells_by_pixel(geometry: _Geometry) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Cells (flat) sorted by the pixel that holds their centre, where each pixel's share begins, and those pixels (flat)."""
    azimuths, bins, first, step, size, range_max, top, _ = geometry
    distance = first + step * np.arange(bins, dtype=np.float64)
    near = np.flatnonzero((distance >= 0) & (distance <= range_max))
    azimuth = (2.0 * np.pi / azimuths) * np.arange(azimuths, dtype=np.float64)[:, None]
    rows, columns = (np.rint(p).astype(np.int64) for p in image_place(distance[near], azimuth, size, range_max, top))
    inside = (rows >= 0) & (rows < size) & (columns >= 0) & (columns < size)  # the rim itself may round outward
    cells = (np.arange(azimuths)[:, None] * bins + near)[inside]
    pixel = (rows * size + columns)[inside]
    order = np.argsort(pixel, kind="stable")
    pixels, starts = np.unique(pixel[order], return_index=True)
    return cells[order], starts, pixels
