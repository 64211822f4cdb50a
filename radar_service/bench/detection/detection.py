"""Probability of detection of a point target in noise: the radar equation, and the declared law of fluctuation."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.stats import binom, gamma, ncx2

from radar_service.bench.scenario import Scenario
from radar_service.numerics import Floats, effective_earth_radius, known_level_factor
from radar_service.propagation import attenuation, elevation_gain, radar_two_rays, received_amplitude
from radar_service.radar import Radar, horizon
from radar_service.receive import receiver_noise_power
from radar_service.scattering import per_azimuth
from radar_service.world import Environment

SHAPES = {1: 1.0, 2: 1.0, 3: 2.0, 4: 2.0}  # of the gamma distribution of a Swerling case's power
DRAWS = 200  # equally probable powers that stand for a distribution: errs by less than 1e-3
LEVELS_DB = np.arange(-20.0, 50.1, 0.5)  # at which a curve is computed; between them it is interpolated, to 1e-4
PFA = 1e-4  # MSC.192(79) 5.3.1.1
SCANS_NEEDED, OF_SCANS = 8, 10  # the same
CRITERION = 0.8  # Pd per scan: 8 of 10 scans in the mean
FINE = 4000  # ranges of a predicted curve


@dataclass(frozen=True)
class Target:
    """A point target of a study. name; height [m]; rcs_dbsm; swerling; standard_nm: the range of the standard, or None."""

    name: str
    height: float
    rcs_dbsm: float
    swerling: int
    standard_nm: float | None

    @classmethod
    def of(cls, scenario: Scenario, body: Mapping[str, Any]) -> "Target":
        """Returns the target of a point with rcs_dbsm of a scenario, as the scenario's scene has it."""
        height, swerling = float(body["position_m"][2]), int(body.get("swerling", 0))
        return cls(body["name"], height, float(body["rcs_dbsm"]), swerling, scenario.standard_nm.get(body["name"]))


def steady_detection(snr: Floats, pfa: float, pulses: int = 1) -> Floats:
    """Returns the probability that a steady echo and noise together exceed the threshold of `pfa` in one cell of one spoke.

    snr: power ratio of one pulse, any shape. pulses: whose powers are averaged. Marcum's Q of that order (Skolnik 2001, 2.5).
    """
    return np.asarray(ncx2.sf(2.0 * pulses * known_level_factor(pfa, pulses), 2.0 * pulses, 2.0 * pulses * snr))


def drawn_powers(swerling: int) -> Floats:
    """Returns equally probable power factors (Q,) of mean 1 of a Swerling case; (1,) for a steady target."""
    if swerling == 0:
        return np.ones(1)
    shape = SHAPES[swerling]
    return np.asarray(gamma.ppf((np.arange(DRAWS) + 0.5) / DRAWS, shape, scale=1.0 / shape))


def eight_of_ten(pd: Floats) -> Floats:
    """Returns the probability of 8 or more detections in 10 scans; 0.68 for a Pd of 0.8 per scan."""
    return np.asarray(binom.sf(SCANS_NEEDED - 1, OF_SCANS, pd))


@dataclass(frozen=True)
class ScanDetection:
    """How a scan detects a target: where its range cell exceeds the threshold on any of some spokes.

    gain: two-way power gains (K,) of the spokes towards the target. swerling: case of the target. pfa: in one cell of one spoke.
    pulses: averaged in a spoke.
    """

    gain: Floats
    swerling: int
    pfa: float
    pulses: int = 1

    def of(self, snr: Floats) -> Floats:
        """Returns Pd per scan for signal-to-noise ratios on boresight, of any shape."""
        level = 10.0 * np.log10(np.clip(snr, 1e-2, 1e5))
        return np.clip(np.asarray(_curve(tuple(self.gain.tolist()), self.swerling, self.pfa, self.pulses)(level)), 0.0, 1.0)


@lru_cache(64)
def _curve(gain: tuple[float, ...], swerling: int, pfa: float, pulses: int) -> PchipInterpolator:
    """Pd over the level [dB]. Cases 1 and 3 have one draw for all spokes of a scan, 2 and 4 one for each."""
    snr = 10.0 ** (LEVELS_DB / 10.0)
    single = steady_detection(snr[:, None, None] * drawn_powers(swerling)[:, None] * np.array(gain), pfa, pulses)
    if per_azimuth(swerling):
        return PchipInterpolator(LEVELS_DB, 1.0 - np.prod(1.0 - single.mean(axis=1), axis=1))
    return PchipInterpolator(LEVELS_DB, (1.0 - np.prod(1.0 - single, axis=2)).mean(axis=1))


def spoke_gains(radar: Radar) -> Floats:
    """Returns the two-way power gains (K,) of the spokes within the half-power beam about one that points at the target."""
    half = int(radar.beamwidth / 2.0 / radar.azimuth_step)
    return np.asarray(radar.azimuth_gain(np.arange(-half, half + 1, dtype=np.float64) * radar.azimuth_step) ** 2)


def signal_to_noise(radar: Radar, environment: Environment, ground: Floats, target: Target) -> Floats:
    """Returns the signal-to-noise ratio (R,) of a point on boresight of a radar at rest, in the middle of its range cell.

    ground: distances along the earth (R,) [m]. The radar equation, with gas, the elevation pattern and, with multipath, the two
    rays (Skolnik 2001, 1.7; Kerr 1951, ch. 2). 0 beyond the horizon where nothing diffracts. Clutter is left out.
    """
    radius, height = effective_earth_radius(environment.earth_factor), target.height
    z = height - radar.height - ground**2 / (2.0 * radius)
    distance = np.hypot(ground, z)
    amplitude = received_amplitude(radar, distance) * attenuation(radar, environment, distance)
    if environment.multipath:
        rays = radar_two_rays(radar, environment, ground, np.full(len(ground), height), radar.height)
        arrives = rays.arrives
        factor = 1.0 + rays.ratio * np.exp(-2j * np.pi / radar.wavelength * rays.geometry.excess)
        amplitude = amplitude * rays.gain * np.abs(factor) ** 2
    else:
        arrives = ground < horizon(height, radar.height, radius)
        amplitude = amplitude * elevation_gain(radar, np.arctan2(z, ground))
    return np.where(arrives, 10.0 ** (target.rcs_dbsm / 10.0) * amplitude**2 / receiver_noise_power(radar), 0.0)


def ground_distance(slant: Floats, height: float, radar: Radar, environment: Environment) -> Floats:
    """Returns the distances along the earth (R,) [m] of points at slant ranges (R,) [m]; height: above the sea [m]."""
    radius, ground = effective_earth_radius(environment.earth_factor), slant
    for _ in range(8):
        z = height - radar.height - ground**2 / (2.0 * radius)
        ground = np.sqrt(np.maximum(slant**2 - z**2, 0.0))
    return ground


def predicted_curve(radar: Radar, environment: Environment, target: Target) -> tuple[Floats, Floats]:
    """Returns slant ranges (C,) [m], the middles of cells of the radar, and the Pd per scan (C,) of a target in them."""
    cell = np.unique(np.linspace(min(10, radar.bins - 1), radar.bins - 1, FINE).astype(np.int64))
    distance = np.asarray((cell + 0.5) * radar.range_step, dtype=np.float64)
    snr = signal_to_noise(radar, environment, ground_distance(distance, target.height, radar, environment), target)
    return distance, ScanDetection(spoke_gains(radar), target.swerling, PFA, radar.pulses_integrated).of(snr)
