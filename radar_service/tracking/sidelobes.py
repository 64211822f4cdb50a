"""The sidelobe gate: a plot that is no stronger than the sidelobes of a stronger echo is not reported."""

import numpy as np

from radar_service.fidelity import PRESETS
from radar_service.radar.parameters import Radar
from radar_service.receive.compression import compression_for, receiver_noise_power
from radar_service.tracking.detections import Detections
from radar_service.types import Floats

MAIN_LOBE = 0.01  # of the two-way gain on boresight: sidelobes are weaker

NOISE_PEAK = 2.5  # times the mean noise amplitude: noise adds that much to a sidelobe in one cell of 500


class SidelobeGate:
    """Knows how strong the sidelobes of a radar are at most, by their distance from an echo in azimuth and in range."""

    def __init__(self, radar: Radar, margin_db: float) -> None:
        """margin_db: sidelobes may be this much stronger than those of a point at rest."""
        self._margin = 10.0 ** (margin_db / 10.0)
        self._azimuths = radar.azimuths
        self._noise = NOISE_PEAK * np.sqrt(receiver_noise_power(radar))
        self._azimuth = azimuth_envelope(radar)
        self._range = range_envelope(radar)

    def is_sidelobe(self, plot: Detections, every: Detections) -> bool:
        """Returns whether a stronger echo among the detections of the same scans explains a plot.

        plot: the detections of the plot; every: all detections, its own among them.
        """
        peak = int(plot.power.argmax())
        spoke, cell, power = plot.spoke[peak], plot.cell[peak], plot.power[peak]
        stronger = np.flatnonzero(every.power * self._margin > power)
        spokes, cells, powers = every.spoke[stronger], every.cell[stronger], every.power[stronger]
        apart = np.abs(spokes - spoke)
        across = np.minimum(apart % self._azimuths, -apart % self._azimuths)  # the beam meets an echo again a scan later,
        again = (apart > self._azimuths // 2) & (self._azimuth[across] > MAIN_LOBE)  # and the plot's own echo as well
        along = np.minimum(np.abs(cells - cell), len(self._range) - 1)
        along = np.maximum(along - 1, 0)  # an echo stands between two cells
        own = np.isin(spokes * 2**32 + cells, plot.spoke * 2**32 + plot.cell)
        level = (powers * self._azimuth[across] * self._range[along])[~again & ~own].max(initial=0.0)
        return bool(np.sqrt(power) <= np.sqrt(level * self._margin) + self._noise)


def azimuth_envelope(radar: Radar) -> Floats:
    """Returns the highest two-way gain (A // 2 + 1,) at each number of spokes from boresight and beyond, 1 at 0."""
    fine = 16
    offset = np.arange((radar.azimuths // 2) * fine + 1, dtype=np.float64) * (radar.azimuth_step / fine)
    return _envelope(radar.azimuth_gain(offset) ** 2)[::fine]


def range_envelope(radar: Radar) -> Floats:
    """Returns the highest power (N,) of a compressed echo of unit peak at each number of cells from its middle and beyond."""
    compression = compression_for(radar, PRESETS["reference"].kernel_width)
    half = radar.bins // 2
    rows = np.zeros((1, compression.size), dtype=np.complex64)
    one = np.ones((1, 1), dtype=np.complex64)
    compression.spread(rows, np.array([float(half)]), np.zeros((1, 1), dtype=np.float32), one)
    profile = np.abs(compression.profiles(rows)[0].astype(np.complex128)) ** 2
    return _envelope(profile[half:] / profile[half])


def _envelope(power: Floats) -> Floats:
    return np.asarray(np.maximum.accumulate(power[::-1])[::-1])
