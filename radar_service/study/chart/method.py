"""A method of the signal chain: a function from echoes to range profiles.

A method is built for a radar and then run on echoes and spokes. Its preparation for the radar is not timed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radar_service.echo.echoes import Echoes
from radar_service.numerics.types import Floats, Indices, Profiles
from radar_service.radar.parameters import Radar

Run = Callable[[Echoes, Indices], Profiles]
BLOCK = 16  # azimuths computed together, as in the engine


@dataclass(frozen=True)
class Method:
    """One method at one setting.

    family: name of the method;
    setting: the setting, for a reader;
    run: makes profiles (K, N) of echoes for spokes (K,);
    radar: the radar, with the sampling rate of this method;
    first: range of sample 0 [range steps];
    reach: largest offset of an echo from boresight [rad]; None where the method computes the whole scan at once;
    preset: the preset that uses this setting, if any;
    slow: whether the method is timed on a subset of the echoes.
    """

    family: str
    setting: str
    run: Run
    radar: Radar
    first: float
    reach: float | None
    preset: str | None = None
    slow: bool = False

    @property
    def sample_range(self) -> Floats:
        """Ranges (N,) [m] of the samples."""
        return np.asarray((np.arange(self.radar.bins) + self.first) * self.radar.range_step, dtype=np.float64)
