"""The records that the stages of echoes hand over, and the weight of the beam on those that move."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Complexes, Floats, Gain, Indices, Profiles, Singles, wrap_angle

SECOND_TIME = -1  # in place of a body's index: the echo is one of an earlier pulse
GAINS_PER_BEAMWIDTH = 4096  # table entries: the nearest one errs by -74.8 dB of boresight at most
MAX_ENTRIES = 2**22


@dataclass(frozen=True)
class Echoes:
    """Echoes (E,) on boresight: range (E,) [m], azimuth (E,) [rad], amplitude (E,) [sqrt(W)]."""

    range: Floats
    azimuth: Floats
    amplitude: Complexes

    def __post_init__(self) -> None:
        assert self.range.shape == self.azimuth.shape == self.amplitude.shape


@dataclass(frozen=True)
class AzimuthTimes:
    """Consecutive azimuths (K,): number since the start, boresight [rad], time [s]."""

    number: Indices
    boresight: Floats
    time: Floats

    def part(self, start: int, stop: int) -> "AzimuthTimes":
        """Azimuths start to stop (exclusive)."""
        return AzimuthTimes(self.number[start:stop], self.boresight[start:stop], self.time[start:stop])

    @property
    def middle(self) -> float:
        """Time of the middle azimuth [s]."""
        return float(self.time[len(self.time) // 2])


class BeamWeightedEchoes(NamedTuple):
    """Echoes (E,) over K consecutive azimuths, weighted by the beam.

    range: (E,) at the middle azimuth [m].
    range_migration: (E, K) change of range since the middle [m].
    amplitude: (E, K) [sqrt(W)].
    body: (E,) index of the body in the scene; SECOND_TIME for echoes of an earlier pulse; of effects see `Context.echo_sources`.
    """

    range: Floats
    range_migration: Singles
    amplitude: Profiles
    body: Indices

    def chosen(self, which: Indices) -> "BeamWeightedEchoes":
        """The echoes `which` (N,)."""
        return BeamWeightedEchoes(
            self.range[which],
            self.range_migration.take(which, axis=0),
            self.amplitude.take(which, axis=0),
            self.body[which],
        )


def concatenated(parts: Sequence[BeamWeightedEchoes], azimuths: int) -> BeamWeightedEchoes:
    """Echoes of several parts over the same azimuths as one record."""
    if len(parts) == 1:
        return parts[0]
    each = np.zeros((0, azimuths))
    none = BeamWeightedEchoes(np.zeros(0), each.astype(np.float32), each.astype(np.complex64), np.zeros(0, np.int64))
    return BeamWeightedEchoes(*(np.concatenate(column) for column in zip(none, *parts, strict=True)))


class BeamTable:
    """Azimuth gains relative to boresight, even in the offset, by table look-up."""

    def __init__(self, gain: Gain, beamwidth: float, extent: float, span: float, oversampling: int = 1) -> None:
        """gain: at an offset from boresight [rad]; extent: offset beyond which echoes are left out [rad]; span: of the
        boresights computed together [rad]; oversampling: times GAINS_PER_BEAMWIDTH entries."""
        self.extent, self.span = extent, span
        reach = extent + 2.0 * span  # an echo within reach of the first boresight is farther from the last
        per_radian = min(oversampling * GAINS_PER_BEAMWIDTH / beamwidth, MAX_ENTRIES / reach)
        offset = wrap_angle(np.arange(int(reach * per_radian) + 2) / per_radian)
        self._gain, self._per_radian = gain(offset).astype(np.float32), np.float32(per_radian)

    def __call__(self, offset: Singles) -> Singles:
        """Gain at offsets from boresight, any shape [rad]; beyond the table's reach it is that at its end."""
        entry = np.abs(offset)
        entry *= self._per_radian
        entry += np.float32(0.5)
        gain: Singles = self._gain.take(entry.astype(np.intp), mode="clip")
        return gain

    def weights(
        self, boresight: Singles, azimuth: Singles, azimuth_change: Singles, nearness: Singles, range_migration: Singles
    ) -> Singles:
        """Beam weights (E, K) with the change of range loss since the middle.

        boresight: (K,) since the middle; azimuth: (E,) by which the middle boresight is beyond the echoes, and azimuth_change:
        (E, K) of these since then [rad]; nearness: (E,) 1 / range [1/m]; range_migration: (E, K) change of range [m].
        """
        weight = np.empty(azimuth_change.shape, dtype=np.float32)
        taken = boresight, azimuth_change, azimuth, range_migration, nearness, self._gain
        sizes = (*weight.shape, len(self._gain), float(self._per_radian))
        KERNELS.beam_weights(*sizes, *map(np.ascontiguousarray, taken), weight)
        return weight


def received_field(
    middle: Complexes, distance: Floats, weight: Singles, range_migration: Singles, wavelength: float
) -> Profiles:
    """Fields (E, K) of amplitudes (E,) weighted (E, K), with the phase of their way there and back.

    distance: ranges (E,) at the middle azimuth [m]; range_migration: (E, K) change since [m].
    """
    turns = distance * (2.0 / wavelength)
    turns -= np.rint(turns)  # in float64: a range has some 1e5 turns
    phase = range_migration * np.float32(-4.0 * np.pi / wavelength)  # some 100 rad: float32 leaves 1e-5 of a radian
    phase -= (2.0 * np.pi * turns).astype(np.float32)[:, None]
    amplitude = np.empty(phase.shape, dtype=np.complex64)
    np.multiply(np.cos(phase), weight, out=amplitude.real)
    np.multiply(np.sin(phase), weight, out=amplitude.imag)
    amplitude *= middle.astype(np.complex64)[:, None]
    return amplitude
