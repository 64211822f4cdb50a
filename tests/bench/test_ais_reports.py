"""AIS beside the plots, of runs whose truth is dead reckoning: who is reported, how often, and when it is received."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.bench.ais_reports import with_ais
from radar_service.bench.scenario import AisStation, Scenario, ScenarioError, file_errors, load_scenario
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.trackers.callable_child import scan_of
from radar_service.bench.trackers.tracker import AisTarget
from radar_service.numerics.constants import KNOT
from tests.bench.trackers.test_stone_soup import PERIOD, given


def reckoned(scenario: Scenario, seed: int = 0) -> list[ScanResult]:
    """A run of a scenario of straight courses without a simulator: truth at the middle of each scan, and AIS."""
    return [
        *with_ais([ScanResult(given(k, ()), (), truths(scenario, k)) for k in range(scenario.scans)], scenario.ais, seed)
    ]


def truths(scenario: Scenario, scan: int) -> tuple[TargetTruth, ...]:
    bodies, time = scenario.scene["body"], (scan + 0.5) * PERIOD
    return tuple(truth(body, time) for body in bodies if time < body.get("end_s", np.inf))


def truth(body: dict[str, Any], time: float) -> TargetTruth:
    course, speed = np.radians(body["course_deg"]), body["speed_kn"] * KNOT
    velocity = (float(speed * np.sin(course)), float(speed * np.cos(course)))
    east, north = (float(body["position_m"][k] + time * velocity[k]) for k in range(2))
    return TargetTruth(
        body=body["name"], time=time, position=(east, north), velocity=velocity, own_position=(0.0, 0.0),
        own_velocity=(0.0, 0.0), visible=True,
    )  # fmt: skip


def received(name: str, mmsi: int) -> list[tuple[float, AisTarget, str | None]]:
    """The end of the scan, the report and its target, of all reports of a station."""
    return [
        (result.given.time, report, body)
        for result in reckoned(load_scenario(name))
        for report, body in zip(result.given.ais or (), result.ais_of, strict=True)
        if report.mmsi == mmsi
    ]


@pytest.mark.parametrize(
    ("mmsi", "every", "latency", "offset"),
    [(211000001, 6, 20.0, (0.0, 0.0)), (211000002, 10, 0.0, (40.0, -30.0)), (211000003, 30, 0.0, (0.0, 0.0))],
)
def test_stations_report_as_often_as_their_class_and_as_late_as_they_are(
    mmsi: int, every: int, latency: float, offset: tuple[float, float]
) -> None:
    scenario = load_scenario("ais-late-and-offset")
    body = {station.mmsi: station.body for station in scenario.ais}[mmsi]
    table = next(table for table in scenario.scene["body"] if table["name"] == body)
    reports = received("ais-late-and-offset", mmsi)
    assert {later.time - report.time for (_, report, _), (_, later, _) in zip(reports, reports[1:], strict=False)} == {every}
    assert all(latency < end - report.time <= latency + 1.0 + PERIOD for end, report, _ in reports)
    errors = [
        np.subtract((report.east, report.north), truth(table, report.time).position) - offset for _, report, _ in reports
    ]
    assert {body for *_, body in reports} == {body} and 3.0 < np.std(errors) < 20.0 and np.max(np.abs(errors)) < 45.0


def test_ships_exchange_their_reports_and_ghosts_are_of_no_target() -> None:
    swapped = received("ais-swapped", 211000001)
    assert {(report.time >= 105.0, body) for _, report, body in swapped} == {(False, "eastbound"), (True, "westbound")}
    assert all((report.course < np.pi) == (body == "eastbound") for _, report, body in swapped)
    ghosts = [body for mmsi in (211000002, 211000003, 211000004) for *_, body in received("ais-ghosts", mmsi)]
    assert len(ghosts) > 50 and set(ghosts) == {None}


def test_a_scan_without_ais_is_as_it_was_and_one_with_ais_goes_there_and_back() -> None:
    results = [ScanResult(given(0, ()), (), ())]
    assert with_ais(results, (), 0) is results and "ais" not in results[0].given.as_dict()
    scan = next(result.given for result in reckoned(load_scenario("ais-ghosts")) if result.given.ais)
    assert scan_of(scan.as_dict()) == scan


@pytest.mark.parametrize(
    ("stations", "words"),
    [
        ([{"mmsi": 1, "body": "nobody"}], "there is no target 'nobody'"),
        ([{"mmsi": 1}, {"mmsi": 1}], "two stations have one mmsi"),
        ([{"mmsi": 0}], "ais.0.mmsi"),
        ([{"mmsi": 1, "swap_body": "westbound"}], "one needs the other"),
    ],
)
def test_stations_of_rubbish_are_refused(stations: list[dict[str, Any]], words: str) -> None:
    content = load_scenario("ais-swapped").model_dump(exclude={"folder", "file"})
    with pytest.raises(ScenarioError, match=f"a.toml: .*{words}"), file_errors(Path("a.toml")):
        Scenario(**{**content, "ais": stations})


def test_a_body_without_name_is_left_to_the_scene() -> None:
    content = load_scenario("ais-swapped").model_dump(exclude={"folder", "file"})
    assert Scenario(**{**content, "ais": (), "scene": {"body": [{"shape": "point"}]}}).ais == ()


def test_no_report_is_lost_between_two_scans() -> None:
    """At 2.4 s a turn (25 rpm), where the ends of scans, as sums, are no tenths to the last bit, and slots are at them."""
    scenario = load_scenario("ais-swapped")
    results = [ScanResult(replace(given(k, ()), time=(k + 1) * 2.4), (), truths(scenario, k)) for k in range(scenario.scans)]
    stations = tuple(AisStation(mmsi=k + 1, body=scenario.ais[0].body, latency_s=0.1 * k) for k in range(30))
    every = with_ais([replace(results[-1], truths=sum((result.truths for result in results), ()))], stations, 0)
    got = [report for scan in with_ais(results, stations, 0) for report in scan.given.ais or ()]
    assert got == [*(every[0].given.ais or ())]
