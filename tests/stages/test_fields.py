"""Types of values in a scene file."""

from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from radar_service.numerics.constants import MAX_COORDINATE
from radar_service.stages.fields import MAX_HEIGHT, MIN_HEIGHT, EastNorthUp, Number


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
