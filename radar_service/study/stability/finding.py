"""The finding of one study: the driven parameter, the measured errors, and the boundary where the method fails.

Scenes of points have their field in closed form, which shares no code with the engine.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from radar_service.numerics import Complexes, Floats, Profiles
from radar_service.radar import Radar
from radar_service.scene_file import load_scene
from radar_service.study.compressed_pulse import compressed_chirp
from radar_service.world import Scene

Response = Literal["no failure", "another method", "physical limit", "limited output", "warning", "refusal", "documented"]
RESPONSES: dict[Response, str] = {
    "no failure": "the method did not fail",
    "another method": "the service uses another method",
    "physical limit": "a real radar has the same limit",
    "limited output": "the service limits the output",
    "warning": "the service warns",
    "refusal": "the service refuses the scene",
    "documented": "the plan or the documents state the limit",
}
WAVELENGTH = 299_792_458.0 / 9.41e9  # m, of the default radar
SMALL = {"range_max_m": 600, "pulse_s": 2e-6, "azimuths": 24, "beamwidth_deg": 40}  # every effect, little work


@dataclass(frozen=True)
class Axis:
    """Name of a quantity with its unit, and whether its axis is logarithmic."""

    label: str
    log: bool = False


@dataclass(frozen=True)
class Curve:
    """Values of one method, one for each value of the parameter."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Expected:
    """The boundary of theory or an earlier measurement; None where nothing fails. tolerance: relative; origin: of both."""

    boundary: float | None
    tolerance: float = 0.0
    origin: str = ""


@dataclass(frozen=True)
class Finding:
    """One study.

    name: of the region. method: what fails, or was driven without failure. setup: what is computed. parameter, values: what is
    driven. measured: the quantity of the curves, one for each method. limit: the value of a curve that counts as failure.
    boundary: of the parameter, where the method passes the limit, or None; expected: the one that the tests demand.
    response, instead, details: what the service does, by its kind, in a few words and in sentences."""

    name: str
    method: str
    setup: str
    parameter: Axis
    values: tuple[float, ...]
    measured: Axis
    curves: tuple[Curve, ...]
    limit: float
    limit_reason: str
    boundary: float | None
    expected: Expected
    response: Response
    instead: str
    details: str

    def __post_init__(self) -> None:
        assert all(len(curve.values) == len(self.values) for curve in self.curves), self.name
        assert np.isfinite([value for curve in self.curves for value in curve.values]).all(), self.name

    def curve(self, name: str) -> Floats:
        """Returns the values of the curve of that name. Raises KeyError for any other name."""
        return np.array({curve.name: curve.values for curve in self.curves}[name])


Study = Callable[[int], Finding]  # from the refinement of the parameter's values to the finding


def curve(name: str, values: Floats | Sequence[float]) -> Curve:
    """Returns a curve of plain numbers."""
    return Curve(name, plain(values))


def plain(values: Floats | Sequence[float]) -> tuple[float, ...]:
    """Returns values as plain numbers."""
    return tuple(float(value) for value in values)


def decades(low: float, high: float, steps: int) -> Floats:
    """Returns values from low to high, both included, `steps` to a decade."""
    return np.geomspace(low, high, round(np.log10(high / low) * steps) + 1)


def decibels(power: Floats | float, floor: float = 1e-30) -> Floats:
    """Returns 10 log10 of power ratios; ratios below `floor` count as `floor`, so that zero can be drawn."""
    return np.asarray(10.0 * np.log10(np.maximum(power, floor)))


def crossing(parameter: Floats, values: Floats, limit: float, log: bool = False) -> float | None:
    """Returns where values first exceed `limit`, by linear interpolation in the parameter, or its logarithm with `log`.

    Returns the first parameter if the values begin above the limit, and None if they never exceed it.
    """
    above = np.flatnonzero(values > limit)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return float(parameter[0])
    x = np.log(parameter) if log else np.asarray(parameter, dtype=np.float64)
    share = (limit - values[k - 1]) / (values[k] - values[k - 1])
    crossed = x[k - 1] + share * (x[k] - x[k - 1])
    return float(np.exp(crossed) if log else crossed)


def bisect(fails: Callable[[float], bool], good: float, bad: float, steps: int = 40) -> float:
    """Returns the limit between `good` and `bad` where a method begins to fail, by halving their logarithmic distance."""
    for _ in range(steps):
        middle = float(np.sqrt(good * bad))
        good, bad = (good, middle) if fails(middle) else (middle, bad)
    return float(np.sqrt(good * bad))


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
