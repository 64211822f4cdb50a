"""Units of ranges in pictures: text and the distance of range rings, by the rules of the page (clients/web/units.js)."""

from argparse import ArgumentParser
from math import ceil, floor, log2, log10
from typing import Final, Literal, NamedTuple

from radar_service.numerics import NAUTICAL_MILE

Unit = Literal["nm", "m"]
DEFAULT_UNIT: Unit = "nm"
MAX_RINGS = 6
SLACK = 1 - 1e-3  # the last cell ends up to one cell before a round range: 4999.3 m is a picture of 5 km


class _Scale(NamedTuple):
    metres: float  # of the unit
    name: str


UNITS: Final[dict[Unit, _Scale]] = {"nm": _Scale(NAUTICAL_MILE, "NM"), "m": _Scale(1.0, "m")}


def range_text(distance: float, unit: Unit = DEFAULT_UNIT) -> str:
    """Returns a range [m] as text: nautical miles, or metres and from 10 km on kilometres."""
    if unit == "nm":
        return f"{_short(distance / NAUTICAL_MILE, 3 if distance < NAUTICAL_MILE / 2 else 2)} NM"
    if distance >= 10_000.0:
        return f"{_short(distance / 1000.0, 2)} km"
    return f"{_short(distance, 1 if distance < 100.0 else 0)} m"


def ring_step(range_max: float, unit: Unit = DEFAULT_UNIT) -> float:
    """Returns the distance between range rings [m], a round number of the unit that gives at most six of them.

    Nautical miles are halved and doubled, metres are 1, 2 or 5 x 10^k.
    """
    metres = UNITS[unit].metres
    minimum = range_max / metres / MAX_RINGS * SLACK
    if unit == "nm":
        return float(2.0 ** ceil(log2(minimum)) * metres)
    decade = 10.0 ** floor(log10(minimum))
    return next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * decade >= minimum) * decade * metres


def add_unit(parser: ArgumentParser, what: str) -> None:
    """Adds the option `--unit`. what: that has ranges in it, for the help."""
    parser.add_argument(
        "--unit", choices=list(UNITS), default=DEFAULT_UNIT,
        help=f"of ranges and rings of {what}: nm, nautical miles as on the page (default), or m, metres",
    )  # fmt: skip


def _short(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{value:.0f}"
