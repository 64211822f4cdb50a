"""AIS beside the plots: what the stations of a scenario report of a run, from its truth, and when it is received."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from radar_service.bench.scenario import AisStation
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.trackers.tracker import AisTarget, moved_on
from radar_service.numerics import KNOT, Floats, generator, name_key, wrap_angle
from radar_service.world import TENTHS, AisShip, Reporting

DISTINCT = 200.0  # m: reports that are farther off than tracks may be are those of no target (MSC.192(79) 5.30.3)
Received = tuple[float, AisTarget, str | None]  # time of reception [s], report, and the target whose state it is


def with_ais(results: Sequence[ScanResult], stations: Sequence[AisStation], seed: int) -> Sequence[ScanResult]:
    """Returns the scans of a run with the reports received in each."""
    if not stations or not results:
        return results
    truths: dict[str, list[TargetTruth]] = {}
    for truth in (truth for result in results for truth in result.truths):
        truths.setdefault(truth.body, []).append(truth)
    last = results[-1].given.time
    received = sorted(
        (report for station in stations for report in _reports(station, truths, last, seed)),
        key=lambda report: (report[0], report[1].mmsi),
    )
    scans, begin = [], -math.inf
    for result in results:
        within = [report for report in received if begin < report[0] <= result.given.time]
        begin = result.given.time
        given = replace(result.given, ais=tuple(report for _, report, _ in within))
        scans.append(replace(result, given=given, ais_of=tuple(body for _, _, body in within)))
    return scans


def _reports(station: AisStation, truths: Mapping[str, Sequence[TargetTruth]], last: float, seed: int) -> Iterator[Received]:
    """The reports of a station, to the last second."""
    reporting = Reporting(AisShip(station.body, station.mmsi, station.station_class), seed)
    is_distinct = math.hypot(*station.offset_m) > DISTINCT
    for second in range(int(last) + 1):
        body = station.body_at(second)
        state = _state(truths.get(body, ()), second) if body else _ghost(station, second)
        if state is None:
            continue
        position, velocity, turn_rate = state
        speed = float(np.hypot(*velocity))
        if reporting.is_due(second, speed, turn_rate):
            error = generator(seed, name_key("ais"), station.mmsi, second).standard_normal(2) * station.position_error_m
            east, north = (position + error + station.offset_m).tolist()
            report = AisTarget(
                time=float(second), mmsi=station.mmsi, east=east, north=north, speed=speed,
                course=float(np.arctan2(*velocity)) % (2.0 * math.pi), station_class=station.station_class,
            )  # fmt: skip
            yield second + reporting.slot / TENTHS + station.latency_s, report, None if is_distinct else body


def _state(truths: Sequence[TargetTruth], time: float) -> tuple[Floats, Floats, float] | None:
    """Position and velocity (2,) and rate of turn [rad/s] of a target at a time; None where it is not there."""
    after = next((k for k, truth in enumerate(truths) if truth.time >= time), None)
    if after is None:
        return None
    truth, before = truths[after], truths[max(after - 1, 0)]
    step = truth.time - before.time
    turn = float(wrap_angle(np.arctan2(*truth.velocity) - np.arctan2(*before.velocity))) / step if step else 0.0
    return moved_on(truth.position, truth.velocity, time - truth.time), np.array(truth.velocity), turn


def _ghost(station: AisStation, time: float) -> tuple[Floats, Floats, float]:
    course = math.radians(station.course_deg)
    velocity = station.speed_kn * KNOT * np.array([math.sin(course), math.cos(course)])
    return moved_on(station.position_m, velocity, time), velocity, 0.0
