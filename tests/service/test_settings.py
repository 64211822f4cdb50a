"""The settings of a radar."""

import math

import pytest

from radar_service.service.settings import Pace


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan])
def test_a_factor_that_is_not_positive_is_refused(factor: float) -> None:
    with pytest.raises(ValueError, match="pace.factor"):
        Pace("run", factor)


def test_a_pace_is_plain_data() -> None:
    assert Pace("pause", math.inf).as_dict() == {"state": "pause", "factor": "max"}
    assert Pace().as_dict() == {"state": "run", "factor": 1.0}
