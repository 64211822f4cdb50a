"""How often the best possible tracker misses limits of table 3 of MSC.192(79): draws that share no code with radar and bench.

For a target that keeps its course, the best estimate is a straight line through all its plots, weighted by their errors. Errors
are those of the profile `imo-2004` and of A.823(19), appendix 3, for targets.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

SCAN = 2.5  # s
KNOT, MILE = 1852.0 / 3600.0, 1852.0
RUNS, ALLOWED = 1000, 38  # runs that decide, and misses that they allow
GLINT, RANGE, STEP = 200.0 / 6.0, 20.0, 18.52  # m: of a ship of 200 m, of the pulse, of steps of range
BEAM, GYRO_BIAS, GYRO, BACKLASH, ENCODER, BEARING_STEP = np.radians([0.05, 0.5, 0.12, 0.05, 0.03, 0.2]).tolist()
ROLL, ROLL_PERIOD = np.radians(10.0), 10.0


@dataclass(frozen=True)
class Encounter:
    """A scenario of A.823(19), appendix 2, in its units; own ship steers north. position: of the target, east and north [m]."""

    position: tuple[float, float]
    course_deg: float
    speed_kn: float
    own_kn: float


ENCOUNTERS = {
    1: Encounter((0.0, 9.0 * MILE), 180.0, 10.0, 10.0),
    2: Encounter((-0.5 * MILE, 1.0 * MILE), 45.0, 14.14, 10.0),
    3: Encounter((9.0 * MILE / 2**0.5, 9.0 * MILE / 2**0.5), 237.1, 16.84, 5.0),
    4: Encounter((9.0 * MILE / 2**0.5, 9.0 * MILE / 2**0.5), 307.5, 17.83, 25.0),
}


def errors(encounter: Encounter, minutes: int, draws: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Returns the errors (draws,) of the best estimate so many minutes after the first plot, by the names of the bench."""
    start = encounter.position + rng.uniform(-50.0, 50.0, (draws, 2))
    course = np.radians(encounter.course_deg)
    along = np.array([np.sin(course), np.cos(course)])
    velocity, own = encounter.speed_kn * KNOT * along, np.array([0.0, encounter.own_kn * KNOT])
    relative = velocity - own
    scans = int(60.0 * minutes / SCAN) + 1  # the scan after whose end so many minutes have passed
    time = SCAN * np.arange(scans) + np.zeros((draws, 1))
    for _ in range(3):  # when the beam meets the target in each scan; a step changes it by a thousandth
        at = start[:, None] + time[..., None] * relative
        time = SCAN * (np.arange(scans) + np.arctan2(at[..., 0], at[..., 1]) / (2.0 * np.pi) % 1.0)
    at = start[:, None] + time[..., None] * relative
    plots, heading = _plots(at, time, along, rng)
    line = _fit(plots, time - time[:, -1:], along)
    log = max(0.02 * encounter.own_kn, 0.2) * KNOT * rng.choice([-1.0, 1.0], draws)
    sensed = (own[1] + log)[:, None] * np.stack([np.sin(heading[:, -1]), np.cos(heading[:, -1])], axis=1)
    position, moving, estimate = line[:, :2], line[:, 2:], line[:, 2:] + sensed
    cpa, tcpa = _closest(at[:, -1], np.broadcast_to(relative, at[:, -1].shape))
    cpa_estimate, tcpa_estimate = _closest(position, moving)
    return {
        "relative_course_deg": _angle(moving, relative), "true_course_deg": _angle(estimate, velocity),
        "relative_speed_kn": abs(_length(moving) - _length(relative)) / KNOT,
        "true_speed_kn": abs(_length(estimate) - _length(velocity)) / KNOT,
        "cpa_nm": abs(cpa_estimate - cpa) / MILE, "tcpa_min": abs(tcpa_estimate - tcpa) / 60.0,
        "range_m": abs(_length(position) - _length(at[:, -1])), "bearing_deg": _angle(position, at[:, -1]),
    }  # fmt: skip


def passes(share: float) -> float:
    """Returns the probability that a tracker which misses a limit in a share of runs passes it."""
    return float(binom.cdf(ALLOWED, RUNS, share))


def _plots(at: np.ndarray, time: np.ndarray, along: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Relative plots (draws, scans, 2) as the gyro turns them, and own ship's sensed heading (draws, scans)."""
    shape = at.shape[:2]
    echo = at + GLINT * rng.standard_normal((*shape, 1)) * along
    distance = np.rint((_length(echo) + RANGE * rng.standard_normal(shape)) / STEP) * STEP
    bearing = np.arctan2(echo[..., 0], echo[..., 1])
    heel = ROLL * np.sin(2.0 * np.pi * (time / ROLL_PERIOD + rng.random((shape[0], 1))))
    heading = GYRO_BIAS * rng.choice([-1.0, 1.0], (shape[0], 1)) + GYRO * rng.standard_normal(shape)
    antenna = BACKLASH * np.arcsin(np.sin(2.0 * bearing)) * 2.0 / np.pi + BEARING_STEP * (rng.random(shape) - 0.5)
    antenna += np.hypot(BEAM, ENCODER) * rng.standard_normal(shape)
    turned = bearing - 0.5 * heel**2 * np.sin(bearing) * np.cos(bearing) + heading + antenna
    return distance[..., None] * np.stack([np.sin(turned), np.cos(turned)], axis=-1), heading


def _fit(plots: np.ndarray, time: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Position and velocity (draws, 4) at time 0 of the straight line of least weighted squares."""
    unit = plots / _length(plots)[..., None]
    across = np.stack([unit[..., 1], -unit[..., 0]], axis=-1)
    swing = BEAM**2 + ENCODER**2 + BEARING_STEP**2 / 12.0 + GYRO**2
    spread = (RANGE**2 + STEP**2 / 12.0) * unit[..., :, None] * unit[..., None, :]
    spread = spread + swing * (_length(plots) ** 2)[..., None, None] * across[..., :, None] * across[..., None, :]
    weight = np.linalg.inv(spread + GLINT**2 * np.outer(along, along))
    powers = np.stack([np.ones_like(time), time], axis=-1)
    normal = np.einsum("dka,dkij,dkb->daibj", powers, weight, powers, optimize=True).reshape(-1, 4, 4)
    right = np.einsum("dka,dkij,dkj->dai", powers, weight, plots, optimize=True).reshape(-1, 4, 1)
    return np.linalg.solve(normal, right)[..., 0]


def _closest(position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance [m] and time [s] of the closest approach of each draw (draws, 2)."""
    time = -(position * velocity).sum(axis=1) / (velocity**2).sum(axis=1)
    return _length(position + time[:, None] * velocity), time


def _length(vector: np.ndarray) -> np.ndarray:
    return np.hypot(vector[..., 0], vector[..., 1])


def _angle(estimate: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Angle [degrees] between vectors (draws, 2)."""
    cross = estimate[..., 0] * true[..., 1] - estimate[..., 1] * true[..., 0]
    return np.degrees(abs(np.arctan2(cross, (estimate * true).sum(axis=-1))))
