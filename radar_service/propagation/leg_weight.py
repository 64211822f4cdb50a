"""How strongly a wave arrives by a leg: spreading, elevation pattern, and reflection by the sea."""

from dataclasses import dataclass

import numpy as np

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.propagation.legs import Leg
from radar_service.propagation.multipath import MIN_GAIN
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.propagation.sea_surface import fresnel, miller_brown, rms_wave_height, sea_water_permittivity
from radar_service.radar.parameters import Radar
from radar_service.types import Complexes


@dataclass(frozen=True)
class LegWeight:
    """The one-way amplitude of a leg over that at 1 m on boresight, without its phase: the same factors as the echo's own.

    radar: the antenna's pattern, wavelength and polarization; sea_state: Douglas, 0 to 9.
    """

    radar: Radar
    sea_state: int

    def __call__(self, leg: Leg, by_sea: bool) -> Complexes:
        """(M,) [1/m]; by_sea: whether the sea reflects the leg."""
        gain = np.sqrt(np.maximum(elevation_gain(self.radar, leg.elevation), MIN_GAIN)) / leg.length
        if not by_sea:
            return gain.astype(np.complex128)
        permittivity = sea_water_permittivity(SPEED_OF_LIGHT / self.radar.wavelength)
        wave_height = rms_wave_height(self.sea_state)
        surface = fresnel(leg.grazing, permittivity, self.radar.polarization)
        return np.asarray(gain * surface * miller_brown(leg.grazing, wave_height, self.radar.wavelength) * leg.divergence)
