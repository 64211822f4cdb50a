"""Points by closed form, and the scenes of points that studies drive. The twin shares no code with the engine.

A chirp against its windowed copy is, over the time both last, a sum of complex exponentials: its integral needs neither
sampling nor transforms, and errs only by rounding (-280 dB).
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
    """A point body, by default as high as the antenna."""
    return {"name": "point", "shape": "point", "position_m": [east, north, up], "rcs_dbsm": rcs_dbsm, **more}


def scene_of(*bodies: dict[str, Any], radar: dict[str, Any] | None = None, **sections: Any) -> Scene:
    """A scene of bodies, each named by its place; radar: settings of the scene file beside the small ones of studies."""
    named = [{**body, "name": f"body {k}"} for k, body in enumerate(bodies)]
    return load_scene({"name": "study", "body": named, "radar": {**SMALL, **(radar or {})}, **sections})


def pulse_response(delay: Floats, bandwidth: float, pulse: float, window: str) -> Complexes:
    """Compressed pulse of a unit echo `delay` [s] after its peak, any shape: the integral of s(t) conj(w s)(t - delay).

    s(t) s*(t - d) = exp(j pi K (2 t d - d^2)), K = B/T (Klauder and others 1960), over |t| and |t - d| up to T/2.
    """
    slope = bandwidth / pulse
    middle, length = delay / 2.0, np.maximum(pulse - np.abs(delay), 0.0)
    total = np.zeros(np.shape(delay), dtype=np.complex128)
    for m, a in enumerate(WINDOWS[window]):
        for sign in (-1.0, 1.0):
            rate = slope * delay + sign * m / pulse  # cycles per second within the overlap
            turn = slope * delay * middle - slope * delay**2 / 2.0 + sign * m / pulse * (middle - delay)
            total += 0.5 * a * np.exp(2j * np.pi * turn) * np.sinc(rate * length) * length
    return total / (WINDOWS[window][0] * pulse)


def level(radar: Radar, distance: Floats | float, rcs: float) -> Floats:
    """Root [sqrt(W)] of the power that a point of `rcs` [m^2] at `distance` [m] sends back on boresight."""
    power = radar.power * radar.gain**2 * radar.wavelength**2 * rcs / ((4 * np.pi) ** 3 * np.asarray(distance) ** 4)
    return np.asarray(np.sqrt(power))


def point_fields(scene: Scene, time: Floats, azimuth: Floats, distance: Floats) -> Complexes:
    """Field (K, N) [sqrt(W)] of a scene of points at azimuths (K,) [rad] of `time` (K,) [s], samples at `distance` (N,)."""
    radar, own = scene.radar, scene.own_ship.pose(time).position
    earth = scene.environment.earth_factor * 6_371_000.0
    total = np.zeros((len(time), len(distance)), dtype=np.complex128)
    for body in scene.bodies:
        assert body.rcs is not None
        away = body.motion.pose(time).position - own
        ground2 = away[:, 0] ** 2 + away[:, 1] ** 2
        up = away[:, 2] - ground2 / (2 * earth) - radar.height
        r = np.sqrt(ground2 + up**2)
        off = np.angle(np.exp(1j * (np.arctan2(away[:, 0], away[:, 1]) - azimuth)))
        beam = np.sinc(0.8858929413789047 * off / radar.beamwidth) ** 2
        beam *= np.sinc(0.8858929413789047 * np.arctan2(up, np.sqrt(ground2)) / radar.beamwidth_el) ** 2
        amplitude = beam * level(radar, r, body.rcs) * np.exp(-4j * np.pi / radar.wavelength * r)
        delay = 2.0 * (distance - r[:, None]) / 299_792_458.0
        total += amplitude[:, None] * pulse_response(delay, radar.bandwidth, radar.pulse, radar.window)
    return total


def error_db(field: NDArray[np.complex64], exact: Complexes) -> float:
    """Energy of the difference over that of the exact field [dB]."""
    ratio = np.sum(np.abs(field - exact) ** 2) / np.sum(np.abs(exact) ** 2)
    return float(10.0 * np.log10(max(float(ratio), 1e-30)))
