"""Values of the stream: own ship from spokes, with what is not known left out, and radars that go."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.display.video import Controls
from radar_service.ports.signalk.subscriptions import SELF, Path
from radar_service.ports.signalk.values import OwnShipSink, Values, own_ship_values
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import FakeEngine, scene


def test_own_ship_is_that_of_the_last_spoke() -> None:
    block = replace(
        FakeEngine(scene()).block(0, 3),
        heading=np.array([0.0, 0.0, -0.5]), course=np.array([0.0, 0.0, 7.0]), speed=np.array([0.0, 0.0, 5.0]),
    )  # fmt: skip
    values = own_ship_values(block, None)
    assert {path[1]: value for path, value in values.items()} == {
        "navigation.headingTrue": pytest.approx(2 * math.pi - 0.5, rel=1e-15),
        "navigation.courseOverGroundTrue": pytest.approx(7.0 - 2 * math.pi, rel=1e-14),
        "navigation.speedOverGround": 5.0,
    }


def test_what_is_not_known_is_left_out() -> None:
    lost = np.full(2, np.nan)
    block = replace(FakeEngine(scene()).block(0, 2), heading=lost, course=lost)
    assert {path[1] for path in own_ship_values(block, None)} == {"navigation.speedOverGround"}


def test_positions_are_on_the_earth() -> None:
    """A nautical mile of 1852 m is a minute of latitude: on WGS 84 at 45 degrees one of 1852.2 m."""
    block = replace(FakeEngine(scene()).block(0, 1), position=np.array([[0.0, 1852.0]]))
    position = own_ship_values(block, (45.0, -10.0))[SELF, "navigation.position"]
    assert position["latitude"] == pytest.approx(45.0 + 1 / 60, abs=0.5 / 60 / 1852) and position["longitude"] == -10.0


def test_own_ship_is_told_ten_times_a_second() -> None:
    told: list[Mapping[Path, Any]] = []
    sink, engine = OwnShipSink(told.append), FakeEngine(scene())
    epoch = Epoch("e", engine, None)
    sink.open_epoch(RadarInfo.unnamed(epoch))
    times = np.arange(0.0, 1.0, 0.03)
    for number, time in enumerate(times):
        block = replace(engine.block(number % 24, 1), time=np.array([time]))
        sink.send(SpokeBatch(epoch, number, block, Controls()))
    assert 8 <= len(told) <= 10  # spokes come each 0.03 s: each fourth one is 0.1 s after the last that was told
    sink.open_epoch(RadarInfo.unnamed(epoch))  # another scene begins at time 0
    sink.send(SpokeBatch(epoch, 0, engine.block(0, 1), Controls()))
    assert len(told) in (9, 10, 11)


def test_equal_values_are_told_once() -> None:
    changed: list[Path] = []
    values = Values(changed.append)
    path = (SELF, "navigation.headingTrue")
    for value in (1.0, 1.0, 2.0):
        values.put({path: value})
    assert changed == [path, path] and values[path] == 2.0 and path in values and values.paths == [path]
