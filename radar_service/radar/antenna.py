"""Antenna patterns, their gain by a fast table, and the azimuth sampling that they need.

An echo's amplitude is proportional to the one-way power gain, its power to the square of it
(docs/specification.md, errata row 2).
"""

from abc import ABC, abstractmethod
from functools import lru_cache

import numpy as np

from radar_service.numerics import Floats

MIN_TABLE_STEPS = 2**17  # over half a circle


class AntennaPattern(ABC):
    """The shape of a beam in one of the two principal planes. A concrete pattern is immutable and hashable.

    A pattern without a name, a gain or an aperture width cannot be made: Python raises TypeError.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the pattern in scene files."""

    @property
    @abstractmethod
    def aperture_width(self) -> float:
        """Length of the aperture over that of a uniform one of the same half-power width, at least 1 for a line source.

        It bounds the spatial frequencies of the gain, and so the azimuth sampling of a scan.
        """

    @abstractmethod
    def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
        """One-way power gain relative to boresight, 1 at offset 0.

        offset: any shape, from boresight, wrapped to +-pi by the caller [rad]; beamwidth: one-way half-power width [rad].
        """

    @property
    def description(self) -> str:
        """The pattern in a few words, for the plan."""
        return self.name

    def half_power_width(self, beamwidth: float) -> float:
        """One-way half-power width [rad] where a scene file states `beamwidth` [rad]; most patterns follow it."""
        return beamwidth

    def aperture_beamwidth(self, beamwidth: float) -> float:
        """Half-power width [rad] of a uniform aperture as long as this antenna's, 0.8859 lambda / a."""
        return self.half_power_width(beamwidth) / self.aperture_width


def interpolated_gain(offset: Floats, beamwidth: float, pattern: AntennaPattern) -> Floats:
    """The pattern's gain by linear interpolation in a table, several times faster.

    offset: any shape, from boresight [rad]. The error is at most 3e-6 (h^2 / 8 of the second derivative).
    """
    gain, rise = _gain_table(beamwidth, pattern)
    position = np.abs(offset)
    position *= (len(gain) - 1) / np.pi
    entry = position.astype(np.intp)
    position -= entry
    position *= rise.take(entry, mode="clip")
    position += gain.take(entry, mode="clip")
    return position


@lru_cache(maxsize=8)
def _gain_table(beamwidth: float, pattern: AntennaPattern) -> tuple[Floats, Floats]:
    """Gains at offsets from 0 to pi, at least 500 per beamwidth of a uniform aperture, and their differences."""
    steps = max(MIN_TABLE_STEPS, int(np.ceil(500.0 * np.pi / pattern.aperture_beamwidth(beamwidth))))
    gain = pattern.gain(np.arange(steps + 2, dtype=np.float64) * (np.pi / steps), beamwidth)
    return gain[:-1], np.diff(gain)


def grid_rows(azimuths: int, beamwidth: float) -> int:
    """Rows of the azimuth grid: a whole multiple of `azimuths`, such that the beam fills at most a third of the band.

    beamwidth: `aperture_beamwidth` of the pattern [rad]. A sinc^2 beam has spatial frequencies up to 0.886 / beamwidth; at an
    oversampling of 2.9 a kernel of four rows errs by -78 dB (docs/engine.md#errors), one of six by less than float32.
    """
    return azimuths * max(1, int(np.ceil(2.9 / azimuth_oversampling(beamwidth, azimuths))))


def azimuth_oversampling(beamwidth: float, rows: int) -> float:
    """The band of a grid of `rows` per circle over that of the beam: 0.564 beamwidth / step for a sinc^2 beam."""
    return beamwidth * rows / (2.0 * np.pi) / (2.0 * 0.8859)
