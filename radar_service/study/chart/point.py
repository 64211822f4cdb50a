"""Methods that draw at random, points of the chart, interleaved timing, and the Pareto front."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from math import inf
from statistics import median
from typing import Any

import numpy as np

from radar_service.numerics import Floats
from radar_service.terminal import progress

MIN_REPEATS = 2  # a spread needs two
MAX_MISSED = 0.05  # share of targets that a sampler on the Pareto front may miss


@dataclass(frozen=True)
class Point:
    """One method at one setting.

    panel: "field", "power" or "scattering"; errors of two are not comparable. times: CPU time per azimuth of each repeat [s];
    extrapolated: whether from a subset of the echoes. error_db: of the field, or of the mean power; None where no draw met a
    target. spread_db, missed: of one draw, and the share of targets that it misses. preset: the one that works like this."""

    panel: str
    family: str
    setting: str
    times: tuple[float, ...]
    extrapolated: bool
    error_db: float | None
    spread_db: float | None = None
    missed: float | None = None
    preset: str | None = None

    @property
    def seconds(self) -> float:
        """Median CPU time per azimuth [s]."""
        return median(self.times)

    @property
    def total_error_db(self) -> float | None:
        """The error on the chart [dB]: the field error, or the root of the squares of error and spread."""
        if self.error_db is None or self.spread_db is None:
            return self.error_db
        return float((self.error_db**2 + self.spread_db**2) ** 0.5)

    @property
    def reliable(self) -> bool:
        """Whether the method misses at most MAX_MISSED of its targets."""
        return self.total_error_db is not None and (self.missed or 0.0) <= MAX_MISSED

    def as_dict(self) -> dict[str, Any]:
        """Returns plain data for JSON."""
        seconds = self.seconds
        derived = {"seconds_per_azimuth": seconds, "azimuths_per_second": 1.0 / seconds, "charted_db": self.total_error_db}
        return asdict(self) | derived


@dataclass(frozen=True)
class Sampler:
    """One method that draws at random, at one setting.

    family: name of the method;
    setting: the setting, for a reader;
    draw: maps the number of a draw to its powers (T,) [W], or cross-sections (T,) [m^2];
    azimuths: number of azimuths that one draw computes;
    draws: largest number of draws of a chart;
    preset: the preset that uses this setting, if any.
    """

    family: str
    setting: str
    draw: Callable[[int], Floats]
    azimuths: int
    draws: int
    preset: str | None = None


def drawn_points(
    panel: str, samplers: Sequence[Sampler], truth: Floats, max_draws: int, seed: int = 0, budget: float = inf
) -> list[Point]:
    """Returns one point for each sampler.

    truth: what each target (T,) has in the mean, or in each draw (S, T); max_draws: of each sampler; seed: number of the first
    draw; budget: CPU time of all [s].
    """
    results: list[list[Floats]] = [[] for _ in samplers]

    def task(k: int) -> Callable[[], object]:
        return lambda: results[k].append(samplers[k].draw(seed + len(results[k])))

    draws = [min(max_draws, s.draws) for s in samplers]
    times = time_interleaved([task(k) for k in range(len(samplers))], draws, f"{panel} panel", budget)
    points = []
    for s, seconds, drawn in zip(samplers, times, results, strict=True):
        errors, each = mean_and_spread(np.stack(drawn), truth), tuple(t / s.azimuths for t in seconds)
        points.append(Point(panel, s.family, s.setting, each, False, *errors, s.preset))
    return points


def mean_and_spread(powers: Floats, truth: Floats) -> tuple[float | None, float | None, float]:
    """Returns the error of the mean [dB], the spread of one draw [dB] and the share of draws that miss their target.

    powers: of each draw and target (S, T) [W]; truth: (T,) or (S, T) [W]. Error and spread are root mean squares over the targets
    that a draw meets, None where there is none; the spread of a target is a standard deviation of the error over the mean."""
    mean, expected = powers.mean(axis=0), np.broadcast_to(truth, powers.shape)
    met = mean > 0.0
    missed = float(np.mean(powers == 0.0))
    if not met.any():
        return None, None, missed
    error = 10.0 * np.log10(mean[met] / expected.mean(axis=0)[met])
    spread = 10.0 * np.log10(1.0 + (powers - expected)[:, met].std(axis=0, ddof=1) / mean[met])
    return float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(spread**2))), missed


def time_interleaved(
    tasks: Sequence[Callable[[], object]], repeats: Sequence[int], title: str, budget: float = inf
) -> list[tuple[float, ...]]:
    """Returns the CPU times [s] of each task, repeated in turn, so that a busy spell of the machine affects all alike.

    repeats: of each task; title: for lines of progress; budget: CPU time for all together [s]. A task that has used an equal
    share is repeated MIN_REPEATS times only.
    """
    times: list[list[float]] = [[] for _ in tasks]
    share = budget / max(1, len(tasks))
    turns = max(repeats, default=0)
    for turn in progress(range(turns), turns, "repeats", lambda _: title, within=True):
        for task, count, taken in zip(tasks, repeats, times, strict=True):
            if turn < count and (turn < MIN_REPEATS or sum(taken) < share):
                begin = time.process_time()
                task()
                taken.append(max(time.process_time() - begin, 1e-9))  # the clock may be coarser than the task
    return [tuple(row) for row in times]


def pareto(points: Iterable[Point]) -> list[Point]:
    """Returns the reliable points that no other beats in both time and error, fastest first."""
    front: list[Point] = []
    reliable = [point for point in points if point.reliable]
    for point in sorted(reliable, key=lambda p: (p.seconds, p.total_error_db)):
        if not front or (point.total_error_db or 0.0) < (front[-1].total_error_db or 0.0):
            front.append(point)
    return front
