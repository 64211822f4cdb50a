"""True readings of earlier spokes, from a memory of bounded size."""

import numpy as np

from radar_service.records.reports import Readings
from radar_service.service.radio.error_stage import ReadingsHistory


def readings(first: int, count: int) -> Readings:
    """Readings whose values tell the number."""
    number = np.arange(first, first + count, dtype=np.float64)
    return Readings(number, number + 0.1, np.stack([number + 0.2, number + 0.3], axis=1), number + 0.4, number + 0.5)


def found(history: ReadingsHistory, *number: int) -> list[float]:
    """The azimuths of spokes; the other columns must belong to them."""
    made = history.readings(np.array(number))
    columns = (made.heading - 0.1, made.position[:, 0] - 0.2, made.position[:, 1] - 0.3, made.course - 0.4, made.speed - 0.5)
    for column in columns:
        np.testing.assert_allclose(column, made.azimuth, atol=1e-12)  # rounding
    return list(made.azimuth)


def test_it_returns_the_readings_of_each_spoke() -> None:
    history = ReadingsHistory(16)
    history.add(0, readings(0, 10))
    history.add(10, readings(10, 10))
    assert found(history, 4, 19, 12) == [4, 19, 12]


def test_what_is_not_kept_is_that_of_the_newest_before_it() -> None:
    history = ReadingsHistory(16)
    history.add(5, readings(5, 5))
    assert found(history, 0, 5, 9, 30) == [5, 5, 9, 9]  # none is before 0
    history.add(12, readings(12, 3))  # 10 and 11 were never sent
    assert found(history, 10, 11, 12, 14, 15) == [9, 9, 12, 14, 14]
    history.add(15, readings(15, 10))
    assert found(history, 2, 13, 24) == [9, 13, 24]  # 9 is the oldest of 16: 9 and 12 to 24
