"""The parameters of a radar in SI and radians, and quantities derived from them: ranges, angles, the schedule of spokes."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from radar_service.numerics import SPEED_OF_LIGHT, Flags, Floats, Indices
from radar_service.radar.antenna import AntennaPattern, interpolated_gain

if TYPE_CHECKING:
    from radar_service.radar.waveform import Chirp

FIRST_ID = "0"  # of a radar that its scene gives no id
FULL_CIRCLE = 2.0 * np.pi
Value = TypeVar("Value", float, Floats)
EDGE = 1e-9  # rad; so that rounded degrees do not exclude the ends of a blind sector


@dataclass(frozen=True)
class NearPulse:
    """A pulse that serves the ranges from the end of the one before to its own; fields in the units of Radar."""

    modulation: str
    bandwidth: float
    pulse: float
    window: str
    compression: str
    bins: int
    range_max: float


@dataclass(frozen=True)
class Radar:
    """The radar of a scene; RadarModel has the allowed ranges.

    frequency: of the carrier [Hz].
    modulation: "lfm", a linear chirp, "nlfm", a nonlinear one, or "none", a plain pulse.
    bandwidth: of the chirp, or of the receiver of a plain pulse [Hz].
    pulse: its length [s].
    sample_rate: of complex samples [Hz].
    window: on the reference of a linear chirp, or the power spectrum of a nonlinear one.
    compression: of a chirp, "matched" or "inverse".
    prf: pulses per second [Hz]; None where it has no effect.
    second_time_around: whether echoes beyond the unambiguous range fold.
    azimuths: spokes per scan.
    rotation_period: time of a scan [s].
    bins: samples of a profile.
    range_max: far end of the profile [m].
    range_min: levels at shorter ranges are those at this one [m].
    beamwidth: horizontal, one-way half power [rad].
    beamwidth_el: vertical, one-way half power [rad].
    tilt: elevation of boresight [rad].
    pattern: horizontal antenna pattern.
    pattern_el: vertical antenna pattern.
    height: of the antenna above the sea [m].
    power: transmitted peak power [W].
    gain: of the antenna, power ratio.
    loss: power ratio, 1 or more.
    noise_factor: power ratio, 1 or more.
    polarization: "h" or "v".
    eclipsing: whether one antenna serves to transmit and to receive.
    rays: per azimuth, for sampling by rays.
    blind_sectors: start and end clockwise from the bow [rad].
    near_pulses: other pulses, which serve the nearer ranges, by rising range.
    effects: what effects keep of it, by their names.
    label_floor: lowest power that is labelled as a body's, over the body's peak in the spoke; 0: every power.
    integration: whether the pulses of a spoke are integrated without their phases.
    scales: range scales of the set that it is [m], rising; none where it is no set.
    """

    frequency: float
    modulation: str
    bandwidth: float
    pulse: float
    sample_rate: float
    window: str
    prf: float | None
    second_time_around: bool
    azimuths: int
    rotation_period: float
    bins: int
    range_max: float
    range_min: float
    beamwidth: float
    beamwidth_el: float
    tilt: float
    pattern: AntennaPattern
    pattern_el: AntennaPattern
    height: float
    power: float
    gain: float
    loss: float
    noise_factor: float
    polarization: str
    eclipsing: bool
    rays: int
    blind_sectors: tuple[tuple[float, float], ...]
    compression: str = field(default="matched", metadata={"added": 1})  # see truth.truth_file.scene_hash
    near_pulses: tuple[NearPulse, ...] = field(default=(), metadata={"added": 1})
    effects: Mapping[str, Any] = field(default_factory=dict, hash=False)
    label_floor: float = field(default=1e-3, metadata={"added": 1})
    integration: bool = field(default=False, metadata={"added": 1})
    scales: tuple[float, ...] = field(default=(), metadata={"added": 1})

    @property
    def of_each_pulse(self) -> tuple["Radar", ...]:
        """A radar for each pulse by rising range, as if it had that one alone out to the end of its ranges."""
        last = replace(self, near_pulses=())
        return (*(replace(last, **asdict(pulse)) for pulse in self.near_pulses), last)

    @property
    def wavelength(self) -> float:
        """Free-space wavelength [m] (docs/specification.md eq. 1)."""
        return SPEED_OF_LIGHT / self.frequency

    @property
    def chirp(self) -> "Chirp":
        """The chirp and its filter; of no meaning for a plain pulse."""
        from radar_service.radar.waveform import Chirp  # here: scipy would slow the start of the service

        return Chirp(self.bandwidth, self.pulse, self.window, self.modulation, self.compression)

    @property
    def range_step(self) -> float:
        """Length of a range bin [m]: c / (2 fs)."""
        return SPEED_OF_LIGHT / (2.0 * self.sample_rate)

    @property
    def range_resolution(self) -> float:
        """Minimum distance [m] between two resolved echoes of an unweighted chirp: c / 2B."""
        return SPEED_OF_LIGHT / (2.0 * self.bandwidth)

    @property
    def blind_range(self) -> float:
        """Range [m] within which echoes arrive while a one-antenna radar still transmits: c T / 2."""
        return SPEED_OF_LIGHT * self.pulse / 2.0

    @property
    def unambiguous_range(self) -> float:
        """Range [m] of an echo that arrives with the next pulse: c / (2 prf); inf without a pulse repetition frequency."""
        return np.inf if self.prf is None else SPEED_OF_LIGHT / (2.0 * self.prf)

    @property
    def azimuth_step(self) -> float:
        """Angle from one spoke to the next [rad]."""
        return 2.0 * np.pi / self.azimuths

    @property
    def spoke_period(self) -> float:
        """Time from one spoke to the next [s]."""
        return self.rotation_period / self.azimuths

    @property
    def longest_range(self) -> float:
        """The longest range that its range control has [m]."""
        return self.scales[-1] if self.scales else self.range_max

    def scale_for(self, distance: float) -> float:
        """Returns the shortest range scale of a set that shows a distance [m], to 1 %; the longest beyond it."""
        return next((scale for scale in self.scales if scale >= distance / 1.01), self.longest_range)

    @property
    def pulses_integrated(self) -> int:
        """Number of pulses in a spoke whose powers are averaged."""
        return max(1, int(self.prf * self.spoke_period + 1e-9)) if self.integration and self.prf else 1

    def azimuth_gain(self, offset: Floats) -> Floats:
        """One-way power gain relative to boresight at offsets in azimuth [rad] of any shape, by a table."""
        return interpolated_gain(offset, self.beamwidth, self.pattern)

    def schedule(self, number: Indices) -> tuple[Floats, Floats]:
        """Boresight [rad from north, 0 to 2 pi] and time [s] of spokes (K,) numbered from the start of the simulation."""
        index = np.asarray(number % self.azimuths, dtype=np.float64)
        return index * self.azimuth_step, self.time_of_spokes(np.asarray(number, dtype=np.float64))

    def time_of_spokes(self, number: Value) -> Value:
        """Time [s] of spokes numbered from the start of the simulation, also between spokes."""
        return number * self.spoke_period

    def spokes_at(self, time: Value) -> Value:
        """Numbers of spokes at times [s], also between spokes."""
        return time / self.spoke_period

    def first_spoke(self, time: float) -> int:
        """Number of the first spoke that is not before a time [s], exactly as `time_of_spokes` rounds."""
        number = math.ceil(self.spokes_at(time))
        while self.time_of_spokes(float(number)) < time:
            number += 1
        while self.time_of_spokes(float(number - 1)) >= time:
            number -= 1
        return number

    def first_scan(self, time: float) -> int:
        """Number of the first scan that does not begin before a time [s]."""
        return -(-self.first_spoke(time) // self.azimuths)

    def time_of_turns(self, turns: Value) -> Value:
        """Time [s] at which the boresight has turned so many times since the start of the simulation."""
        return turns * self.rotation_period

    def turns_at(self, time: Value) -> Value:
        """How many times the boresight has turned at times [s]."""
        return time / self.rotation_period

    def is_blind(self, from_bow: Floats) -> Flags:
        """Which boresights (K,) [rad clockwise from the bow] lie in a blind sector."""
        blind = np.zeros(from_bow.shape, dtype=np.bool_)
        for start, stop in self.blind_sectors:
            blind |= in_sector(from_bow, start, stop)
        return blind


def horizon(height: Floats | float, antenna_height: Floats | float, earth_radius: float) -> Floats:
    """Ground distance [m] beyond which the curved sea occludes a target: sqrt(2 ae h1) + sqrt(2 ae h2), inf on a flat earth.

    height: of the target above the sea, any shape, negative ones count as 0 [m]; antenna_height: of that shape, or one [m];
    earth_radius: effective [m].
    Source: Skolnik 2001, geometry of the refracted horizon.
    """
    raised = np.maximum(height, 0.0)
    if np.isinf(earth_radius):
        return np.full(raised.shape, np.inf)  # and not inf x 0
    return np.asarray(np.sqrt(2.0 * earth_radius * antenna_height) + np.sqrt(2.0 * earth_radius * raised))


def in_sector(angle: Floats, start: float, stop: float) -> Flags:
    """Which angles (K,) lie between `start` and `stop`, clockwise [rad].

    A sector includes both its ends. Ends that differ by full circles make a full circle.
    """
    return np.asarray((angle - start + EDGE) % FULL_CIRCLE <= _sector_width(start, stop) + 2.0 * EDGE)


def _sector_width(start: float, stop: float) -> float:
    """Width [rad] of a sector from `start` clockwise to `stop` [rad], above 0 and at most a full circle."""
    width = (stop - start) % FULL_CIRCLE
    return FULL_CIRCLE if width < EDGE or FULL_CIRCLE - width < EDGE else width


def max_rpm(prf: float, azimuths: int) -> float:
    """Returns the maximum rotation rate [rpm] at which each spoke has a pulse of its own, with a margin for rounding."""
    return 60.0 * prf / azimuths * (1.0 + 1e-9)
