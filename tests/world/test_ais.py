"""When a transponder is off."""

import pytest

from tests.ports.ais.test_messages import ship


@pytest.mark.parametrize(("time", "silent"), [(0.9, False), (1.0, True), (2.4, True), (2.5, False), (7.0, True)])
def test_it_is_off_from_the_beginning_of_a_period_to_its_end(time: float, silent: bool) -> None:
    assert ship(silent=((1.0, 2.5), (6.0, 8.0))).is_silent(time) == silent
    assert not ship().is_silent(time)
