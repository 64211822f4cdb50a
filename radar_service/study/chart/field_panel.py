"""The first panel: what each method of the signal chain makes of one list of echoes, against the closed form."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import wrap_angle
from radar_service.propagation.radar_equation import Echoes
from radar_service.radar.parameters import Radar
from radar_service.random import CHART, generator
from radar_service.study.chart.method import TILE, Method
from radar_service.study.chart.point import Point, in_turns
from radar_service.study.chart.twin import twin_field

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
FLOOR_DB = -150.0  # of a field in complex64


@dataclass(frozen=True)
class Task:
    """What all methods are given: the echoes of the scene, a thinned list of them that errors are judged on over the whole
    turn, brought to equal strength so that every one counts, and the spokes (K,) at which those methods are timed that take
    each azimuth for itself."""

    radar: Radar
    echoes: Echoes
    thinned: Echoes
    timed: Indices

    @property
    def turn(self) -> Indices:
        """All spokes of a turn."""
        return np.arange(self.radar.azimuths)


def task_for(radar: Radar, echoes: Echoes, keep: int, tiles: int, seed: int) -> Task:
    """A task that keeps `keep` echoes of all, drawn evenly, and times `tiles` tiles of spokes, evenly among those that
    look at any of them."""
    count = len(echoes.range)
    chosen = np.sort(generator(seed, CHART, 0).permutation(count)[:keep])
    unit = np.exp(1j * np.angle(echoes.amplitude[chosen]))
    thinned = Echoes(echoes.range[chosen], echoes.azimuth[chosen], unit * np.sqrt(np.mean(np.abs(echoes.amplitude) ** 2)))
    tile = np.rint(thinned.azimuth % (2 * np.pi) / radar.azimuth_step).astype(np.int64) % radar.azimuths // TILE
    looking = np.unique(tile)
    some = looking[np.unique(np.linspace(0, len(looking) - 1, tiles).astype(np.int64))]
    timed = [np.arange(t * TILE, min((t + 1) * TILE, radar.azimuths)) for t in some]
    return Task(radar, echoes, thinned, np.concatenate(timed))


def field_points(
    task: Task, methods: Sequence[Method], repeats: int, done: Callable[[], object], budget: float = np.inf
) -> list[Point]:
    """Every method as a point. Whole turns are timed on all echoes. Those that take each azimuth for itself are timed at some
    spokes of the task, and their time for an echo at an azimuth is carried over to the mean azimuth; the slow ones with
    the thinned list (`scaled`). budget: CPU time [s] after which times are not repeated."""
    errors = _errors(task, methods, done)
    times = _times(task, methods, repeats, done, budget)
    return [
        Point("field", m.family, m.setting, t, m.slow, error, preset=m.preset)
        for m, t, error in zip(methods, times, errors, strict=True)
    ]


def _errors(task: Task, methods: Sequence[Method], done: Callable[[], object]) -> list[float]:
    """Field error [dB] of each method; one reference for all that sample at the same places."""
    boresight = np.asarray(task.turn * task.radar.azimuth_step, dtype=np.float64)
    places = [(m.radar.sample_rate, m.first) for m in methods]
    errors = [0.0] * len(methods)
    for place in dict.fromkeys(places):
        alike = [k for k, other in enumerate(places) if other == place]
        reference = twin_field(task.thinned, task.radar, boresight, methods[alike[0]].places)
        for k in alike:
            errors[k] = relative_db(methods[k].run(task.thinned, task.turn), reference)
            done()
    return errors


def turns_of(methods: Sequence[Method], repeats: int) -> int:
    """How often `field_points` calls `done`."""
    return len(methods) + repeats * sum(1 if m.reach is None else 2 for m in methods)


def _times(
    task: Task, methods: Sequence[Method], repeats: int, done: Callable[[], object], budget: float
) -> list[tuple[float, ...]]:
    """CPU seconds per azimuth of each method, one a repeat."""
    every, none = task.turn, Echoes(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.complex128))

    def work(method: Method, given: Echoes) -> Callable[[], object]:
        return partial(method.run, given, every if method.reach is None else task.timed)

    busy = [work(m, task.thinned if m.slow else task.echoes) for m in methods]
    idle = [work(m, none) for m in methods if m.reach is not None]
    measured = in_turns([*busy, *idle], [repeats] * (len(busy) + len(idle)), done, budget)
    idling = iter(measured[len(busy) :])
    return [
        tuple(t / len(every) for t in times) if m.reach is None else _carried_over(task, m, times, min(next(idling)))
        for m, times in zip(methods, measured, strict=False)
    ]


def _carried_over(task: Task, method: Method, times: Sequence[float], idle: float) -> tuple[float, ...]:
    """Seconds at the mean azimuth with all echoes: what none cost, and so much for every echo within reach."""
    reach, given = method.reach or 0.0, task.thinned if method.slow else task.echoes
    middle = task.timed * task.radar.azimuth_step
    met = sum(int(np.sum(np.abs(wrap_angle(m - given.azimuth)) <= reach)) for m in middle)
    usual = len(task.echoes.range) * min(1.0, reach / np.pi)
    return tuple(idle / len(task.timed) + max(t - idle, 0.0) / max(met, 1) * usual for t in times)


def relative_db(field: NDArray[np.complex64], reference: NDArray[np.complex128]) -> float:
    """Energy of the difference over that of the reference [dB], not below what complex64 holds."""
    share = np.sum(np.abs(field - reference) ** 2) / np.sum(np.abs(reference) ** 2)
    return max(FLOOR_DB, float(10.0 * np.log10(max(share, 1e-300))))
