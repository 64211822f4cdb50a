"""The PPI: spokes accumulated by azimuth, and scan conversion from (range, azimuth) to (x, y). `picture` draws it.

An image of `size` pixels covers the square of half-width `range_max` around own ship. Row 0 is the top, and `up` is the bearing
at the top: "north", or a heading [rad]. Polar arrays are (azimuths, bins). Row k has the boresight k x 2 pi/azimuths. Sample n
has the range range_first + n x range_step, in the middle of its cell.
"""

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Flags, Floats, Indices, Singles

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Reals = NDArray[np.floating[Any]] | float
Integers = NDArray[np.integer[Any]] | list[int] | int
Up = Literal["north"] | float
Interpolation = Literal["bilinear", "peak"]


class Ppi:
    """The newest sample of every cell, from spokes.

    polar: (azimuths, bins) the samples, zero before the first spoke.
    number: (azimuths,) sequence number of each row's spoke, -1 where there is none.
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
    def filled(self) -> Flags:
        """Which rows (azimuths,) have a spoke."""
        return self.number >= 0

    @property
    def age(self) -> Indices:
        """How many spokes ago each row (azimuths,) was updated; -1 where it never was."""
        return np.where(self.filled, self.number.max() - self.number, -1)

    @property
    def range_end(self) -> float:
        """Far edge of the last cell [m]."""
        return float(self.range_first + (self.polar.shape[1] - 0.5) * self.range_step)

    def add(self, index: Integers, samples: NDArray[Any], number: Integers) -> Flags:
        """Puts spokes into their rows and returns which of them (K,) were new.

        index (K,): row of each; samples (K, bins); number (K,): sequence numbers. A spoke that is not newer than that of its
        row is ignored, so that repeated and late spokes change nothing. Raises ValueError where shapes or rows do not fit.
        """
        rows, numbers = np.atleast_1d(np.asarray(index, np.int64)), np.atleast_1d(np.asarray(number, np.int64))
        azimuths, bins = self.polar.shape
        if samples.shape != (len(rows), bins) or numbers.shape != rows.shape:
            raise ValueError(f"samples: {samples.shape} for {len(rows)} spokes of {bins} bins and {len(numbers)} numbers")
        if len(rows) and not 0 <= rows.min() <= rows.max() < azimuths:
            raise ValueError(f"index: {rows.min()} to {rows.max()}; this picture has rows 0 to {azimuths - 1}")
        new = np.zeros(len(rows), dtype=np.bool_)
        for k in range(len(rows)):
            if numbers[k] > self.number[rows[k]]:
                self.polar[rows[k]], self.number[rows[k]], new[k] = samples[k], numbers[k], True
        return new


class _Geometry(NamedTuple):
    """What the index maps of a scan conversion depend on.

    azimuths, bins: of the polar array.
    range_first: of sample 0 [m].
    range_step: between samples [m].
    size: of the image [pixels].
    range_max: half-width of the image [m].
    top: bearing at the top [rad].
    data_end: pixels beyond this range are 0 [m].
    """

    azimuths: int
    bins: int
    range_first: float
    range_step: float
    size: int
    range_max: float
    top: float
    data_end: float

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
) -> Singles:
    """The (size, size) image of a polar array (A, N) of finite numbers (docs/specification.md eqs. 21, 22: x = R sin phi, y
    = R cos phi).

    `bilinear` interpolates between two samples and two azimuths around the pixel's centre. Azimuth wraps. Within half a cell
    of the first or last sample the range is not interpolated.
    `peak` is for pixels larger than cells, where bilinear misses targets. It takes the maximum of all cells whose centres lie
    in the pixel, and of a bilinear image of maxima over about a pixel of range.
    A pixel without a cell is 0 where its centre is nearer than the first cell, or beyond the last cell or range_max [m].
    Raises ValueError for complex or empty arrays, and where a size is not above 0.
    """
    if polar.ndim != 2 or polar.size == 0 or np.iscomplexobj(polar):
        raise ValueError(f"polar: shape {polar.shape} of {polar.dtype}; a real, non-empty array (azimuths, bins) is needed")
    if size < 1 or not range_max > 0 or not range_step > 0:
        raise ValueError(f"size {size}, range_max {range_max} m, range_step {range_step} m: all are above 0")
    top = 0.0 if isinstance(up, str) else float(up)
    first, step, half_width = float(range_first), float(range_step), float(range_max)
    data_end = min(half_width, first + (polar.shape[1] - 0.5) * step)
    geometry = _Geometry(polar.shape[0], polar.shape[1], first, step, int(size), half_width, top, data_end)
    return _CONVERSIONS[interpolation](polar, geometry)


def image_position(distance: Reals, azimuth: Reals, size: int, range_max: float, up: Up = "north") -> tuple[Floats, Floats]:
    """Row and column, in pixels with whole numbers at pixel centres, of a range [m] and azimuth [rad]
    (docs/specification.md eqs. 21, 22)."""
    angle = np.asarray(azimuth, np.float64) - (0.0 if isinstance(up, str) else up)
    pixels = np.asarray(distance, np.float64) * (size / (2.0 * range_max))
    middle = (size - 1) / 2.0
    return middle - pixels * np.cos(angle), middle + pixels * np.sin(angle)


def _bilinear(polar: NDArray[Any], geometry: _Geometry) -> Singles:
    image: Singles = _weights(geometry) @ polar.astype(np.float32, copy=False).ravel()
    return image.reshape(geometry.size, geometry.size)


def _peak(polar: NDArray[Any], geometry: _Geometry) -> Singles:
    group = max(1, int(geometry.pixel / geometry.range_step))
    reduced, reduced_geometry = _group_maxima(polar, geometry, group)
    image = _bilinear(reduced, reduced_geometry).ravel()
    cells, starts, pixels = _cells_by_pixel(geometry)
    if len(pixels):
        strongest = np.maximum.reduceat(polar.ravel()[cells], starts)
        image[pixels] = np.maximum(image[pixels], strongest)
    return image.reshape(geometry.size, geometry.size)


_CONVERSIONS = {"bilinear": _bilinear, "peak": _peak}


def _group_maxima(polar: NDArray[Any], geometry: _Geometry, group: int) -> tuple[NDArray[Any], _Geometry]:
    """The maximum of each `group` of samples, and the geometry of these maxima."""
    if group == 1:
        return polar, geometry
    starts = np.arange(0, geometry.bins, group)
    middle = geometry.range_first + (group - 1) / 2.0 * geometry.range_step
    maxima: NDArray[Any] = np.maximum.reduceat(polar, starts, axis=1)
    return maxima, geometry._replace(bins=len(starts), range_first=middle, range_step=group * geometry.range_step)


@lru_cache(maxsize=4)
def _weights(geometry: _Geometry) -> "csr_array[np.float32]":
    """The sparse matrix (size^2, azimuths x bins) image_from_polar of bilinear interpolation."""
    from scipy.sparse import csr_array  # here: scans without a picture have no use for it

    azimuths, bins, first, step, size, _, top, data_end = geometry
    offset = (np.arange(size) + 0.5 - size / 2.0) * geometry.pixel
    x, y = offset[None, :], 0.0 - offset[:, None]  # so that the middle is +0, whose bearing is 0
    distance, azimuth = np.hypot(x, y).ravel(), (np.arctan2(x, y).ravel() + top) % (2.0 * np.pi)
    inside = (distance >= first - step / 2.0) & (distance <= data_end)
    n = np.clip((distance[inside] - first) / step, 0.0, bins - 1.0)
    k = azimuth[inside] * (azimuths / (2.0 * np.pi))
    n0, k0 = n.astype(np.int64), k.astype(np.int64)
    n1, k1 = np.minimum(n0 + 1, bins - 1), (k0 + 1) % azimuths
    k0 %= azimuths  # an azimuth that rounds up to a full circle
    dn, dk = n - n0, k - np.floor(k)
    cells = np.stack([k0 * bins + n0, k0 * bins + n1, k1 * bins + n0, k1 * bins + n1], axis=1)
    shares = np.stack([(1 - dk) * (1 - dn), (1 - dk) * dn, dk * (1 - dn), dk * dn], axis=1)
    ends = np.concatenate([[0], np.cumsum(4 * inside)])
    index = np.int32 if azimuths * bins < 2**31 and ends[-1] < 2**31 else np.int64
    return csr_array(
        (shares.ravel().astype(np.float32), cells.ravel().astype(index), ends.astype(index)),
        shape=(size * size, azimuths * bins),
    )


@lru_cache(maxsize=4)
def _cells_by_pixel(geometry: _Geometry) -> tuple[Indices, Indices, Indices]:
    """Cells (flat) sorted by the pixel of their centre, the first cell of each pixel, and the pixels (flat)."""
    azimuths, bins, first, step, size, range_max, top, _ = geometry
    distance = first + step * np.arange(bins, dtype=np.float64)
    near = np.flatnonzero((distance >= 0) & (distance <= range_max))
    azimuth = (2.0 * np.pi / azimuths) * np.arange(azimuths, dtype=np.float64)[:, None]
    rows, columns = (np.rint(p).astype(np.int64) for p in image_position(distance[near], azimuth, size, range_max, top))
    inside = (rows >= 0) & (rows < size) & (columns >= 0) & (columns < size)  # cells on the rim may round outward
    cells = (np.arange(azimuths)[:, None] * bins + near)[inside]
    pixel = (rows * size + columns)[inside]
    order = np.argsort(pixel, kind="stable")
    pixels, starts = np.unique(pixel[order], return_index=True)
    return cells[order], starts, pixels
