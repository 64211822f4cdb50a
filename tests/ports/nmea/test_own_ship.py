"""Own ship as its sensors report it at one instant."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from radar_service.ports.nmea.own_ship import (
    delayed_times,
    fast_sentences,
    readings_of,
    report,
    slow_sentences,
    spoke_before,
)
from radar_service.records.truth import ShipStates
from radar_service.world.outline import outline_of
from tests.service.fake import scene

SCENE = outline_of(scene())
START = datetime(2028, 2, 28, 23, 59, 59, tzinfo=UTC)
STATES = ShipStates(
    np.array([0.0, 1.0]), np.zeros((2, 3)), np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]), np.array([0.5, 0.0]), np.zeros(2),
    np.ones(2, dtype=np.bool_),
)  # fmt: skip


def test_a_leap_day_begins() -> None:
    made = report(START, STATES, 1, replace(SCENE, origin=(0.0, 0.0)), readings_of(STATES).part(slice(1, 2)), (0.0, 0.0))
    assert (made.utc.month, made.utc.day, made.position) == (2, 29, (0.0, 0.0))


def test_components_are_from_the_bow() -> None:
    """5 m/s to the north-east by east, the bow at north; the log shows 10 m/s."""
    true = readings_of(STATES).part(slice(1, 2))
    assert true.course[0] == pytest.approx(math.atan2(3.0, 4.0), rel=1e-15)
    streaming = replace(SCENE, origin=None, stream=(3.0, 0.0))
    made = report(START, STATES, 1, streaming, true._replace(speed=true.speed + 5.0), (0.0, 0.0))
    assert made.ground == pytest.approx((8.0, 6.0), rel=1e-12)
    assert made.water == pytest.approx((9.0, 0.0), abs=1e-12)
    assert made.position is None and len(slow_sentences(made)) == 5 and len(fast_sentences(made)) == 2


def test_the_course_of_who_stands_is_its_heading() -> None:
    assert readings_of(STATES).course[0] == 0.5


def test_a_sensor_with_latency_tells_of_an_earlier_spoke() -> None:
    radar = scene().radar  # 24 spokes in 2.5 s
    assert spoke_before(radar, 2.5).tolist() == [24] and spoke_before(radar, 2.49).tolist() == [23]
    assert delayed_times(radar, 2.5, 1.25).tolist() == [1.25] and delayed_times(radar, 0.3, 9.0).tolist() == [0.0]
