"""What a method of the signal chain is: it makes profiles of echoes.

It is built for a radar and then run on echoes and spokes. Whatever it prepares once for a radar is not timed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.propagation.radar_equation import Echoes
from radar_service.radar.parameters import Radar

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Profiles = NDArray[np.complex64]
Run = Callable[[Echoes, Indices], Profiles]
TILE = 16  # azimuths at a time, as the engine takes them


@dataclass(frozen=True)
class Method:
    """One method at one setting: what makes profiles (K, N) of echoes for spokes (K,).

    radar: with the sampling rate of this method; first: where sample 0 stands, in steps; reach: how far from boresight
    echoes are taken [rad], each azimuth for itself, or None where the whole turn is worked out at once from all echoes;
    slow: whether it is timed on a thinned list of echoes only.
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
    def places(self) -> Floats:
        """Ranges (N,) [m] of the samples."""
        return np.asarray((np.arange(self.radar.bins) + self.first) * self.radar.range_step, dtype=np.float64)
