"""How a ship moves in a seaway: roll, pitch, yaw and heave."""

from dataclasses import dataclass, field

import numpy as np

from radar_service.numerics.frames import map_from_deck
from radar_service.numerics.types import Floats

STEP = 1e-20  # s of the complex step: its square is nothing beside 1, so that the derivative is exact to rounding


@dataclass(frozen=True)
class Sway:
    """Roll, pitch, yaw and heave: amplitude x sin(2 pi t / period + phase), about the origin of the ship's own frame.

    amplitude: (4,) of roll (starboard side down), pitch (bow up) and yaw (to starboard) [rad], and of heave (up) [m].
    period: (4,) [s]. phase: (4,) [rad].
    """

    amplitude: Floats
    period: Floats
    phase: Floats = field(default_factory=lambda: np.zeros(4))

    def __post_init__(self) -> None:
        assert self.amplitude.shape == self.period.shape == self.phase.shape == (4,)

    @property
    def tilts(self) -> bool:
        """Whether the ship rolls or pitches."""
        return bool(self.amplitude[:2].any())

    @property
    def max_tilt(self) -> float:
        """An angle [rad] that its mast never leaves the vertical by."""
        return float(self.amplitude[:2].sum())

    @property
    def max_heave(self) -> float:
        """The amplitude of heave [m]."""
        return float(self.amplitude[3])

    @property
    def max_rates(self) -> Floats:
        """The highest rates (4,) [rad/s, m/s] of roll, pitch, yaw and heave."""
        return self.amplitude * 2.0 * np.pi / self.period

    def angles(self, time: Floats) -> Floats:
        """Returns roll, pitch and yaw (K, 3) [rad] at each time (K,) [s]."""
        angle = 2.0 * np.pi / self.period[:3] * time[:, None] + self.phase[:3]
        return np.asarray(self.amplitude[:3] * np.sin(angle))

    def heave(self, time: Floats) -> Floats:
        """Returns the height (K,) [m] above the mean at each time (K,) [s]."""
        return np.asarray(self.amplitude[3] * np.sin(2.0 * np.pi / self.period[3] * time + self.phase[3]))

    def rate(self, which: int, time: Floats) -> Floats:
        """Returns the rate (K,) of the angle or the heave `which` (0 to 3: roll, pitch, yaw, heave) [rad/s, m/s]."""
        frequency = 2.0 * np.pi / self.period[which]
        return np.asarray(self.amplitude[which] * frequency * np.cos(frequency * time + self.phase[which]))

    def rotation(self, heading: Floats, time: Floats) -> Floats:
        """Returns matrices (K, 3, 3) map_from_body at each time (K,) [s]; heading: (K,) with yaw [rad]."""
        roll, pitch, _ = self.angles(time).T
        return map_from_deck(heading, roll, pitch)

    def rotation_rate(self, heading: Floats, turn_rate: Floats, time: Floats) -> Floats:
        """Returns how the matrices (K, 3, 3) of `rotation` change [1/s]; turn_rate: (K,) of the heading with yaw [rad/s].

        By the complex step (Squire and Trapp, SIAM Review 40, 1998).
        """
        roll, pitch, _ = self.angles(time).T
        rates = turn_rate, self.rate(0, time), self.rate(1, time)
        ahead = (angle + 1j * STEP * rate for angle, rate in zip((heading, roll, pitch), rates, strict=True))
        return np.asarray(map_from_deck(*ahead).imag / STEP)
