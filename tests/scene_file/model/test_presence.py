"""Tests of radar_service.scene_file.model.presence: schedules of fading."""

import pytest
from pydantic import ValidationError

from radar_service.scene_file.model.presence import FadingModel


@pytest.mark.parametrize(("present", "of"), [(5, 10), (1, 7), (3, 4), (4, 4), (6, 9)])
def test_a_schedule_has_as_many_units_with_the_body_as_it_says_and_begins_with_one(present: int, of: int) -> None:
    for spread in (False, True):
        pattern = FadingModel(present=present, of=of, spread=spread).pattern()
        assert len(pattern) == of and sum(pattern) == present and pattern[0]


def test_spread_units_are_as_far_apart_as_they_can_be() -> None:
    pattern = FadingModel(present=3, of=10, spread=True).pattern()
    gaps = [unit for unit, there in enumerate(pattern + pattern) if there]
    assert {b - a for a, b in zip(gaps, gaps[1:], strict=False)} == {3, 4}
    assert FadingModel(present=3, of=10).pattern() == [True] * 3 + [False] * 7


def test_more_units_than_there_are_is_refused() -> None:
    with pytest.raises(ValidationError, match="present: 11 units are more than of = 10"):
        FadingModel(present=11, of=10)
