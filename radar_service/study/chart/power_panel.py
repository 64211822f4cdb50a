"""The second panel: mean power of targets as each sampler finds it, how far one draw strays, and how often it misses."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from radar_service.constants import SPEED_OF_LIGHT
from radar_service.frames import polar_from_map, wrap_angle
from radar_service.propagation.radar_equation import Echoes
from radar_service.scene.body import Body
from radar_service.scene.world import Scene
from radar_service.study.chart.point import Point, in_turns
from radar_service.study.chart.samplers import Sampler
from radar_service.study.chart.still import is_diffuse
from radar_service.study.chart.surface_twin import Window

Floats = NDArray[np.float64]
DEPTH = 20  # range bins of a piece of an extended surface; it is a beamwidth wide
LOUD = 1e-3  # of the loudest piece: fainter ones are no targets


def windows_of(scene: Scene, pilot: Echoes, most: int) -> list[Window]:
    """Up to `most` targets of a stopped scene: its compact diffuse bodies, each whole, then pieces of its extended surfaces
    evenly from near to far, among those that `pilot` echoes say are loud."""
    compact = [window for body in scene.bodies if (window := _whole(scene, body)) is not None][: max(1, most // 2)]
    free = np.ones(len(pilot.range), dtype=np.bool_)
    for window in compact:
        free &= ~window.holds(pilot.azimuth, pilot.range)
    radar = scene.radar
    depth, wide = DEPTH * radar.range_step, 2.0 * np.pi / np.ceil(2.0 * np.pi / radar.beamwidth)
    free &= (pilot.range < radar.range_max) & (pilot.range > max(radar.range_min, depth))
    if not free.any() or len(compact) >= most:
        return compact
    across = np.floor(pilot.azimuth[free] % (2.0 * np.pi) / wide).astype(np.int64)
    out = np.floor(pilot.range[free] / depth).astype(np.int64)
    piece, index = np.unique(np.stack([out, across], axis=1), axis=0, return_inverse=True)
    power = np.bincount(index.ravel(), np.abs(pilot.amplitude[free]) ** 2)
    loud = piece[power * (piece[:, 0] + 0.5) ** 4 > LOUD * (power * (piece[:, 0] + 0.5) ** 4).max()]
    chosen = loud[np.unique(np.linspace(0, len(loud) - 1, most - len(compact)).astype(np.int64))]
    return compact + [Window(float(a * wide), float(wide), float(o * depth), float((o + 1) * depth)) for o, a in chosen]


def _whole(scene: Scene, body: Body) -> Window | None:
    """The window round a body that is smaller than a beamwidth and than DEPTH bins, or None."""
    if not is_diffuse(body) or body.mesh is None:
        return None
    radar, pose = scene.radar, body.motion.pose(0.0)
    polar = polar_from_map(pose.position[0], scene.antenna(0.0)[0], scene.environment.earth_factor * 6_371_000.0)
    size = float(np.linalg.norm(body.mesh.vertices, axis=1).max()) + SPEED_OF_LIGHT * 1e-9
    if 2.0 * size > min(radar.beamwidth * float(polar.range), DEPTH * radar.range_step):
        return None
    half = size / float(polar.distance)
    start = float(polar.azimuth) - half
    return Window(float(wrap_angle(np.array(start))), 2.0 * half, float(polar.range) - size, float(polar.range) + size)


def power_points(
    samplers: Sequence[Sampler], truth: Floats, most: int, seed: int, done: Callable[[], object], budget: float = np.inf
) -> list[Point]:
    """Every sampler as a point, from up to `most` draws of each, as far as a CPU time of `budget` [s] goes for all.
    truth: mean power (T,) [W] of each target."""
    found: list[list[Floats]] = [[] for _ in samplers]

    def work(k: int) -> Callable[[], object]:
        return lambda: found[k].append(samplers[k].draw(seed + len(found[k])))

    draws = [min(most, s.draws) for s in samplers]
    times = in_turns([work(k) for k in range(len(samplers))], draws, done, budget)
    return [
        Point(
            "power", s.family, s.setting, tuple(t / s.azimuths for t in each), False, *judged(np.stack(f), truth), s.preset
        )
        for s, each, f in zip(samplers, times, found, strict=True)
    ]


def judged(found: Floats, truth: Floats) -> tuple[float | None, float | None, float]:
    """Of draws (S, T) against true powers (T,), or (S, T) where each draw has its own: error of the mean [dB] (root mean
    square over the targets), spread of one draw [dB] (one standard deviation of its error above the mean; the same), and
    share of draws that missed their target.

    Targets that no draw met have no error and no spread; where that is all of them, there is None.
    """
    mean, wanted = found.mean(axis=0), np.broadcast_to(truth, found.shape)
    met = mean > 0.0
    missed = float(np.mean(found == 0.0))
    if not met.any():
        return None, None, missed
    error = 10.0 * np.log10(mean[met] / wanted.mean(axis=0)[met])
    spread = 10.0 * np.log10(1.0 + (found - wanted)[:, met].std(axis=0, ddof=1) / mean[met])
    return float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(spread**2))), missed
