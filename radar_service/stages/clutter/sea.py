"""Empirical laws of sea clutter: mean sigma0, its dependence on the wind, and shape, length and life of its texture.

Sigma0 is the measured one. It includes the interference of direct and reflected rays, so no multipath factor is applied to it.
"""

import numpy as np
from scipy.special import i0

from radar_service.numerics import GRAVITY, Floats
from radar_service.world import wind_speed

MAX_MEASURED_STATE = 6  # the data behind sigma0 end here; in sigma0 higher seas count as this one
MAX_GRAZING_DEG = 60.0  # the fit of sigma0 ends here; larger angles count as this one

# NRL 2012, coefficients c1 to c5 by polarization.
_SIGMA0 = {"h": (-73.00, 20.78, 7.351, 25.65, 0.00540), "v": (-50.79, 25.93, 0.7093, 21.58, 0.00211)}
_SHAPE_OFFSET = {"h": 2.09, "v": 1.39}
MEASURED_LENGTH, MEASURED_ACROSS = 4.2, (100.0, 800.0)  # m, of the cells behind the law of the shape (Ward 1982)
SHAPE_LIMITS = (0.05, 100.0)  # spikier than any sea measured; Rayleigh to 0.1 dB at Pfa 1e-4


def mean_sigma0(grazing: Floats, frequency: float, sea_state: float, polarization: str) -> Floats:
    """Mean sea clutter cross-section per area (power ratio), averaged over wind directions; 0 below the horizon.

    grazing: any shape [rad], fitted from 0.1 to 60 degrees; frequency: fitted from 0.5 to 35e9 [Hz]; sea_state: by wave
    height, fitted from 0 to 6; polarization: "h" or "v", else ValueError. Source: Gregers-Hansen and Mital, "An improved
    empirical model for radar sea clutter reflectivity", NRL/MR/5310-12-9346 (2012).
    """
    if polarization not in _SIGMA0:
        raise ValueError(f'polarization: "{polarization}" is not one of h, v')
    c1, c2, c3, c4, c5 = _SIGMA0[polarization]
    above = grazing > 0
    psi = np.minimum(np.rad2deg(np.where(above, grazing, 1.0)), MAX_GRAZING_DEG)
    sea = min(sea_state, MAX_MEASURED_STATE)
    level_db = c1 + c2 * np.log10(np.sin(np.deg2rad(psi))) + c5 * psi**2
    level_db += (27.5 + c3 * psi) * np.log10(frequency / 1e9) / (1.0 + 0.95 * psi)
    level_db += c4 * (1.0 + sea) ** (1.0 / (2.0 + 0.085 * psi + 0.033 * sea))
    return np.where(above, 10.0 ** (level_db / 10.0), 0.0)


def wind_factor(off_wind: Floats, grazing: Floats, wavelength: float) -> Floats:
    """Sigma0 over its mean over all directions (power ratio): maximum upwind, minimum downwind.

    off_wind: angle between the line of sight and the direction of the wind's origin [rad]; grazing: [rad]; both broadcastable;
    wavelength: [m]. The wind direction factor of the GIT model, exp(a cos phi) (Horst, Dyer and Tuley 1978), over its mean
    I0(a); a falls to 0 at a grazing angle of 20 degrees and stays there.
    """
    slope = np.maximum(1.0 - 2.8 * grazing, 0.0)
    a = 0.2 * slope * (wavelength + 0.015) ** -0.4 if wavelength >= 0.025 else 0.25 * slope * wavelength**-0.33
    return np.asarray(np.exp(a * np.cos(off_wind)) / i0(a))


def texture_shape(grazing: Floats, cell_area: Floats, polarization: str) -> Floats:
    """Shape nu of the gamma texture, clipped to SHAPE_LIMITS: small is spiky, large is Rayleigh.

    grazing: [rad], measured from 0.1 to 10 degrees; cell_area: of the resolution cell [m^2]; polarization: "h" or "v".
    log10 nu = 2/3 log10 psi_deg + 5/8 log10 A - k, k = 2.09 (h) or 1.39 (v), without its swell term: Ward, Tough and Watts,
    "Sea Clutter: Scattering, the K Distribution and Radar Performance" (2006), p. 237, there for X band. Its data: cells
    MEASURED_LENGTH long and MEASURED_ACROSS across.
    """
    psi = np.rad2deg(np.maximum(grazing, 1e-6))
    area = np.maximum(cell_area, 1e-6)
    nu = 10.0 ** (2.0 / 3.0 * np.log10(psi) + 5.0 / 8.0 * np.log10(area) - _SHAPE_OFFSET[polarization])
    return np.clip(nu, *SHAPE_LIMITS)


def speckle_time(wavelength: float) -> float:
    """Time [s] after which the field of sea clutter has the correlation 1/e: 7 ms in X band, in proportion to wavelength [m].

    Ward, Baker and Watts, IEE Proc. F 137(2), 1990, measured 5 to 10 ms in X band. The velocities on the sea that spread the
    Doppler spectrum are those of any band.
    """
    return 7e-3 * wavelength / 0.032


def swell_factor(off_waves: Floats) -> Floats:
    """Factor on the shape of texture where waves run, 10^(-cos(2 theta) / 3): spikier along them (Ward, as `texture_shape`).

    off_waves: angle between the line of sight and the direction of the waves [rad].
    """
    return np.asarray(10.0 ** (-np.cos(2.0 * off_waves) / 3.0))


def beyond_measured_shapes(cell_length: float, across: tuple[float, float]) -> str:
    """Says in which cells the shape of texture is extrapolated; "" for none. cell_length: [m]; across: first and last one [m]."""
    (least, most), parts = MEASURED_ACROSS, []
    if cell_length > 1.05 * MEASURED_LENGTH or cell_length < MEASURED_LENGTH / 1.05:
        parts.append(f"{cell_length:.3g} m long (measured: {MEASURED_LENGTH:g} m)")
    if across[0] < least or across[1] > most:
        parts.append(f"{across[0]:.3g} to {across[1]:.3g} m across (measured: {least:g} to {most:g} m)")
    return f", extrapolated to cells {', '.join(parts)}" if parts else ""


def texture_length(off_wind: Floats, sea_state: float) -> Floats:
    """Range [m] over which the texture of a fully developed sea decorrelates (to 1/e).

    off_wind: as in `wind_factor` [rad]. (pi/2) (W^2/g) sqrt(3 cos^2 phi + 1), W the wind (Watts, IEE Proc. RSN 143, 1996).
    """
    wind = wind_speed(sea_state)
    return np.asarray(np.pi / 2.0 * wind**2 / GRAVITY * np.sqrt(3.0 * np.cos(off_wind) ** 2 + 1.0))


def peak_wave_speed(sea_state: float) -> float:
    """Phase speed [m/s] of the peak waves of a fully developed sea, W / 0.877 (Pierson and Moskowitz 1964)."""
    return wind_speed(sea_state) / 0.877


def peak_wave_period(sea_state: float) -> float:
    """Period [s] of the peak waves, 2 pi c / g in deep water; texture lasts seconds (Ward, Baker and Watts 1990)."""
    return 2.0 * np.pi * peak_wave_speed(sea_state) / GRAVITY
