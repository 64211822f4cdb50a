"""The field of each source at rest by itself: computed once, as it is the same in every scan."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from radar_service.echo.echoes import Echoes
from radar_service.engine.preparation import MAX_TILE, Prepared, beam_rows, column
from radar_service.numerics.types import Indices, Profiles
from radar_service.receive.detection import square_law


class RestingField(NamedTuple):
    """The field of one source at rest. rows: azimuths (R,) of a scan, rising; field: (R, bins) [sqrt(W)]."""

    rows: Indices
    field: Profiles

    def add_to(self, profiles: Profiles, start: int) -> None:
        """Adds it to profiles (K, bins) [sqrt(W)] of the azimuths from `start` on."""
        first, stop = np.searchsorted(self.rows, [start, start + len(profiles)])
        profiles[self.rows[first:stop] - start] += self.field[first:stop]


def resting_numbers(prepared: Prepared, numbers: Indices) -> Indices:
    """The source number (E,) of each echo at rest; numbers: as `source_numbers`."""
    return numbers[prepared.resting.scene_body]


def resting_fields(prepared: Prepared, numbers: Indices, floor: float) -> Iterator[tuple[int, RestingField]]:
    """Number and field of each source at rest; rows whose power stays below `floor` [W] are left out."""
    each = resting_numbers(prepared, numbers)
    for number in np.unique(each).tolist():
        yield number, resting_field(prepared, np.flatnonzero(each == number), floor)


def resting_field(prepared: Prepared, which: Indices, floor: float) -> RestingField:
    """The field of echoes at rest, indices `which` (N,); rows whose power stays below `floor` [W] are left out."""
    every, compression, radar = prepared.resting.echoes, prepared.compression, prepared.scene.radar
    echoes = Echoes(every.range[which], every.azimuth[which], every.amplitude[which])
    first, count = _window(prepared, echoes)
    filtered = beam_rows(prepared.scene, prepared.fidelity, echoes, compression, first, count)
    energy = np.einsum("ij,ij->i", filtered, filtered.conj()).real
    rows = np.flatnonzero(energy * compression.peak_gain**2 > floor)
    field = np.empty((len(rows), radar.bins), dtype=np.complex64)
    for start in range(0, len(rows), MAX_TILE):
        part = rows[start : start + MAX_TILE]
        gridded = np.zeros((len(part), compression.size), dtype=np.complex64)
        gridded[:, first : first + count] = filtered[part]
        field[start : start + MAX_TILE] = compression.profiles(gridded)
    above = square_law(field).max(axis=1, initial=0.0) > floor
    return RestingField(rows[above], field[above])


def _window(prepared: Prepared, echoes: Echoes) -> tuple[int, int]:
    """First and number of the grid columns that the echoes' kernels cover; all of them where kernels wrap or may be clipped."""
    compression, radar = prepared.compression, prepared.scene.radar
    position = column(echoes.range, radar.range_step)
    first = int(np.floor(position.min(initial=0.0 if not len(position) else np.inf))) - compression.kernel.width
    stop = int(np.ceil(position.max(initial=0.0))) + compression.kernel.width + 1
    if radar.eclipsing or first < 0 or stop > compression.size:
        return 0, compression.size
    return first, stop - first
