"""A Gaussian field on the map, read along lines: one periodic tile that all times share, each at another offset."""

import numpy as np
import scipy.fft

from radar_service.clutter.texture_law import TextureLaw
from radar_service.numerics.random import TEXTURE, generator, normals
from radar_service.numerics.types import Floats, Indices, Singles

SIZE = 1024  # grid points a side, a power of 2; 256 lengths, so 3 km along the wind in sea state 3
PER_LENGTH = 4  # grid points in a 1/e length: the nearest one lengthens the correlation by 1 %
TILT = 0.5 * (np.sqrt(5.0) - 1.0)  # rad between grid and wind, so that no main direction repeats within a few km
# Offset of the next field, of the tile's side: the two-dimensional golden ratio, so that no two fields of a run coincide.
OFFSET = np.array([0.7548776662466927, 0.5698402909980532])
_DRAW = 0  # key after TEXTURE; independent rows use 1 and up


class TextureTile:
    """Periodic Gaussian field of unit power with the correlation of a law; field k is the tile at its own offset."""

    def __init__(self, law: TextureLaw, seed: int) -> None:
        along = np.array([np.sin(law.wind_from), np.cos(law.wind_from)]) / law.along
        across = np.array([np.cos(law.wind_from), -np.sin(law.wind_from)]) / law.across
        turn = np.array([[np.cos(TILT), -np.sin(TILT)], [np.sin(TILT), np.cos(TILT)]])
        self._grid_from_map = PER_LENGTH * turn @ np.stack([along, across])  # (2, 2), grid steps per metre
        self._field = _periodic_field(seed).ravel()

    def along_lines(self, field: Indices, start: Floats, outward: Floats, distance: Floats) -> Singles:
        """Values (J, N) at `distance` (N,) [m] along lines.

        field: (J,) number; start: (J, 2) in the field's frame east, north [m]; outward: (J, 2) unit vectors.
        """
        begin = start @ self._grid_from_map.T + field[:, None] * OFFSET * SIZE
        slope = (outward @ self._grid_from_map.T).astype(np.float32)
        room = SIZE * np.ceil(
            np.abs(slope).max() * np.abs(distance).max(initial=0.0) / SIZE
        )  # whole tiles: no number below 0
        first = (begin % SIZE + room).astype(np.float32)
        index = self._grid_index(first[:, 0], slope[:, 0], distance)
        index *= SIZE
        index += self._grid_index(first[:, 1], slope[:, 1], distance)
        return self._field.take(index, mode="clip")

    def _grid_index(self, first: Singles, slope: Singles, distance: Floats) -> Indices:
        place = slope[:, None] * distance.astype(np.float32)
        place += first[:, None]
        index = place.astype(np.int64)
        index &= SIZE - 1
        return index


def _periodic_field(seed: int) -> Singles:
    """Gaussian field (SIZE, SIZE) of unit power, correlation exp(-r^2) at r lengths."""
    white = normals(generator(seed, TEXTURE, _DRAW), SIZE, SIZE)
    frequency = np.fft.fftfreq(SIZE) * PER_LENGTH  # per length
    amplitude = np.exp(-0.5 * (np.pi * frequency) ** 2).astype(np.float32)
    amplitude /= np.float32(np.mean(amplitude.astype(np.float64) ** 2) ** 0.5)
    spectrum = scipy.fft.rfft2(white)
    spectrum *= amplitude[:, None]
    spectrum *= amplitude[: spectrum.shape[1]]
    return np.asarray(scipy.fft.irfft2(spectrum, overwrite_x=True), dtype=np.float32)
