"""Fields of points in closed form, and the scenes of points of the studies. The closed form shares no code with the engine."""

from typing import Any

import numpy as np

from radar_service.numerics.types import Complexes, Floats, Profiles
from radar_service.radar.parameters import Radar
from radar_service.scene_file.load import load_scene
from radar_service.study.compressed_pulse import compressed_chirp
from radar_service.world.scene import Scene

WAVELENGTH = 299_792_458.0 / 9.41e9  # m, of the default radar
SMALL = {"range_max_m": 600, "pulse_s": 2e-6, "azimuths": 24, "beamwidth_deg": 40}  # every effect, little work


def point(east: float, north: float, rcs_dbsm: float = 10.0, up: float = 15.0, **more: Any) -> dict[str, Any]:
    """Returns a point body of a scene file, by default at the height of the antenna."""
    return {"name": "point", "shape": "point", "position_m": [east, north, up], "rcs_dbsm": rcs_dbsm, **more}


def scene_of(*bodies: dict[str, Any], radar: dict[str, Any] | None = None, **sections: Any) -> Scene:
    """Returns a scene of bodies, named by their order; `radar` changes the small radar of the studies."""
    named = [{**body, "name": f"body {k}"} for k, body in enumerate(bodies)]
    return load_scene({"name": "study", "body": named, "radar": {**SMALL, **(radar or {})}, **sections})


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
        total += amplitude[:, None] * compressed_chirp(delay, radar.bandwidth, radar.pulse, radar.window)
    return total


def error_db(field: Profiles, exact: Complexes) -> float:
    """Returns the energy of the difference over that of the exact field [dB]."""
    ratio = np.sum(np.abs(field - exact) ** 2) / np.sum(np.abs(exact) ** 2)
    return float(10.0 * np.log10(max(float(ratio), 1e-30)))
