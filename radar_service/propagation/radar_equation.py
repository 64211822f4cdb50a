"""The radar equation, elevation gain, gas and rain loss, and the two rays of multipath as a radar's antenna weighs them."""

from functools import partial
from typing import Any

import numpy as np

from radar_service.numerics import Complexes, Floats, effective_earth_radius
from radar_service.propagation.diffraction import with_diffraction
from radar_service.propagation.gas_and_rain import attenuation_amplitude, rain_db_per_km
from radar_service.propagation.land_reflection import LandBefore, over_land
from radar_service.propagation.multipath import TwoRays, turned_back, two_rays
from radar_service.propagation.sea_surface import rms_wave_height
from radar_service.radar import Radar, interpolated_gain
from radar_service.world import Environment, SightLines


def received_amplitude(radar: Radar, distance: Floats) -> Floats:
    """Root of the received power [sqrt(W)] of 1 m^2 at slant ranges `distance` (any shape) [m] on boresight, in free space.

    P = Pt G^2 lambda^2 sigma / ((4 pi)^3 R^4 L) (Skolnik 2001, eq. 1.7). Ranges below radar.range_min count as range_min.
    """
    nearest = np.maximum(distance, radar.range_min)
    constant = radar.power * radar.gain**2 * radar.wavelength**2 / ((4.0 * np.pi) ** 3 * radar.loss)
    return np.asarray(np.sqrt(constant) / nearest**2)


def attenuation(radar: Radar, environment: Environment, distance: Floats) -> Floats:
    """Two-way amplitude factor (E,) of gas and rain over slant ranges (E,) [m]."""
    rain = rain_db_per_km(environment.rain_mm_h, radar.polarization, radar.frequency)
    return np.asarray(attenuation_amplitude(distance, environment.gas_db_per_km + rain))


def local_attenuation(radar: Radar, environment: Environment, lines: SightLines) -> Floats:
    """Two-way amplitude factor (E,) of what attenuates by place and time along lines of sight (E,)."""
    one_way_db = sum(
        (attenuator.one_way_db(radar, lines) for attenuator in environment.attenuators), np.zeros(len(lines.azimuth))
    )
    return np.asarray(10.0 ** (-one_way_db / 10.0))


def radar_two_rays(
    radar: Radar,
    environment: Environment,
    distance: Floats,
    height: Floats,
    antenna_height: Floats | float,
    tilt_error: Floats | float = 0.0,
    land: LandBefore | None = None,
) -> TwoRays:
    """The direct ray and the ray by the sea, or by land, for a radar in an environment.

    distance: along the earth, any shape [m]; height: above the sea [m]; antenna_height: above the sea as it sways, broadcast
    [m]; tilt_error: added to the elevations of both rays in the beam, where the antenna sways [rad]; land: before the targets.
    """
    earth_radius = effective_earth_radius(environment.earth_factor)

    def rays_at(d: Floats, h: Floats, antenna: Floats | float, tilt: Floats | float, **surface: Any) -> TwoRays:
        gain = partial(elevation_gain, radar, tilt_error=tilt)
        surface |= {"earth_radius": earth_radius, "polarization": radar.polarization, "elevation_gain": gain}
        return two_rays(d, h, antenna, radar.wavelength, **surface)

    rays = rays_at(distance, height, antenna_height, tilt_error, wave_height=rms_wave_height(environment.sea_state))
    site = (np.asarray(distance), np.asarray(height), np.asarray(antenna_height))
    if land is not None:
        rays = over_land(rays, land, site, tilt_error, earth_radius, rays_at)
    if not environment.diffraction:
        return rays
    return with_diffraction(rays, site, radar.wavelength, earth_radius, radar.polarization)


def elevation_gain(radar: Radar, elevation: Floats, tilt_error: Floats | float = 0.0) -> Floats:
    """One-way power gain relative to boresight at elevations [rad] from horizontal; tilt_error: added to them."""
    return interpolated_gain(elevation + tilt_error - radar.tilt, radar.beamwidth_el, radar.pattern_el)


def two_way_phase(distance: Floats, wavelength: float) -> Complexes:
    """exp(-4 pi j R / lambda) (docs/conventions.md; corrects the sign of docs/specification.md eq. 11)."""
    return np.asarray(turned_back(4.0 * np.pi / wavelength * distance), dtype=np.complex128)
