"""A feed that is biased on purpose is caught with the size of its bias; feeds with other cells tell the cause."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from radar_service.bench.run import tracker_input, truths_of
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.bias import Bias, bias_cause, range_and_bearing_bias
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.plots.extractor import PlotExtractor
from radar_service.scans.scan import Scan
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from tests.bench.test_scenario import SMALL

SCANS = 8
AZIMUTHS = (256, 384)
Change = Callable[[Scan], Scan]


def spoke_start(scan: Scan) -> Scan:
    """A client that takes the azimuth of a spoke for its start, and adds half a spoke."""
    return replace(scan, azimuth=scan.azimuth + np.pi / len(scan.azimuth))


def bin_start(scan: Scan) -> Scan:
    """A client that takes cells to begin where they have their middle."""
    return replace(scan, range=scan.range + scan.range_step / 2.0)


@cache
def biases(azimuths: int, change: Change, gyro_deg: float = 0.0, misalignment_deg: float = 0.0) -> tuple[Bias, Bias]:
    scenario = Scenario(**SMALL)
    content: dict[str, Any] = scenario.scene_for(1)
    errors = {"gyro": {"bias_deg": gyro_deg}, "antenna": {"misalignment_deg": misalignment_deg}}
    scene = load_scene({**content, "radar": {**content["radar"], "azimuths": azimuths, "power_w": 2.5e6}, "errors": errors})
    simulator, extractor, results = Simulator(scene, "balanced", 1), PlotExtractor(scene.radar), []
    for _ in range(SCANS):
        scan = change(simulator.scan())
        given = tracker_input(scan.number, scan.time, scan, extractor.add(scan).plots, scene.radar.rotation_period)
        results.append(ScanResult(given, (), *truths_of(simulator, range(scan.number, scan.number + 1), ["t"])))
    return range_and_bearing_bias(results)


def unchanged(scan: Scan) -> Scan:
    return scan


def test_a_right_feed_has_no_bias() -> None:
    along, across = biases(256, unchanged)
    assert along.count == SCANS and not along.is_sure and not across.is_sure


@pytest.mark.parametrize(
    ("change", "gyro_deg", "metres", "degrees"),
    [(bin_start, 0.0, 299_792_458.0 / 30e6 / 4.0, 0.0), (spoke_start, 0.0, 0.0, 180.0 / 256), (unchanged, 0.1, 0.0, 0.1)],
    ids=["half a bin", "half a spoke", "gyro"],
)
def test_a_bias_on_purpose_is_caught_with_its_size(change: Change, gyro_deg: float, metres: float, degrees: float) -> None:
    """Within 10 %, and only in the coordinate that is biased."""
    along, across = biases(256, change, gyro_deg)
    assert along.is_sure == (metres > 0.0) and across.is_sure == (degrees > 0.0)
    assert along.value == pytest.approx(metres, rel=0.1, abs=4.0 * along.error)
    assert np.degrees(across.value) == pytest.approx(
        degrees, rel=0.1, abs=0.0 if degrees else 4.0 * np.degrees(across.error)
    )


@pytest.mark.parametrize(
    ("change", "gyro_deg", "spokes"), [(spoke_start, 0.0, 0.5), (unchanged, 0.1, 0.0), (spoke_start, 0.1, 0.5)]
)
def test_two_azimuth_counts_tell_a_spoke_from_a_gyro(change: Change, gyro_deg: float, spokes: float) -> None:
    cause = bias_cause({2.0 * np.pi / azimuths: biases(azimuths, change, gyro_deg)[1] for azimuths in AZIMUTHS})
    assert cause.cells == pytest.approx(spokes, abs=4.0 * cause.cells_error) and cause.cells_error < 0.02
    assert np.degrees(cause.constant) == pytest.approx(gyro_deg, abs=4.0 * np.degrees(cause.constant_error))
    assert np.degrees(cause.constant_error) < 0.01


def test_a_gyro_and_a_misaligned_antenna_look_alike_at_rest() -> None:
    """So no cause tells them apart."""
    assert biases(256, unchanged, gyro_deg=0.1)[1].value == pytest.approx(
        biases(256, unchanged, misalignment_deg=0.1)[1].value, abs=1e-9
    )


def test_a_single_feed_has_no_cause() -> None:
    with pytest.raises(ValueError, match="1 width of cells is not allowed; 2 or more tell a spoke from a gyro"):
        bias_cause({0.01: Bias(0.005, 0.001, 10)})
    with pytest.raises(ValueError, match="0 plots of targets are too few"):
        range_and_bearing_bias([])


def test_surer_feeds_weigh_more() -> None:
    """Three feeds, of which the wrong one is a thousand times less sure."""
    made = {cell: Bias(0.2 + 0.5 * cell, 1e-4, 10) for cell in (1.0, 2.0)} | {3.0: Bias(9.0, 0.1, 10)}
    cause = bias_cause(made)
    assert cause.cells == pytest.approx(0.5, abs=1e-3) and cause.constant == pytest.approx(0.2, abs=1e-3)
