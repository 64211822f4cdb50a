"""The parameters of a radar in SI and radians, and what follows from them alone: ranges, angles, the schedule of spokes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.radar.antenna import AntennaPattern, quick_gain

Floats = NDArray[np.float64]
TURN = 2.0 * np.pi
EDGE = 1e-9  # rad; the ends of a blind sector belong to it whatever the rounding of degrees


@dataclass(frozen=True)
class Radar:
    """The radar of a scene; see RadarModel for meanings and allowed ranges."""

    frequency: float
    modulation: str
    bandwidth: float  # of the chirp; of the receiver where the pulse has no modulation
    pulse: float
    sample_rate: float
    window: str
    prf: float | None  # pulses per second, None where it does not matter
    second_time_around: bool
    azimuths: int
    rotation_period: float  # s per scan
    bins: int
    range_max: float
    range_min: float
    beamwidth: float  # rad, one-way half power, horizontal
    beamwidth_el: float
    tilt: float
    pattern: AntennaPattern  # horizontal
    pattern_el: AntennaPattern
    height: float
    power: float
    gain: float  # power ratio
    loss: float  # power ratio >= 1
    noise_factor: float  # power ratio >= 1
    polarization: str
    eclipsing: bool
    rays: int
    blind_sectors: tuple[tuple[float, float], ...]  # rad, clockwise from the bow

    @property
    def wavelength(self) -> float:
        """Free-space wavelength [m] (seed eq. 1)."""
        return SPEED_OF_LIGHT / self.frequency

    @property
    def range_step(self) -> float:
        """Length of a range bin [m]: c / (2 fs)."""
        return SPEED_OF_LIGHT / (2.0 * self.sample_rate)

    @property
    def range_resolution(self) -> float:
        """Least distance [m] at which two echoes of a chirp are told apart, before its window widens it: c / 2B."""
        return SPEED_OF_LIGHT / (2.0 * self.bandwidth)

    @property
    def blind_range(self) -> float:
        """Range [m] within which echoes arrive while a one-antenna radar still transmits: c T / 2."""
        return SPEED_OF_LIGHT * self.pulse / 2.0

    @property
    def unambiguous_range(self) -> float:
        """Range [m] whose echo arrives with the next pulse: c / (2 prf); inf without a pulse repetition frequency."""
        return np.inf if self.prf is None else SPEED_OF_LIGHT / (2.0 * self.prf)

    @property
    def azimuth_step(self) -> float:
        """Angle from one spoke to the next [rad]."""
        return 2.0 * np.pi / self.azimuths

    @property
    def spoke_period(self) -> float:
        """Time from one spoke to the next [s]."""
        return self.rotation_period / self.azimuths

    def azimuth_gain(self, offset: Floats) -> Floats:
        """One-way power gain relative to boresight at offsets in azimuth [rad] of any shape, by a table."""
        return quick_gain(offset, self.beamwidth, self.pattern)

    def schedule(self, number: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Boresight [rad from north, 0 to 2 pi] and time [s] of spokes (K,) numbered from the start of the simulation."""
        index = np.asarray(number % self.azimuths, dtype=np.float64)
        return index * self.azimuth_step, np.asarray(number, dtype=np.float64) * self.spoke_period

    def is_blind(self, from_bow: Floats) -> NDArray[np.bool_]:
        """Whether the radar is silent (K,): boresights (K,) [rad clockwise from the bow] in a blind sector.

        A sector runs clockwise and holds both its ends. Ends that differ by whole turns make a full circle.
        """
        silent = np.zeros(from_bow.shape, dtype=np.bool_)
        for start, stop in self.blind_sectors:
            silent |= (from_bow - start + EDGE) % TURN <= _sector_width(start, stop) + 2.0 * EDGE
        return silent


def horizon(height: Floats | float, antenna_height: float, earth_radius: float) -> Floats:
    """Ground distance [m] beyond which the sea hides a target: sqrt(2 ae h1) + sqrt(2 ae h2), inf on a flat earth.

    height: of the target above the sea, any shape, below 0 as 0 [m]; antenna_height [m]; earth_radius: effective [m].
    Source: Skolnik 2001, geometry of the refracted horizon.
    """
    raised = np.maximum(height, 0.0)
    if np.isinf(earth_radius):
        return np.full(raised.shape, np.inf)  # and not inf x 0
    return np.asarray(np.sqrt(2.0 * earth_radius * antenna_height) + np.sqrt(2.0 * earth_radius * raised))


def _sector_width(start: float, stop: float) -> float:
    """Width [rad] of a sector from `start` clockwise to `stop` [rad], above 0 and at most a full turn."""
    width = (stop - start) % TURN
    return TURN if width < EDGE or TURN - width < EDGE else width
