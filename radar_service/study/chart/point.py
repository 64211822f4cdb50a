"""What the chart is made of: one point per method and setting, its times measured in turns, and who beats whom."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from math import inf
from statistics import median
from typing import Any

LEAST = 2  # repeats, for there to be a spread
RELIABLE = 0.05  # share of looks that a sampler on the front may miss


@dataclass(frozen=True)
class Point:
    """One method at one setting.

    panel: "field" (signal chain, fed the same echoes), "power" (samplers) or "scattering" (models), whose errors are never
    compared; times: CPU seconds per azimuth, one a repeat; scaled: whether they were carried over from a thinned list of
    echoes; error_db: field error relative to the reference, or error of the mean target power (None where no target was
    ever met); spread_db and missed: of the other panels, spread of one draw and share of targets missed by one; preset:
    that works like this.
    """

    panel: str
    family: str
    setting: str
    times: tuple[float, ...]
    scaled: bool
    error_db: float | None
    spread_db: float | None = None
    missed: float | None = None
    preset: str | None = None

    @property
    def seconds(self) -> float:
        """Time per azimuth [s]: the median of the repeats."""
        return median(self.times)

    @property
    def height(self) -> float | None:
        """What the chart shows, in dB: the field error, or error and spread of the power together (root of squares)."""
        if self.error_db is None or self.spread_db is None:
            return self.error_db
        return float((self.error_db**2 + self.spread_db**2) ** 0.5)

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        derived = {"seconds_per_azimuth": self.seconds, "azimuths_per_second": 1.0 / self.seconds, "charted_db": self.height}
        return asdict(self) | derived


def in_turns(
    works: Sequence[Callable[[], object]], repeats: Sequence[int], done: Callable[[], object], budget: float = inf
) -> list[tuple[float, ...]]:
    """CPU times [s] of each work, so many repeats of each, in turns, so that a busy spell of the machine hits all alike.

    budget: CPU time [s] for all together; a work that has had its share is not repeated, but LEAST times, so that slow ones
    do not keep quick ones from being repeated. `done` is called for every repeat, left out or not.
    """
    times: list[list[float]] = [[] for _ in works]
    share = budget
    for turn in range(max(repeats, default=0)):
        if turn == LEAST:
            share = _share([wanted * median(taken or (0.0,)) for wanted, taken in zip(repeats, times, strict=True)], budget)
        for work, wanted, taken in zip(works, repeats, times, strict=True):
            if turn < wanted:
                if turn < LEAST or sum(taken) < share:
                    begin = time.process_time()
                    work()
                    taken.append(max(time.process_time() - begin, 1e-9))  # a clock may not have ticked
                done()
    return [tuple(each) for each in times]


def _share(needs: Sequence[float], budget: float) -> float:
    """The most that each may have for all together to have `budget`: who needs less leaves the rest to the others."""
    left = budget
    for k, need in enumerate(sorted(needs)):
        if need * (len(needs) - k) >= left:
            return left / (len(needs) - k)
        left -= need
    return inf


def pareto(points: Iterable[Point]) -> list[Point]:
    """Those that no other point beats in both time and error, fastest first; none that misses more than RELIABLE."""
    front: list[Point] = []
    for point in sorted(
        (p for p in points if p.height is not None and (p.missed or 0.0) <= RELIABLE), key=lambda p: (p.seconds, p.height)
    ):
        if not front or (point.height or 0.0) < (front[-1].height or 0.0):
            front.append(point)
    return front
