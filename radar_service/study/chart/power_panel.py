"""The second panel: the mean power of targets by each sampler, the spread of one draw, and the share of missed targets."""

from collections.abc import Callable, Sequence

import numpy as np

from radar_service.echo.echoes import Echoes
from radar_service.numerics.constants import EARTH_RADIUS, SPEED_OF_LIGHT
from radar_service.numerics.frames import polar_from_map, wrap_angle
from radar_service.numerics.types import Floats
from radar_service.study.chart.frozen_scene import is_diffuse
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.reference_surface import Window
from radar_service.study.chart.samplers import Sampler
from radar_service.world.body import Body
from radar_service.world.scene import Scene

DEPTH = 20  # range bins of a patch of an extended surface; it is one beamwidth wide
MIN_STRENGTH = 1e-3  # of the strongest patch, after removal of 1/R^4; weaker ones are no targets


def target_windows(scene: Scene, pilot: Echoes, limit: int) -> list[Window]:
    """Returns windows of up to `limit` targets of a frozen scene.

    First come its compact diffuse bodies, up to half of them; then patches of extended surfaces, evenly from near to far,
    among the strong ones by the `pilot` echoes.
    """
    radar = scene.radar
    compact = [window for body in scene.bodies if (window := _body_window(scene, body)) is not None][: max(1, limit // 2)]
    depth, width = DEPTH * radar.range_step, 2.0 * np.pi / np.ceil(2.0 * np.pi / radar.beamwidth)
    free = (pilot.range < radar.range_max) & (pilot.range > max(radar.range_min, depth))
    for window in compact:
        free &= ~window.contains(pilot.azimuth, pilot.range)
    if not free.any() or len(compact) >= limit:
        return compact
    sector = np.floor(pilot.azimuth[free] % (2.0 * np.pi) / width).astype(np.int64)
    ring = np.floor(pilot.range[free] / depth).astype(np.int64)
    patch, index = np.unique(np.stack([ring, sector], axis=1), axis=0, return_inverse=True)
    strength = np.bincount(index.ravel(), np.abs(pilot.amplitude[free]) ** 2) * (patch[:, 0] + 0.5) ** 4
    strong = patch[strength > MIN_STRENGTH * strength.max()]
    chosen = strong[np.unique(np.linspace(0, len(strong) - 1, limit - len(compact)).astype(np.int64))]
    return compact + [Window(float(s * width), float(width), float(r * depth), float((r + 1) * depth)) for r, s in chosen]


def _body_window(scene: Scene, body: Body) -> Window | None:
    """Returns the window around a diffuse body that is smaller than a beamwidth and than DEPTH bins, or None."""
    if not is_diffuse(body) or body.mesh is None:
        return None
    radar, pose = scene.radar, body.motion.pose(0.0)
    polar = polar_from_map(pose.position[0], scene.antenna(0.0)[0], scene.environment.earth_factor * EARTH_RADIUS)
    size = float(np.linalg.norm(body.mesh.vertices, axis=1).max()) + SPEED_OF_LIGHT * 1e-9
    if 2.0 * size > min(radar.beamwidth * float(polar.range), DEPTH * radar.range_step):
        return None
    half = size / float(polar.distance)
    start = float(polar.azimuth) - half
    return Window(float(wrap_angle(np.array(start))), 2.0 * half, float(polar.range) - size, float(polar.range) + size)


def power_points(
    samplers: Sequence[Sampler], truth: Floats, max_draws: int, seed: int, done: Callable[[], object], budget: float = np.inf
) -> list[Point]:
    """Returns one point for each sampler; `done` is called after each draw.

    truth: mean power (T,) [W] of each target; max_draws: of each sampler; budget: CPU time of all [s].
    """
    results: list[list[Floats]] = [[] for _ in samplers]

    def task(k: int) -> Callable[[], object]:
        return lambda: results[k].append(samplers[k].draw(seed + len(results[k])))

    draws = [min(max_draws, s.draws) for s in samplers]
    times = time_interleaved([task(k) for k in range(len(samplers))], draws, done, budget)
    return [_point(s, t, np.stack(r), truth) for s, t, r in zip(samplers, times, results, strict=True)]


def _point(sampler: Sampler, times: Sequence[float], powers: Floats, truth: Floats) -> Point:
    per_azimuth = tuple(t / sampler.azimuths for t in times)
    return Point(
        "power", sampler.family, sampler.setting, per_azimuth, False, *mean_and_spread(powers, truth), sampler.preset
    )


def mean_and_spread(powers: Floats, truth: Floats) -> tuple[float | None, float | None, float]:
    """Returns the error of the mean [dB], the spread of one draw [dB] and the share of draws that miss their target.

    powers: of each draw and target (S, T) [W]; truth: (T,) [W], or (S, T) where each draw has its own. Error and spread are
    root mean squares over the targets. The spread of a target is one standard deviation of the error over the mean. Targets
    that no draw meets have no error and no spread; if no target is met, both are None.
    """
    mean, expected = powers.mean(axis=0), np.broadcast_to(truth, powers.shape)
    met = mean > 0.0
    missed = float(np.mean(powers == 0.0))
    if not met.any():
        return None, None, missed
    error = 10.0 * np.log10(mean[met] / expected.mean(axis=0)[met])
    spread = 10.0 * np.log10(1.0 + (powers - expected)[:, met].std(axis=0, ddof=1) / mean[met])
    return float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(spread**2))), missed
