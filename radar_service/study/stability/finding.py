"""The finding of one study: the driven parameter, the measured errors, and the boundary where the method fails."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from radar_service.numerics.types import Floats

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
    """The boundary that theory or an earlier measurement gives.

    boundary: in the unit of the parameter; None where no failure is expected;
    tolerance: relative;
    origin: of both, in words.
    """

    boundary: float | None
    tolerance: float = 0.0
    origin: str = ""


@dataclass(frozen=True)
class Finding:
    """One study.

    name: of the region;
    method: the method that fails, or that was driven without failure;
    setup: what the study computes;
    parameter, values: the driven quantity and its values, from one end to the other;
    measured: the quantity of the curves;
    curves: one for each compared method;
    limit: the value of a curve that counts as failure;
    limit_reason: why;
    boundary: the value of the parameter where the method passes the limit; None where it does not;
    expected: the boundary that the tests demand;
    response: the kind of what the service does instead;
    instead: the method that the service uses instead, or what else it does, in a few words;
    details: the same in sentences.
    """

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

    def as_dict(self) -> dict[str, Any]:
        """Returns plain data for JSON."""
        return asdict(self)


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
