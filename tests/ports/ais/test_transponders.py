"""Reports of transponders before they are encoded: whose, when, and equal to the truth of their second."""

from typing import Any

import numpy as np
import pytest

from radar_service.ports.ais.transponders import AisReport, Transponders
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.station import Station
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


def test_a_ship_at_anchor_reports_each_three_minutes_and_a_buoy_never() -> None:
    reports = heard(station(), 400.0)
    assert {each.ship.mmsi for _, each in reports} == {211000001, 211000002}
    times = [time for time, each in reports if each.ship.mmsi == 211000002 and each.position]
    assert len(times) in (2, 3) and np.diff(times) == pytest.approx(180.0, abs=1e-6)


def test_what_was_sent_is_not_sent_again_while_time_stands_a_rounding_before_a_tenth() -> None:
    """A spoke's time is a sum: 57.5 s may be a hair less."""
    of, transponders = station(), Transponders()
    assert heard(of, 57.0, transponders)
    transponders.due(of, time := np.nextafter(57.5, 0.0))
    assert [transponders.due(of, time) for _ in range(3)] == [[], [], []]
