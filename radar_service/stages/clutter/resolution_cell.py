"""The resolution cell of a radar, and the levels that sea and rain clutter share."""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics import Floats, Gain, Indices, Profiles
from radar_service.propagation import attenuation_amplitude, rain_db_per_km, received_amplitude
from radar_service.radar import Radar
from radar_service.receive import Compression
from radar_service.world import Scene

MIN_CLUTTER_TO_NOISE = 10.0**-1.5  # weaker clutter is not added: it would raise the noise by less than 0.14 dB
TWO_WAY_EXTENT = 2.0  # two-way widths each side: a sinc^2 beam is past the first null, and its power 53 dB down beyond


@dataclass(frozen=True)
class ResolutionCell:
    """The resolution cell of a beam and a pulse.

    width: integral of the two-way azimuth pattern G^2 [rad].
    length: integral over range of the compressed pulse's power [m], for a unit peak.
    """

    width: float
    length: float

    def area(self, distance: Floats) -> Floats:
        """Area of sea [m^2] in the cell at a slant range [m]. As d dd = R dR, R replaces the ground distance."""
        return distance * self.width * self.length


def resolution_cell(gain: Gain, compression: Compression, range_step: float) -> ResolutionCell:
    """The cell of a beam of azimuth gain `gain` and of a compressed pulse; range_step: of its samples [m]."""
    offset = (np.arange(2**16, dtype=np.float64) + 0.5) * (2.0 * np.pi / 2**16) - np.pi
    width = float(np.mean(gain(offset) ** 2) * 2.0 * np.pi)
    return ResolutionCell(width, float(np.mean(pulse_power(compression))) * range_step)  # Parseval


def two_way_gain(radar: Radar, offset: Floats, stretch: float = 1.0) -> Floats:
    """Two-way power gain at offsets from boresight in azimuth [rad], of a beam `stretch` times as wide."""
    return radar.azimuth_gain(offset / stretch) ** 2


def pulse_power(compression: Compression) -> Floats:
    """|spectrum|^2 (size,) in FFT order of the sampled compressed pulse of unit peak."""
    column = np.array([compression.size // 2])  # beyond the eclipsed ranges of a one-antenna radar
    return np.asarray(np.abs(compression.spectrum(_unit_echoes(compression, column))[0]) ** 2)


def received_share(scene: Scene, compression: Compression) -> Floats:
    """Share (bins,) of an echo's energy that a one-antenna radar receives; below 1 where transmission eclipses a part."""
    radar = scene.radar
    if not radar.eclipsing:
        return np.ones(radar.bins)
    eclipsed = min(radar.bins, int(np.ceil(radar.pulse * radar.sample_rate)) + 1)  # bins within c T / 2
    column = np.unique(np.linspace(0, eclipsed - 1, 64).astype(np.int64))
    energy = np.sum(np.abs(compression.profiles(_unit_echoes(compression, column))) ** 2, axis=1)
    energy = energy / np.mean(pulse_power(compression))
    return np.asarray(np.interp(np.arange(radar.bins), np.append(column, eclipsed), np.append(energy, 1.0)))


def unit_power(scene: Scene, distance: Floats) -> Floats:
    """Received power [W] of 1 m^2 on boresight at slant ranges (N,) [m], after gas and rain loss."""
    radar, environment = scene.radar, scene.environment
    rain = rain_db_per_km(environment.rain_mm_h, radar.polarization, radar.frequency)
    return (received_amplitude(radar, distance) * attenuation_amplitude(distance, environment.gas_db_per_km + rain)) ** 2


def _unit_echoes(compression: Compression, column: Indices) -> Profiles:
    """Rows (E, size) with one unit echo each, gridded at a column."""
    gridded = np.zeros((len(column), compression.size), dtype=np.complex64)
    first, weights = compression.kernel.weights(column.astype(np.float64))
    for row, start in enumerate(first):
        gridded[row, (start + np.arange(weights.shape[1])) % compression.size] = weights[row]
    return gridded
