"""Points of the chart, interleaved timing, and the Pareto front."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from math import inf
from statistics import median
from typing import Any

MIN_REPEATS = 2  # a spread needs two
MAX_MISSED = 0.05  # share of targets that a sampler on the Pareto front may miss


@dataclass(frozen=True)
class Point:
    """One method at one setting.

    panel: "field" (signal chain), "power" (samplers), "scattering" (models); errors of two panels are not comparable;
    family, setting: the method and its setting;
    times: CPU time per azimuth of each repeat [s];
    extrapolated: whether the times were measured on a subset of the echoes and scaled up;
    error_db: relative field error, or error of the mean power; None where no draw met a target;
    spread_db: spread of one draw (samplers and models);
    missed: share of targets that one draw misses (samplers and models);
    preset: the preset that works like this, if any.
    """

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


def time_interleaved(
    tasks: Sequence[Callable[[], object]], repeats: Sequence[int], done: Callable[[], object], budget: float = inf
) -> list[tuple[float, ...]]:
    """Returns the CPU times [s] of each task, repeated in turn, so that a busy spell of the machine affects all alike.

    repeats: of each task; budget: CPU time for all together [s]. A task that has used an equal share is repeated MIN_REPEATS
    times only. `done` is called for every repeat, whether it runs or not.
    """
    times: list[list[float]] = [[] for _ in tasks]
    share = budget / max(1, len(tasks))
    for turn in range(max(repeats, default=0)):
        for task, count, taken in zip(tasks, repeats, times, strict=True):
            if turn < count:
                if turn < MIN_REPEATS or sum(taken) < share:
                    begin = time.process_time()
                    task()
                    taken.append(max(time.process_time() - begin, 1e-9))  # the clock may be coarser than the task
                done()
    return [tuple(row) for row in times]


def pareto(points: Iterable[Point]) -> list[Point]:
    """Returns the reliable points that no other beats in both time and error, fastest first."""
    front: list[Point] = []
    reliable = [point for point in points if point.reliable]
    for point in sorted(reliable, key=lambda p: (p.seconds, p.total_error_db)):
        if not front or (point.total_error_db or 0.0) < (front[-1].total_error_db or 0.0):
            front.append(point)
    return front
