"""An antenna's aperture, and its pattern past what stands before it: a mast takes from the field, as effects say.

The pattern is that of a line source by a table, less what each change takes from it.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from radar_service.numerics import Complexes, Flags, Floats, wrap_angle
from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.patterns import line_source, sinc_sum

ENTRIES_PER_NULL = 1024  # in lambda / D of the table of the pattern: linear interpolation errs by (pi / 1024)^2 / 8, -118 dB
MAX_ENTRIES = 2**22
MAX_OFFSET = 0.5  # rad; beyond, sidelobes are as without changes
FAINTEST = 1e-6  # of a one-way field: losses are 240 dB at most
CLUTTER_STEPS = 4  # of boresight, in a beamwidth
CLUTTER_EXTENT = 4.0  # beamwidths each side that receive clutter


class Aperture(NamedTuple):
    """An aperture of a length [m], lit at x by the sum of weights (N,) times exp(-2 pi j positions (N,) x / length)."""

    length: float
    positions: tuple[float, ...]
    weights: tuple[float, ...]

    def pattern(self, cycles: Floats) -> Floats:
        """The field far off (any shape), 1 on boresight; cycles: of the phase along the aperture, D sin(offset) / lambda."""
        return sinc_sum(cycles, self.positions, self.weights)

    def illumination(self, along: Floats) -> Floats:
        """The field at places (N,) from its middle [m], with an average of 1 for a pattern of 1 on boresight."""
        phase = -2.0 * np.pi * np.outer(along / self.length, self.positions)
        return np.asarray(np.cos(phase) @ np.array(self.weights))


def aperture_of(pattern: AntennaPattern, beamwidth: float, wavelength: float) -> Aperture | None:
    """The aperture of a horizontal pattern with a one-way half-power width [rad]; None for a pattern that is no line source."""
    source = line_source(pattern)
    if source is None:
        return None
    return Aperture(2.0 * source.half_power * wavelength / beamwidth, source.positions, source.weights)


class FieldChange(Protocol):
    """What an effect takes from the one-way field of an antenna. Implementations are safe to call from several threads.

    extent: offset from boresight [rad] up to which it does, MAX_OFFSET at most.
    """

    extent: float

    def subtract(self, field: Complexes, from_bow: Floats, offset: Floats) -> None:
        """Subtracts it from a field (any shape), in place; from_bow, offset: of that shape, directions from the bow and from
        boresight [rad]."""

    def reaches(self, from_bow: Floats) -> Flags:
        """To which directions (E,) from the bow [rad] it changes the field."""


class ChangedPattern:
    """The one-way field of an antenna past what stands before it. Safe to call from several threads."""

    def __init__(self, aperture: Aperture, wavelength: float, changes: Sequence[FieldChange]) -> None:
        self._aperture, self._cycles = aperture, aperture.length / wavelength
        per_radian = min(ENTRIES_PER_NULL * self._cycles, MAX_ENTRIES / np.pi)
        offset = np.arange(int(np.pi * per_radian) + 2) / per_radian
        self._pattern, self._per_radian = aperture.pattern(self._cycles * offset), per_radian
        self._changes = changes

    def one_way(self, from_bow: Floats, offset: Floats) -> Complexes:
        """Field to a target far off, over that on boresight without changes; its square is the two-way field.

        from_bow: direction of the target, clockwise from the bow [rad]; offset: of that shape, from boresight to it [rad].
        """
        offset = wrap_angle(offset)
        return self._past(self._without(offset), from_bow, offset)

    def two_way_change(self, from_bow: Floats, offset: Floats) -> Complexes:
        """What changes of the two-way field, for targets at `from_bow` from the bow and `offset` from boresight [rad]."""
        offset = wrap_angle(offset)
        without = self._without(offset)
        return self._past(without, from_bow, offset) ** 2 - without**2

    def _without(self, offset: Floats) -> Floats:
        """The one-way field without changes at offsets that are wrapped, by linear interpolation in a table."""
        entry = np.abs(offset) * self._per_radian
        below = entry.astype(np.intp)
        lower = self._pattern.take(below, mode="clip")
        return np.asarray(lower + (entry - below) * (self._pattern.take(below + 1, mode="clip") - lower))

    def _past(self, without: Floats, from_bow: Floats, offset: Floats) -> Complexes:
        """The one-way field at offsets that are wrapped, by that without changes."""
        field = without.astype(np.complex128)
        for change in self._changes:
            change.subtract(field, np.broadcast_to(from_bow, offset.shape), offset)
        return field

    def reaches(self, from_bow: Floats) -> Flags:
        """To which directions (E,) from the bow [rad] the field changes."""
        return np.asarray(np.any([change.reaches(from_bow) for change in self._changes], axis=0))

    @property
    def extent(self) -> float:
        """Offset from boresight [rad] up to which it changes."""
        return max(change.extent for change in self._changes)

    def loss_db(self, from_bow: float) -> float:
        """Two-way loss [dB] on boresight to a target at a direction from the bow [rad]."""
        field = abs(self.one_way(np.array([from_bow]), np.zeros(1))[0])
        return float(-40.0 * math.log10(max(field, FAINTEST)))

    def clutter_power(self, boresight: Floats) -> Floats:
        """Two-way power of what lies all round, at boresights clockwise from the bow (any shape) [rad], over that without
        changes."""
        angle, power = self._clutter
        return np.interp(boresight % (2.0 * np.pi), angle, power)

    @cached_property
    def _clutter(self) -> tuple[Floats, Floats]:
        beamwidth = 1.0 / self._cycles
        angle = np.linspace(0.0, 2.0 * np.pi, int(np.ceil(2.0 * np.pi / beamwidth * CLUTTER_STEPS)) + 1)
        offset = np.linspace(-CLUTTER_EXTENT * beamwidth, CLUTTER_EXTENT * beamwidth, 16 * int(CLUTTER_EXTENT) + 1)
        field = self.one_way(angle[:, None] + offset, np.broadcast_to(offset, (len(angle), len(offset))))
        without = self._aperture.pattern(self._cycles * offset)
        return angle, (np.abs(field) ** 4).sum(axis=1) / (without**4).sum()
