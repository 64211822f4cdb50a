"""Rain clutter: the cross-section of a volume of drops, its share of the beam, and the power received from it."""

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.radar.parameters import horizon
from radar_service.stages.clutter.resolution_cell import ResolutionCell, unit_power
from radar_service.world.scene import Scene

WATER_FACTOR = 0.93  # |K|^2 of liquid water from 0 to 20 C at 3 to 10 cm (Gunn and East 1954)
RAIN_HEIGHT = 3000.0  # m above the sea: rain begins where snow melts, 0.36 km above 0 C in Rec. P.839; a temperate autumn


def reflectivity(rain_mm_h: float, wavelength: float) -> float:
    """Cross-section of rain per volume eta [m^2/m^3]: pi^5 |K|^2 Z / lambda^4, Z = 200 R^1.6 mm^6/m^3.

    rain_mm_h: 0 and up, else ValueError; wavelength: [m], drops small against it (Rayleigh: 3 cm and longer). Sources:
    Probert-Jones 1962; Marshall and Palmer 1948 (with Gunn, 1952, for the coefficients).
    """
    if not rain_mm_h >= 0:
        raise ValueError(f"rain_mm_h: {rain_mm_h:g} is not allowed; 0 mm/h or more")
    z = 200.0 * rain_mm_h**1.6 * 1e-18  # m^6/m^3
    return float(np.pi**5 * WATER_FACTOR * z / wavelength**4)


def beam_height(distance: Floats, antenna_height: float, earth_radius: float, elevation: Floats, gain: Floats) -> Floats:
    """Integral of the two-way elevation pattern over the rain in the beam, an angle [rad], at each slant range.

    distance: (N,) [m]; antenna_height: [m]; earth_radius: effective, inf for flat [m]; elevation: (M,) rising over the
    extent of the beam [rad]; gain: (M,) one-way power gain there. Rain fills the air from the sea to RAIN_HEIGHT.
    """
    from scipy.integrate import cumulative_trapezoid  # here: few scenes have rain, and it would slow every start

    integral = np.concatenate([[0.0], cumulative_trapezoid(gain**2, elevation)])
    bend = distance / (2.0 * earth_radius)
    dip = -np.sqrt(2.0 * antenna_height / earth_radius)  # beyond the horizon the sea's bulge limits the beam
    floor = np.arcsin(np.clip(-antenna_height / distance - bend, -1.0, 1.0))
    beyond = distance > horizon(0.0, antenna_height, earth_radius)
    bottom = np.where(beyond, dip, floor)
    top = np.arcsin(np.clip((RAIN_HEIGHT - antenna_height) / distance - bend, -1.0, 1.0))
    filled = np.interp(top, elevation, integral) - np.interp(bottom, elevation, integral)
    return np.asarray(np.maximum(filled, 0.0))


def rain_power(scene: Scene, distance: Floats, cell: ResolutionCell, earth_radius: float) -> Floats:
    """Mean received power [W] of uniform rain at slant ranges (N,) [m]; earth_radius: effective, inf for flat [m]."""
    radar = scene.radar
    eta = reflectivity(scene.environment.rain_mm_h, radar.wavelength)
    elevation = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2**14 + 1)  # 0.011 degrees: five in the narrowest beam allowed
    height = beam_height(distance, radar.height, earth_radius, elevation, elevation_gain(radar, elevation))
    return eta * cell.area(distance) * distance * height * unit_power(scene, distance)
