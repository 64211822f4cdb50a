"""The first panel: the field of each method of the signal chain, from the same echoes, against the closed form."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from radar_service.echo import Echoes
from radar_service.numerics import CHART, Complexes, Indices, Profiles, generator, wrap_angle
from radar_service.radar import Radar
from radar_service.study.chart.point import Point, time_interleaved
from radar_service.study.chart.reference_surface import closed_form_field
from radar_service.study.chart.signal_chain import BLOCK, Method

FLOOR_DB = -150.0  # the resolution of complex64


@dataclass(frozen=True)
class Workload:
    """The input of all methods.

    echoes: of the scene, for the times;
    subset: some of them at equal strength, so that each counts, for the errors over the whole scan;
    timed: spokes (K,) on which methods without a scan-wide grid are timed.
    """

    radar: Radar
    echoes: Echoes
    subset: Echoes
    timed: Indices

    @property
    def scan(self) -> Indices:
        """All spokes of a scan."""
        return np.arange(self.radar.azimuths)


def workload_of(radar: Radar, echoes: Echoes, keep: int, blocks: int, seed: int) -> Workload:
    """Returns a workload with a random subset of `keep` echoes and `blocks` blocks of spokes that see some of them."""
    count = len(echoes.range)
    chosen = np.sort(generator(seed, CHART, 0).permutation(count)[:keep])
    unit = np.exp(1j * np.angle(echoes.amplitude[chosen]))
    subset = Echoes(echoes.range[chosen], echoes.azimuth[chosen], unit * np.sqrt(np.mean(np.abs(echoes.amplitude) ** 2)))
    block = np.rint(subset.azimuth % (2 * np.pi) / radar.azimuth_step).astype(np.int64) % radar.azimuths // BLOCK
    occupied = np.unique(block)
    some = occupied[np.unique(np.linspace(0, len(occupied) - 1, blocks).astype(np.int64))]
    timed = [np.arange(b * BLOCK, min((b + 1) * BLOCK, radar.azimuths)) for b in some]
    return Workload(radar, echoes, subset, np.concatenate(timed))


def field_points(workload: Workload, methods: Sequence[Method], repeats: int, budget: float = np.inf) -> list[Point]:
    """Returns one point for each method. Methods with a scan-wide grid are timed on the whole scan with all echoes, others on
    some spokes, scaled to the mean azimuth, and slow ones on the subset of the echoes.

    budget: CPU time [s] after which times are not repeated."""
    errors, times = _errors(workload, methods), _times(workload, methods, repeats, budget)
    return [
        Point("field", m.family, m.setting, t, m.slow, error, preset=m.preset)
        for m, t, error in zip(methods, times, errors, strict=True)
    ]


def _errors(workload: Workload, methods: Sequence[Method]) -> list[float]:
    """Returns the field error [dB] of each method; methods with the same sample ranges share one reference."""
    boresight = np.asarray(workload.scan * workload.radar.azimuth_step, dtype=np.float64)
    sampling = [(m.radar.sample_rate, m.first) for m in methods]
    errors = [0.0] * len(methods)
    for key in dict.fromkeys(sampling):
        alike = [k for k, other in enumerate(sampling) if other == key]
        sample_range = methods[alike[0]].sample_range
        reference = closed_form_field(workload.subset, workload.radar, boresight, sample_range)
        for k in alike:
            errors[k] = relative_db(methods[k].run(workload.subset, workload.scan), reference)
    return errors


def _times(workload: Workload, methods: Sequence[Method], repeats: int, budget: float) -> list[tuple[float, ...]]:
    """Returns the CPU times per azimuth [s] of each method, one for each repeat."""
    every, none = workload.scan, Echoes(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.complex128))

    def task(method: Method, given: Echoes) -> Callable[[], object]:
        return partial(method.run, given, every if method.reach is None else workload.timed)

    busy = [task(m, workload.subset if m.slow else workload.echoes) for m in methods]
    idle = [task(m, none) for m in methods if m.reach is not None]
    measured = time_interleaved([*busy, *idle], [repeats] * (len(busy) + len(idle)), "field panel", budget)
    idle_times = iter(measured[len(busy) :])
    return [
        tuple(t / len(every) for t in times) if m.reach is None else _extrapolated(workload, m, times, min(next(idle_times)))
        for m, times in zip(methods, measured, strict=False)
    ]


def _extrapolated(workload: Workload, method: Method, times: Sequence[float], idle: float) -> tuple[float, ...]:
    """Returns the times [s] at the mean azimuth with all echoes: the time without echoes, and that of each echo in reach."""
    reach, given = method.reach or 0.0, workload.subset if method.slow else workload.echoes
    boresight = workload.timed * workload.radar.azimuth_step
    measured = sum(int(np.sum(np.abs(wrap_angle(b - given.azimuth)) <= reach)) for b in boresight)
    mean = len(workload.echoes.range) * min(1.0, reach / np.pi)
    return tuple(idle / len(workload.timed) + max(t - idle, 0.0) / max(measured, 1) * mean for t in times)


def relative_db(field: Profiles, reference: Complexes) -> float:
    """Returns the energy of the difference over that of the reference [dB], at least FLOOR_DB."""
    share = np.sum(np.abs(field - reference) ** 2) / np.sum(np.abs(reference) ** 2)
    return max(FLOOR_DB, float(10.0 * np.log10(max(share, 1e-300))))
