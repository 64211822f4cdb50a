"""Types of values in a scene file, records in SI units, and what is wrong with several keys together."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import pytest
from pydantic import TypeAdapter, ValidationError

from radar_service.numerics.constants import MAX_COORDINATE
from radar_service.stages.fields import MAX_HEIGHT, MIN_HEIGHT, EastNorthUp, Number, Section, record_of


@pytest.mark.parametrize("value", [True, "12", None])
def test_only_numbers_are_numbers(value: Any) -> None:
    with pytest.raises(ValidationError):
        TypeAdapter(Number).validate_python(value)


def test_positions_end_at_their_limits() -> None:
    position = TypeAdapter(EastNorthUp)
    for limit in ((MAX_COORDINATE, -MAX_COORDINATE, MIN_HEIGHT), (0, 0, MAX_HEIGHT)):
        assert position.validate_python(limit) == limit
    for beyond in ((MAX_COORDINATE + 1, 0, 0), (0, -MAX_COORDINATE - 1, 0), (0, 0, MIN_HEIGHT - 1), (0, 0, MAX_HEIGHT + 1)):
        with pytest.raises(ValidationError):
            position.validate_python(beyond)


class Ferry(Section):
    """Keys with every kind of unit."""

    name: str = "ferry"
    course_deg: float = 90.0
    turn_rate_deg_s: float | None = None
    speed_kn: float = 10.0
    share_percent: float = 5.0
    power_dbm: float = 30.0
    gain_dbi: float = 20.0
    length_m: float = 60.0
    deck_m2: float = 900.0
    sectors_deg: tuple[tuple[float, float], ...] = ((0.0, 180.0),)
    seats: int = 7

    def problems(self) -> Iterator[str]:
        if self.seats > 9:
            yield f"seats: {self.seats} are too many; give 9"
        if self.seats > 8:
            yield "seats: never told"


@dataclass(frozen=True)
class FerryRecord:
    name: str
    course: float
    speed: float
    share: float
    power: float
    gain: float
    length: float
    deck: float
    sectors: tuple[tuple[float, float], ...]
    seats: int
    turn_rate: float | None = 3.0


def test_a_record_has_the_keys_of_its_fields_in_si_units() -> None:
    half = math.pi / 2.0
    assert record_of(FerryRecord, Ferry(), length=1.0) == FerryRecord(
        "ferry", half, 10.0 * 1852.0 / 3600.0, 0.05, 1.0, 100.0, 1.0, 900.0, ((0.0, math.pi),), 7, None
    )


class Wake(NamedTuple):
    speed: float
    width: float


def test_a_field_without_a_key_is_named_with_the_keys_and_the_units() -> None:
    with pytest.raises(TypeError) as told:
        record_of(Wake, Ferry())
    assert str(told.value).startswith(
        "Wake.width: Ferry has no key of this name and a known unit (its keys: name, course_deg, "
    )
    assert str(told.value).endswith(
        "_m, _m2, _s, _per_s, _hz, _w, _db, _dbi, _dbsm, _dbm); rename one, or give width= to record_of"
    )
    assert record_of(Wake, Ferry(), width=2.0).width == 2.0


def test_the_first_problem_is_told() -> None:
    assert Ferry(seats=8).seats == 8
    with pytest.raises(ValidationError, match="seats: 12 are too many; give 9") as refused:
        Ferry(seats=12)
    assert "never" not in str(refused.value)
