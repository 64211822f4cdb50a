"""The echoes of a set of scatterers, with the radar equation written once."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import Polar, effective_earth_radius
from radar_service.propagation.multipath import gas_amplitude, rain_db_per_km, two_ray_factor
from radar_service.propagation.sea_surface import rms_wave_height
from radar_service.radar.antenna import quick_gain
from radar_service.radar.parameters import Radar
from radar_service.scene.world import Environment

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class Echoes:
    """Echoes as the boresight would hear them: range [m], azimuth [rad], amplitude [sqrt(W)], all (E,)."""

    range: Floats
    azimuth: Floats
    amplitude: Complexes

    def __post_init__(self) -> None:
        assert self.range.shape == self.azimuth.shape == self.amplitude.shape


def received_amplitude(radar: Radar, distance: Floats) -> Floats:
    """Root of the received power [sqrt(W)] of 1 m^2 at slant range `distance` [m] on boresight, in free space.

    P = Pt G^2 lambda^2 sigma / ((4 pi)^3 R^4 L) (Skolnik 2001, eq. 1.7). Inside radar.range_min the range counts as that.
    """
    nearest = np.maximum(distance, radar.range_min)
    constant = radar.power * radar.gain**2 * radar.wavelength**2 / ((4.0 * np.pi) ** 3 * radar.loss)
    return np.asarray(np.sqrt(constant) / nearest**2)


def path_factor(
    radar: Radar, environment: Environment, polar: Polar, height: Floats, lifted: Floats | float = 0.0
) -> Complexes:
    """What the way there and back does to the amplitude, complex (E,): elevation gain, gas and rain, the sea's mirror.

    height: of the scatterers above the sea [m]; lifted: how far the antenna's sway has put each one up in its beam [rad].
    """
    rain = rain_db_per_km(environment.rain_mm_h, radar.polarization, radar.frequency)
    gas = gas_amplitude(polar.range, environment.gas_db_per_km + rain)
    factor = (elevation_gain(radar, polar.elevation, lifted) * gas).astype(np.complex128)
    if environment.multipath:
        factor *= (
            two_ray_factor(
                polar.distance,
                height,
                radar.height,
                radar.wavelength,
                earth_radius=effective_earth_radius(environment.earth_factor),
                polarization=radar.polarization,
                wave_height=rms_wave_height(environment.sea_state),
                elevation_gain=partial(elevation_gain, radar, lifted=lifted),
            )
            ** 2
        )
    return factor


def elevation_gain(radar: Radar, elevation: Floats, lifted: Floats | float = 0.0) -> Floats:
    """One-way power gain relative to boresight at elevations [rad] from horizontal; lifted: as in `path_factor`."""
    return quick_gain(elevation + lifted - radar.tilt, radar.beamwidth_el, radar.pattern_el)


def two_way_phase(distance: Floats, wavelength: float) -> Complexes:
    """exp(-4 pi j R / lambda) (DESIGN section 2; corrects the sign of seed eq. 11)."""
    return np.asarray(np.exp(-4j * np.pi / wavelength * distance))
