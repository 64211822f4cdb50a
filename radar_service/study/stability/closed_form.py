"""Fields of points in closed form, and the scenes of points of the studies. The closed form shares no code with the engine.

The correlation of a chirp with its windowed copy is an integral of complex exponentials. It needs neither samples nor
transforms, and its error is that of rounding (-280 dB).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.radar.parameters import Radar
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
WINDOWS = {
    "none": (1.0,),
    "hamming": (0.54, 0.46),
    "blackman": (0.42, 0.5, 0.08),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),
}
SMALL = {"range_max_m": 600, "pulse_s": 2e-6, "azimuths": 24, "beamwidth_deg": 40}  # every effect, little work


def point(east: float, north: float, rcs_dbsm: float = 10.0, up: float = 15.0, **more: Any) -> dict[str, Any]:
    """Returns a point body of a scene file, by default at the height of the antenna."""
    return {"name": "point", "shape": "point", "position_m": [east, north, up], "rcs_dbsm": rcs_dbsm, **more}


def scene_of(*bodies: dict[str, Any], radar: dict[str, Any] | None = None, **sections: Any) -> Scene:
    """Returns a scene of bodies, named by their order; `radar` changes the small radar of the studies."""
    named = [{**body, "name": f"body {k}"} for k, body in enumerate(bodies)]
    return load_scene({"name": "study", "body": named, "radar": {**SMALL, **(radar or {})}, **sections})


def pulse_response(delay: Floats, bandwidth: float, pulse: float, window: str) -> Complexes:
    """Returns the compressed unit echo `delay` [s] after its peak, any shape: the integral of s(t) conj(w s)(t - delay).

    s(t) s*(t - d) = exp(j pi K (2 t d - d^2)), K = B/T (Klauder and others 1960), over |t| and |t - d| up to T/2.
    """
    slope = bandwidth / pulse
    middle, length = delay / 2.0, np.maximum(pulse - np.abs(delay), 0.0)
    total = np.zeros(np.shape(delay), dtype=np.complex128)
    for m, a in enumerate(WINDOWS[window]):
        for sign in (-1.0, 1.0):
            rate = slope * delay + sign * m / pulse  # cycles per second within the overlap
            cycles = slope * delay * middle - slope * delay**2 / 2.0 + sign * m / pulse * (middle - delay)
            total += 0.5 * a * np.exp(2j * np.pi * cycles) * np.sinc(rate * length) * length
    return total / (WINDOWS[window][0] * pulse)


def echo_amplitude(radar: Radar, distance: Floats | float, rcs: float) -> Floats:
    """Returns the amplitude [sqrt(W)] of a point of `rcs` [m^2] at `distance` [m] on boresight."""
    power = radar.power * radar.gain**2 * radar.wavelength**2 * rcs / ((4 * np.pi) ** 3 * np.asarray(distance) ** 4)
    return np.asarray(np.sqrt(power))


def point_fields(scene: Scene, time: Floats, azimuth: Floats, sample_range: Floats) -> Complexes:
    """Returns the field (K, N) [sqrt(W)] of points at times (K,) [s], azimuths (K,) [rad] and sample ranges (N,) [m]."""
    radar, own = scene.radar, scene.own_ship.pose(time).position
    earth = scene.environment.earth_factor * 6_371_000.0
    total = np.zeros((len(time), len(sample_range)), dtype=np.complex128)
    for body in scene.bodies:
        assert body.rcs is not None
        offset = body.motion.pose(time).position - own
        ground2 = offset[:, 0] ** 2 + offset[:, 1] ** 2
        up = offset[:, 2] - ground2 / (2 * earth) - radar.height
        r = np.sqrt(ground2 + up**2)
        bearing_error = np.angle(np.exp(1j * (np.arctan2(offset[:, 0], offset[:, 1]) - azimuth)))
        beam = np.sinc(0.8858929413789047 * bearing_error / radar.beamwidth) ** 2
        beam *= np.sinc(0.8858929413789047 * np.arctan2(up, np.sqrt(ground2)) / radar.beamwidth_el) ** 2
        amplitude = beam * echo_amplitude(radar, r, body.rcs) * np.exp(-4j * np.pi / radar.wavelength * r)
        delay = 2.0 * (sample_range - r[:, None]) / 299_792_458.0
        total += amplitude[:, None] * pulse_response(delay, radar.bandwidth, radar.pulse, radar.window)
    return total


def error_db(field: NDArray[np.complex64], exact: Complexes) -> float:
    """Returns the energy of the difference over that of the exact field [dB]."""
    ratio = np.sum(np.abs(field - exact) ** 2) / np.sum(np.abs(exact) ** 2)
    return float(10.0 * np.log10(max(float(ratio), 1e-30)))
