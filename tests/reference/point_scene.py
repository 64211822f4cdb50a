"""Slow reference: the field of a scene of points, every azimuth at its own instant, for any pulse, beam and repetition.

Own arithmetic throughout: nothing of the engine but the scene's motions (which have their own tests) is used. Author: this
project, from the definitions of docs/conventions.md and the radar equation (Skolnik 2001, eq. 1.7).
"""

from collections.abc import Callable
from math import log, pi, sqrt
from typing import Any

import numpy as np
import scipy.signal
from numpy.typing import NDArray
from scipy.special import ndtr

import radar_service as rs
from tests.reference.compressed_pulse import LIGHT, compressed_pulse, rows_of, sinc2_beam
from tests.reference.nonlinear_pulse import correlation, tapered_pulse

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Pulse = Callable[[Floats, Floats], Complexes]  # delay from the peak (A, N) [s], two-way delay of the echo (A, 1) [s]
Polar = Callable[
    [rs.Scene, Any, Floats], tuple[Floats, Floats, Floats]
]  # of a body at times (A,): range, azimuth, elevation


def taylor_sum(sidelobe_db: float, nbar: int) -> tuple[float, ...]:
    """Cosine coefficients of scipy's Taylor window, by least squares over its samples."""
    count = 64
    location = 2.0 * np.pi * (np.arange(count) - (count - 1) / 2.0) / count
    window = scipy.signal.windows.taylor(count, nbar, -sidelobe_db, norm=False)
    fitted = np.linalg.lstsq(np.cos(np.outer(location, np.arange(nbar))), window, rcond=None)[0]
    return tuple(fitted.tolist())


COSINE_SUMS = {
    "none": (1.0,),
    "hamming": (0.54, 0.46),
    "hann": (0.5, 0.5),
    "blackman": (0.42, 0.5, 0.08),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),
    "nuttall": (0.355768, 0.487396, 0.144232, 0.012604),
    "taylor": taylor_sum(-35.0, 5),
}


def chirp_pulse(radar: Any) -> Pulse:
    """The compressed chirp of a radar; of an eclipsing one, what it receives after its own pulse."""

    def pulse(delay: Floats, late: Floats) -> Complexes:
        received_from = radar.pulse / 2 - late if radar.eclipsing else np.full_like(late, -np.inf)
        return compressed_pulse(delay, radar.bandwidth, radar.pulse, COSINE_SUMS[radar.window], received_from)

    return pulse


def other_chirp(radar: Any) -> Pulse:
    """The compressed pulse of a nonlinear chirp or of an inverse filter; not of an eclipsing radar."""
    window = COSINE_SUMS[radar.window]
    whole = None if radar.compression == "inverse" else correlation(radar.bandwidth, radar.pulse, window)

    def pulse(delay: Floats, late: Floats) -> Complexes:
        assert not radar.eclipsing
        if whole is None:
            return tapered_pulse(delay, radar.bandwidth, window)
        near = np.abs(delay) < radar.pulse
        answer = np.zeros(delay.shape, dtype=np.complex128)
        answer[near] = whole(delay[near])
        return answer

    return pulse


def plain_pulse(radar: Any) -> Pulse:
    """A rectangle behind a Gaussian filter with |H|^2 = 1/2 at +-B/2: its impulse response is a normal density of standard
    deviation sqrt(ln 2) / (pi B), so the answer is a difference of two normal distribution functions."""
    spread = sqrt(log(2)) / (pi * radar.bandwidth)
    half = radar.pulse / 2
    peak = float(ndtr(half / spread) - ndtr(-half / spread))

    def pulse(delay: Floats, late: Floats) -> Complexes:
        begin = np.clip(half - late, -half, half) if radar.eclipsing else np.full_like(late, -half)
        answer = np.zeros(delay.shape, dtype=np.complex128)
        near = np.abs(delay) < half + 8 * spread  # beyond, both functions agree to 1e-15
        rise, fall = (delay - begin)[near] / spread, (delay - half)[near] / spread
        if near.any():
            answer[near] = (ndtr(rise) - ndtr(fall)) / peak
        return answer

    return pulse


