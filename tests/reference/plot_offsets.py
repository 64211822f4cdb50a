"""How far the plots of a ship lie from the middle of its waterline, by aspect, and from where its power lies.

`python -m tests.reference.plot_offsets` measures and writes the table of docs/plots.md anew. It takes a minute.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import radar_service as rs
from radar_service.bench.run import tracker_input, truths_of
from radar_service.bench.scores.plot_scores import PlotMatch, matches
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.plots.clusters import ClusterRule
from radar_service.plots.extractor import PlotExtractor
from radar_service.scene_file.document import packaged_folder
from tests.reference.docs_tables import table, write_measured

ASPECTS = (0, 15, 30, 45, 60, 75, 90, 105, 120, 135, 150, 165, 180)  # degrees; a ship is alike on both sides, nearly
DISTANCE = 2000.0  # m
SCANS = 20
RATE = 0.3  # degrees per second: 15 degrees in 20 scans, the step between aspects
RADAR = {
    "azimuths": 1024, "beamwidth_deg": 1.2, "range_max_m": 2400, "pulse_s": 1e-6, "bandwidth_hz": 20e6, "sample_rate_hz": 30e6,
    "pattern": "taylor", "power_w": 25,
}  # fmt: skip


@dataclass(frozen=True)
class Offsets:
    """What plots of a ship give at an aspect [deg], as arrays (K,) [m]: along, across: of its power from the middle of its
    waterline, to the bow and to starboard; in_range, in_bearing: of the plot from its power, outward and clockwise."""

    aspect: float
    along: np.ndarray
    across: np.ndarray
    in_range: np.ndarray
    in_bearing: np.ndarray


def measured(aspects: Sequence[float], scans: int, ship: dict[str, Any], seed: int = 0) -> list[Offsets]:
    """Ships all round a radar at rest, each turning slowly through an aspect."""
    bearings = np.linspace(0.0, 360.0, len(aspects), endpoint=False) + 180.0 / len(aspects)
    half = RATE * scans * 2.5 / 2.0
    bodies = [
        {
            **ship, "name": f"{aspect}", "course_deg": bearing + 180.0 - aspect - half, "speed_kn": 0.0, "turn_rate_deg_s": RATE,
            "position_m": [DISTANCE * np.sin(np.radians(bearing)), DISTANCE * np.cos(np.radians(bearing)), 0.0],
        }
        for aspect, bearing in zip(aspects, bearings.tolist(), strict=True)
    ]  # fmt: skip
    content = {"name": "offsets", "radar": RADAR, "environment": {"noise": True}, "body": bodies}
    scene = rs.load_scene(content, folder=packaged_folder("scenes"))
    simulator = rs.Simulator(scene, "balanced", seed)
    extractor, results = PlotExtractor(scene.radar, rule=ClusterRule(3, 30, np.inf), gate_db=20.0), []
    for _ in range(scans):
        scan = simulator.scan()
        plots = extractor.add(scan).plots
        truths = truths_of(simulator, range(scan.number, scan.number + 1), [body["name"] for body in bodies])[0]
        results.append(
            ScanResult(tracker_input(scan.number, scan.time, scan, plots, scene.radar.rotation_period), (), truths)
        )
    every = [match for some in matches(results) for match in some if match.truth.centroid]
    return [_offsets(aspect, [match for match in every if match.truth.body == f"{aspect}"]) for aspect in aspects]


def _offsets(aspect: float, found: Sequence[PlotMatch]) -> Offsets:
    centroids = np.array([match.truth.centroid for match in found]).reshape(-1, 2)
    distance = np.array([match.plot.range for match in found])
    errors = np.array([(match.range_error, match.bearing_error) for match in found]).reshape(-1, 2)
    return Offsets(aspect, centroids[:, 0], centroids[:, 1], errors[:, 0], errors[:, 1] * distance)


def rows(every: Sequence[Offsets]) -> str:
    """The table."""
    head = (
        "aspect", "along, mean", "along, standard deviation", "across, mean", "across, standard deviation",
        "plot less power, in range", "across the line of sight",
    )  # fmt: skip
    return table(head, [(f"{one.aspect:g}", *_glint(one), *map(_mean, (one.in_range, one.in_bearing))) for one in every])


def _glint(one: Offsets) -> tuple[str, ...]:
    """Mean and standard deviation of where its power lies, along and across."""
    return tuple(f"{value:.1f}" for x in (one.along, one.across) for value in (x.mean(), x.std(ddof=1)))


def _mean(errors: np.ndarray) -> str:
    return f"{errors.mean():+.2f} ± {errors.std(ddof=1) / np.sqrt(len(errors)):.2f}"


if __name__ == "__main__":  # of the freighter
    made = rows(measured(ASPECTS, SCANS, {"mesh": "freighter.obj", "scattering": "optics"}))
    write_measured("plot-offsets", made, "plots")
    print(made)
