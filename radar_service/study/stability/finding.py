"""What a study of one region finds: what was driven where, what came out, and where the method leaves its region."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from radar_service.trace.line_of_sight import Floats

Verdict = Literal["computes right", "falls back", "warns", "refuses", "says so"]
VERDICTS: tuple[Verdict, ...] = ("computes right", "falls back", "warns", "refuses", "says so")


@dataclass(frozen=True)
class Axis:
    """What a number means: its name with its unit, and whether it is drawn by decades."""

    label: str
    log: bool = False


@dataclass(frozen=True)
class Curve:
    """One method's values, one for each driven place."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Finding:
    """One region: `driven` from end to end, what came out of each method, and where the first curve passes `limit`.

    boundary: the driven value where it does, in the unit of the axis; None where no driven value reached the limit.
    verdict, service: what the service does about it, in a word and in a sentence.
    """

    name: str
    method: str
    driven: Axis
    places: tuple[float, ...]
    measured: Axis
    curves: tuple[Curve, ...]
    limit: float
    why: str
    boundary: float | None
    verdict: Verdict
    service: str

    def __post_init__(self) -> None:
        assert all(len(curve.values) == len(self.places) for curve in self.curves), self.name
        assert np.isfinite([value for curve in self.curves for value in curve.values]).all(), self.name

    def curve(self, name: str) -> Floats:
        """The values of the curve of that name. Raises KeyError for any other."""
        return np.array({curve.name: curve.values for curve in self.curves}[name])

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


Study = Callable[[int], Finding]  # how many times finer than the quick run -> what was found


def curve(name: str, values: Floats | Sequence[float]) -> Curve:
    """A curve of plain numbers."""
    return Curve(name, tuple(float(value) for value in values))


def places(values: Floats | Sequence[float]) -> tuple[float, ...]:
    """Driven places as plain numbers."""
    return tuple(float(value) for value in values)


def decades(low: float, high: float, steps: int) -> Floats:
    """From low to high, `steps` to a decade, both ends included."""
    return np.geomspace(low, high, round(np.log10(high / low) * steps) + 1)


def decibels(power: Floats | float, floor: float = 1e-30) -> Floats:
    """10 log10 of power ratios, nothing below `floor`: an exact zero stays drawable."""
    return np.asarray(10.0 * np.log10(np.maximum(power, floor)))


def crossing(driven: Floats, values: Floats, limit: float, log: bool = False) -> float | None:
    """Where values first pass `limit` (upwards) along `driven`, by a straight line between its two places (of the
    logarithm of the place with `log`); the first place where they begin above; None where they never do."""
    above = np.flatnonzero(values > limit)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return float(driven[0])
    x = np.log(driven) if log else np.asarray(driven, dtype=np.float64)
    share = (limit - values[k - 1]) / (values[k] - values[k - 1])
    place = x[k - 1] + share * (x[k] - x[k - 1])
    return float(np.exp(place) if log else place)


def bisected(fails: Callable[[float], bool], good: float, bad: float, steps: int = 40) -> float:
    """Where a method that is right at `good` and fails at `bad` turns, by halving the logarithm between them."""
    for _ in range(steps):
        middle = float(np.sqrt(good * bad))
        good, bad = (good, middle) if fails(middle) else (middle, bad)
    return float(np.sqrt(good * bad))
