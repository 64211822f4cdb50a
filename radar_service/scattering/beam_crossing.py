"""When the beam crosses a body: a model whose echoes depend on aspect evaluates them for that instant, once a scan."""

from dataclasses import dataclass

import numpy as np

from radar_service.scene.body import Body
from radar_service.scene.world import Scene
from radar_service.types import Floats

MAX_WAIT = 2.5  # s; where the nearest crossing is further off than this (a slow antenna), the aspect is that of the instant


@dataclass(frozen=True)
class BeamCrossing:
    """When the beam of a scene's radar crosses bodies."""

    scene: Scene

    def instant(self, body: Body, time: float) -> float:
        """The instant [s] nearest to `time` [s] at which the boresight points at a body, rounded to a spoke, never before 0.

        Returns `time` itself where that is further off than MAX_WAIT.
        """
        period = self.scene.radar.rotation_period
        crossing = time
        for _ in range(3):  # a body that crosses a hundredth of a turn per scan leaves 1e-6 of one
            ahead = (self._azimuth(body, crossing) / (2.0 * np.pi) - time / period + 0.5) % 1.0 - 0.5
            crossing = max(0.0, time + ahead * period)
        if abs(crossing - time) > MAX_WAIT:
            return time
        return round(crossing / self.scene.radar.spoke_period) * self.scene.radar.spoke_period

    def antenna_moved(self, start: float, stop: float) -> Floats:
        """How far (3,) [m] the antenna moves from one instant to another [s]."""
        before, after = self.scene.antenna(np.array([start, stop]))
        return np.asarray(after - before)

    def _azimuth(self, body: Body, time: float) -> float:
        east, north, _ = body.middle_at(time) - self.scene.antenna(time)[0]
        return float(np.arctan2(east, north))
