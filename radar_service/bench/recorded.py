"""Recorded scenarios: plots of a real radar and the true positions of vessels, as a tracker under test gets simulated ones."""

import itertools
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.bench.scenario import Scenario, ScenarioError
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.trackers.tracker import TrackerInput
from radar_service.plots import Plot

UNKNOWN_DB = 20.0  # dB over noise, of all plots of a recording without levels
Recording = Mapping[
    str, Any
]  # `scans`: time, own, plots from own ship; `targets`: places and velocities at each scan [m, m/s]


def recorded_scans(scenario: Scenario) -> Iterator[ScanResult]:
    """Yields the plots and truth of a recording, scan by scan, without tracks. Raises ScenarioError for one that is not whole."""
    recording = read_recording((scenario.folder or Path()) / (scenario.recorded or ""))
    scans = recording["scans"][: scenario.scans]
    own = np.array([scan["own"] for scan in scans])
    times = np.array([scan["time"] for scan in scans])
    velocity = np.gradient(own, times, axis=0) if len(scans) > 1 else np.zeros_like(own)
    for number, scan in enumerate(scans):
        truths = tuple(
            _truth(name, scan["time"], rows[number], own[number], velocity[number])
            for name, rows in recording["targets"].items()
            if name in (scenario.targets or recording["targets"])
        )
        east, north, speed = float(own[number, 0]), float(own[number, 1]), float(np.hypot(*velocity[number]))
        course = float(np.arctan2(*velocity[number])) % (2.0 * math.pi)
        plots = tuple(_plot(number, scan["time"], place, (east, north)) for place in scan["plots"])
        yield ScanResult(
            TrackerInput(
                scan=number, time=scan["time"], east=east, north=north, heading=course, course=course, speed=speed, plots=plots
            ),
            (), truths,
        )  # fmt: skip


def read_recording(path: Path) -> Recording:
    """Returns a recording. Raises ScenarioError that names the file, and what is missing or cut."""
    try:
        recording: Recording = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise ScenarioError(f"{path}: it is no whole JSON file ({error}); get it again") from None
    try:
        scans, targets = recording["scans"], recording["targets"]
        numbers = [[scan["time"], *scan["own"], *itertools.chain(*scan["plots"])] for scan in scans]
    except (KeyError, TypeError) as error:
        raise ScenarioError(f"{path}: a scan or the file lacks {error}; get it again") from None
    if odd := [number for number, row in enumerate(numbers) if len(row) % 2 == 0 or not np.isfinite(row).all()]:
        raise ScenarioError(f"{path}: scan {odd[0]} has numbers that are none, or half a plot")
    if (np.diff([row[0] for row in numbers]) <= 0.0).any():
        raise ScenarioError(f"{path}: its times do not rise")
    for name, rows in targets.items():
        if np.shape(rows) != (len(scans), 4):
            raise ScenarioError(f"{path}: {name} has {len(rows)} rows of truth for {len(scans)} scans, of four numbers each")
    return recording


def _truth(name: str, time: float, row: Any, own: Any, own_velocity: Any) -> TargetTruth:
    east, north, *velocity = row
    return TargetTruth(
        body=name, time=time, position=(east, north), velocity=(velocity[0], velocity[1]),
        own_position=(float(own[0]), float(own[1])), own_velocity=(float(own_velocity[0]), float(own_velocity[1])),
        visible=True, heading=math.atan2(velocity[0], velocity[1]),
        echo=(math.hypot(east - own[0], north - own[1]), math.atan2(east - own[0], north - own[1]) % (2.0 * math.pi)),
    )  # fmt: skip


def _plot(scan: int, time: float, place: Any, own: tuple[float, float]) -> Plot:
    """A plot of which its place from own ship alone was recorded: its level is UNKNOWN_DB, its extent a point."""
    distance, bearing = math.hypot(*place), math.atan2(*place) % (2.0 * math.pi)
    return Plot(
        scan=scan, time=time, range=distance, bearing=bearing, east=own[0] + place[0], north=own[1] + place[1],
        snr_db=UNKNOWN_DB, cells=1, range_extent=(distance, distance), bearing_extent=(bearing, bearing),
    )  # fmt: skip
