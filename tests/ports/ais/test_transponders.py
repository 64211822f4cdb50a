"""Reports of transponders before they are encoded: whose, when, and equal to the truth of their second."""

from typing import Any

import numpy as np
import pytest

from radar_service.numerics.constants import KNOT
from radar_service.ports.ais.transponders import AisReport, Transponders
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.station import Station
from radar_service.world.geo import geographic_from_map
from tests.service.fake import RADAR, FakeEngine, factory

ORIGIN = (54.0, 8.0)


def station(**ais: Any) -> Station:
    """A ship of 12 knots to the north and one at anchor, both with a transponder, and a buoy without."""
    ship = {"name": "ship", "shape": "point", "rcs_dbsm": 20, "mmsi": 211000001, "course_deg": 0, "speed_kn": 12}
    moored = {"name": "moored", "shape": "point", "rcs_dbsm": 20, "position_m": [0, 120, 0], "mmsi": 211000002}
    buoy = {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [50, 50, 0]}
    origin = {"latitude_deg": ORIGIN[0], "longitude_deg": ORIGIN[1]}
    of = load_scene({"radar": RADAR, "origin": origin, "body": [ship, moored, buoy], **({"ais": ais} if ais else {})})
    return Station("0", FakeEngine(of), factory())


def heard(of: Station, until: float, transponders: Transponders | None = None) -> list[tuple[float, AisReport]]:
    """The reports of the time from 0 on, tenth by tenth."""
    transponders = transponders or Transponders()
    times = np.arange(0.0, until, 0.1).tolist()
    return [(time, report) for time in times for report in transponders.due(of, time)]


def test_a_ship_under_way_reports_each_ten_seconds_where_it_is_then() -> None:
    """ITU-R M.1371-5, table 1: class A up to 14 knots. The state is that of a whole second, sent within it."""
    reports = [
        (time, each.position) for time, each in heard(station(), 60.0) if each.ship.mmsi == 211000001 and each.position
    ]
    seconds = [position.second for _, position in reports]
    assert len(seconds) == 6 and set(np.diff(seconds) % 60) == {10}
    for time, position in reports:
        east_north = np.array([0.0, 12 * KNOT * np.floor(time)])
        latitude, longitude = geographic_from_map(east_north, ORIGIN)
        assert (position.latitude, position.longitude) == pytest.approx((latitude, longitude), abs=1e-9)
        assert position.speed == pytest.approx(12 * KNOT, rel=1e-12) and position.course == pytest.approx(0.0, abs=1e-12)


def test_a_ship_at_anchor_reports_each_three_minutes_and_a_buoy_never() -> None:
    reports = heard(station(), 400.0)
    assert {each.ship.mmsi for _, each in reports} == {211000001, 211000002}
    times = [time for time, each in reports if each.ship.mmsi == 211000002 and each.position]
    assert len(times) in (2, 3) and np.diff(times) == pytest.approx(180.0, abs=1e-6)


def test_what_is_lost_is_not_told() -> None:
    assert heard(station(loss_percent=100), 400.0) == []


def test_what_was_sent_is_not_sent_again_while_time_stands_a_rounding_before_a_tenth() -> None:
    """A spoke's time is a sum: 57.5 s may be a hair less."""
    of, transponders = station(), Transponders()
    assert heard(of, 57.0, transponders)
    transponders.due(of, time := np.nextafter(57.5, 0.0))
    assert [transponders.due(of, time) for _ in range(3)] == [[], [], []]


def test_another_scene_begins_anew() -> None:
    transponders, of = Transponders(), station()
    first = heard(of, 20.0, transponders)
    assert heard(of, 20.0, transponders) == first  # its time begins at 0 again
