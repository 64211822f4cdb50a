"""The radar equation, and the path factor: elevation gain, gas and rain loss, and multipath."""

from functools import partial

import numpy as np

from radar_service.frames import Polar, effective_earth_radius
from radar_service.propagation.attenuation import attenuation_amplitude, rain_db_per_km
from radar_service.propagation.multipath import two_ray_factor
from radar_service.propagation.sea_surface import rms_wave_height
from radar_service.radar.antenna import interpolated_gain
from radar_service.radar.parameters import Radar
from radar_service.scene.environment import Environment
from radar_service.types import Complexes, Floats


def received_amplitude(radar: Radar, distance: Floats) -> Floats:
    """Root of the received power [sqrt(W)] of 1 m^2 at slant ranges `distance` (any shape) [m] on boresight, in free space.

    P = Pt G^2 lambda^2 sigma / ((4 pi)^3 R^4 L) (Skolnik 2001, eq. 1.7). Ranges below radar.range_min count as range_min.
    """
    nearest = np.maximum(distance, radar.range_min)
    constant = radar.power * radar.gain**2 * radar.wavelength**2 / ((4.0 * np.pi) ** 3 * radar.loss)
    return np.asarray(np.sqrt(constant) / nearest**2)


def path_factor(
    radar: Radar, environment: Environment, polar: Polar, height: Floats, tilt_error: Floats | float = 0.0
) -> Complexes:
    """Two-way amplitude factor (E,) of the path, complex: elevation gain, gas and rain loss, sea reflection.

    polar: positions of the scatterers relative to the antenna; height: (E,) above the sea [m]; tilt_error: (E,) added to the
    elevation in the beam, where the antenna sways [rad].
    """
    rain = rain_db_per_km(environment.rain_mm_h, radar.polarization, radar.frequency)
    gas = attenuation_amplitude(polar.range, environment.gas_db_per_km + rain)
    factor = (elevation_gain(radar, polar.elevation, tilt_error) * gas).astype(np.complex128)
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
                elevation_gain=partial(elevation_gain, radar, tilt_error=tilt_error),
            )
            ** 2
        )
    return factor


def elevation_gain(radar: Radar, elevation: Floats, tilt_error: Floats | float = 0.0) -> Floats:
    """One-way power gain relative to boresight at elevations [rad] from horizontal; tilt_error: as in `path_factor`."""
    return interpolated_gain(elevation + tilt_error - radar.tilt, radar.beamwidth_el, radar.pattern_el)


def two_way_phase(distance: Floats, wavelength: float) -> Complexes:
    """exp(-4 pi j R / lambda) (docs/conventions.md; corrects the sign of docs/specification.md eq. 11)."""
    return np.asarray(np.exp(-4j * np.pi / wavelength * distance))