def polar(made: rs.Scene, body: Any, time: Floats) -> tuple[Floats, Floats, Floats]:
    """Range [m], azimuth and elevation [rad] of a body from the antenna at times (A,) [s]."""
    return polar_of(made, body.motion.pose(time).position - made.own_ship.pose(time).position - (0, 0, made.radar.height))


def polar_of(made: rs.Scene, offset: Floats) -> tuple[Floats, Floats, Floats]:
    """The same of offsets (A, 3) from the antenna [m], over the curved earth."""
    ground = np.hypot(offset[:, 0], offset[:, 1])
    z = offset[:, 2] - ground**2 / (2 * made.environment.earth_factor * 6_371_000.0)
    return np.hypot(ground, z), np.arctan2(offset[:, 0], offset[:, 1]), np.arctan2(z, ground)


def exact_field(
    made: rs.Scene, scan: rs.Scan, beam: Callable[[Floats, float], Floats] = sinc2_beam, every: int = 1,
    polar: Polar = polar,
) -> Complexes:  # fmt: skip
    """Field (A, N) of the points of a scene at every so many azimuths, free space, folded where the radar asks for
    second-time-around echoes."""
    radar, time, boresight = made.radar, scan.time[::every], scan.azimuth[::every]
    linear = chirp_pulse if (radar.modulation, radar.compression) == ("lfm", "matched") else other_chirp
    pulse = plain_pulse(radar) if radar.modulation == "none" else linear(radar)
    field = np.zeros((len(time), len(scan.range)), dtype=np.complex128)
    for body in made.bodies:
        late = 0
        while True:
            sent = time - (0.0 if radar.prf is None else late / radar.prf)
            r, azimuth, elevation = polar(made, body, sent)
            level = _level(radar, body.rcs, r) * beam(elevation - radar.tilt, radar.beamwidth_el)
            interval = np.inf if not radar.second_time_around else LIGHT / (2 * radar.prf)
            belongs = np.floor(r / interval) == late
            apparent = r - (late * interval if late else 0.0)
            if belongs.any():
                arrived = 2.0 * rows_of(apparent)[:, None] / LIGHT
                delay = 2.0 * scan.range[None, :] / LIGHT - arrived
                weight = belongs * level * beam(boresight - azimuth, radar.beamwidth)
                field += (weight * np.exp(-4j * np.pi * r / radar.wavelength))[:, None] * pulse(delay, arrived)
            late += 1
            if (r < late * interval).all():
                break
    return field


def _level(radar: Any, rcs: float, r: Floats) -> Floats:
    power = radar.power * radar.gain**2 * radar.wavelength**2 * rcs / ((4 * np.pi) ** 3 * r**4 * radar.loss)
    return np.asarray(np.sqrt(power))


def error_db(
    made: rs.Scene, scan: rs.Scan, beam: Callable[[Floats, float], Floats] = sinc2_beam, every: int = 1,
    polar: Polar = polar,
) -> float:  # fmt: skip
    """Energy of the difference between a scan and the exact field, over that of the exact field, at every so many azimuths."""
    exact = exact_field(made, scan, beam, every, polar)
    return float(10 * np.log10(np.sum(np.abs(scan.field[::every] - exact) ** 2) / np.sum(np.abs(exact) ** 2)))


def scattered(count: int, nearest: float, farthest: float, seed: int, **motion: Any) -> list[dict[str, Any]]:
    """Points all round, each about as loud as the others, so that every one of them counts in the error."""
    rng = np.random.default_rng(seed)
    bodies = []
    for i in range(count):
        r, azimuth, up = rng.uniform(nearest, farthest), rng.uniform(0, 2 * np.pi), rng.uniform(5, 30)
        location = [r * np.sin(azimuth), r * np.cos(azimuth), up]
        bodies.append(
            {"name": f"p{i}", "shape": "point", "position_m": location, "rcs_dbsm": 40 * np.log10(r / 100), **motion}
        )
    return bodies
