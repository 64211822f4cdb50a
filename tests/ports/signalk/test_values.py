"""Values of the stream: own ship and ships with AIS, with what is not known left out, and values that have not changed."""

from dataclasses import replace
from datetime import UTC, datetime

from radar_service.ports.ais.transponders import AisReport, Position
from radar_service.ports.nmea.own_ship import OwnShipReport
from radar_service.ports.signalk.subscriptions import SELF, Path
from radar_service.ports.signalk.values import Values, own_ship_values, vessel_values
from radar_service.world.reporting import AisShip

OWN = OwnShipReport(datetime(2026, 1, 1, tzinfo=UTC), (54.0, 8.0), 0.5, 0.6, 7.0, 0.0, (7.0, 0.0), (7.0, 0.0))
SHIP = AisShip("ferry", 21_100_0001, "A", "FERRY", "DABC", 60, 0, "", (0.0, 0.0), 40.0, 40.0, 8.0, 8.0, 5.0)
CONTEXT = "vessels.urn:mrn:imo:mmsi:211000001"


def test_own_ship_as_it_is_reported() -> None:
    assert own_ship_values(OWN) == {
        (SELF, "navigation.headingTrue"): 0.5,
        (SELF, "navigation.courseOverGroundTrue"): 0.6,
        (SELF, "navigation.speedOverGround"): 7.0,
        (SELF, "navigation.position"): {"latitude": 54.0, "longitude": 8.0},
    }


def test_what_is_not_known_is_left_out() -> None:
    lost = own_ship_values(replace(OWN, position=None, heading=None, course=None))
    assert lost == {(SELF, "navigation.speedOverGround"): 7.0}


def test_a_ship_with_ais_has_a_context_of_its_own() -> None:
    at = Position(30, 54.1, 8.2, 1.0, 5.0, None, 0.0)
    assert vessel_values(AisReport(SHIP, False, at)) == {
        (CONTEXT, "navigation.courseOverGroundTrue"): 1.0,
        (CONTEXT, "navigation.speedOverGround"): 5.0,
        (CONTEXT, "navigation.position"): {"latitude": 54.1, "longitude": 8.2},
    }
    unknown = vessel_values(AisReport(replace(SHIP, mmsi=99), False, replace(at, latitude=None)))
    assert {context for context, _ in unknown} == {"vessels.urn:mrn:imo:mmsi:000000099"}
    assert not any(path.endswith("position") for _, path in unknown)


def test_an_aid_has_a_name_and_a_position_in_a_context_of_aids_and_a_sart_has_no_name() -> None:
    at = Position(30, 54.1, 8.2, 1.0, 0.0, 2.0, 0.0)
    context = "atons.urn:mrn:imo:mmsi:992110001"
    assert vessel_values(AisReport(replace(SHIP, kind="aid", mmsi=992_110_001), False, at)) == {
        (context, ""): {"name": "FERRY", "mmsi": "992110001"},
        (context, "navigation.position"): {"latitude": 54.1, "longitude": 8.2},
    }
    assert vessel_values(AisReport(replace(SHIP, kind="sart"), False, None, (0,))) == {}


def test_static_data_come_with_the_static_report() -> None:
    assert vessel_values(AisReport(SHIP, False, None, (0,))) == {(CONTEXT, ""): {"name": "FERRY", "mmsi": "211000001"}}
    assert vessel_values(AisReport(SHIP, False, None)) == {}


def test_equal_values_are_told_once() -> None:
    changed: list[Path] = []
    times = iter(("first", "second", "third"))
    values = Values(changed.append, lambda: next(times))
    path = (SELF, "navigation.headingTrue")
    for value in (1.0, 1.0, 2.0):
        values.put({path: value})
    assert changed == [path, path] and values[path] == 2.0 and path in values and values.paths == [path]
    assert values.time(path) == "third"


def test_unchanged_values_are_told_again_on_request() -> None:
    changed: list[Path] = []
    values = Values(changed.append, lambda: "now")
    path = (SELF, "navigation.headingTrue")
    values.put({path: 1.0})
    values.put({path: 1.0}, unchanged_too=True)
    assert changed == [path, path]
