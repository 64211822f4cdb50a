"""When the aspect of a body counts: physical optics is evaluated for the moment the beam passes it, once a revolution."""

from dataclasses import dataclass

import numpy as np

from radar_service.scene.world import Body, Scene

STALE = 2.5  # s; where the beam passes no nearer in time than this, a slow antenna's, the aspect is that of the time asked


@dataclass(frozen=True)
class BeamCrossing:
    """When the beam of a scene's radar passes bodies."""

    scene: Scene

    def moment(self, body: Body, time: float) -> float:
        """The instant [s] nearest to `time` [s] when the boresight points at a body, to a spoke; `time` itself where that is
        further off than STALE. Never before 0."""
        period = self.scene.radar.rotation_period
        passing = time
        for _ in range(3):  # a body that crosses a hundredth of a turn per revolution leaves 1e-6 of one
            ahead = (self._azimuth(body, passing) / (2.0 * np.pi) - time / period + 0.5) % 1.0 - 0.5
            passing = max(0.0, time + ahead * period)
        if abs(passing - time) > STALE:
            return time
        return round(passing / self.scene.radar.spoke_period) * self.scene.radar.spoke_period

    def _azimuth(self, body: Body, time: float) -> float:
        east, north, _ = body.middle_at(time) - self.scene.antenna(time)[0]
        return float(np.arctan2(east, north))
