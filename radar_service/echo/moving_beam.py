"""The beam's weight on moving echoes: table of the azimuth gain, and the fields of echoes with the phase of their range."""

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Complexes, Floats, Gain, Profiles, Singles

GAINS_PER_BEAMWIDTH = 4096  # table entries: the nearest one errs by -74.8 dB of boresight at most
MAX_ENTRIES = 2**22


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
