"""Readers for Stone Soup: a service gives the plots, tracks and truth that a simulator in this process gives."""

from datetime import timedelta
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")

import radar_service as rs
from radar_service.bench.trackers.gating import EPOCH, Tuning
from radar_service.bench.trackers.stone_soup import reference_tracks
from radar_service.bench.trackers.stone_soup_readers import PlotReader, TruthReader, scan_end
from radar_service.radar_feed import RadarFeed, RadarFeeds, RemoteFeed, service
from tests.bench.test_scenario import SMALL

SCANS = 8
SCENE: dict[str, Any] = {"name": "small", **SMALL["scene"], "own_ship": {"speed_kn": 10, "course_deg": 30}}
RADAR = rs.load_scene(SCENE).radar


def plots_of(feed: RadarFeed) -> list[tuple[Any, ...]]:
    """Times, states and own ship's positions of the detections that a reader gives, scan by scan."""
    return [
        (time, sorted((d.timestamp, *np.ravel(d.state_vector), *np.ravel(d.measurement_model.translation_offset)) for d in some))
        for time, some in PlotReader(feed.scans(SCANS), RADAR)
    ]  # fmt: skip


def truth_of(feed: RadarFeed) -> list[tuple[Any, ...]]:
    return [
        (time, [(path.id, len(path), *np.ravel(path[-1].state_vector)) for path in paths])
        for time, paths in TruthReader(feed.snapshots)
    ]


@pytest.fixture(scope="module")
def of_process() -> tuple[Any, Any]:
    with RadarFeeds() as feeds:
        feed = feeds(SCENE, seed=3, fidelity="balanced")
        return plots_of(feed), truth_of(feed)


@pytest.mark.same_bytes
def test_a_service_gives_the_plots_and_the_truth_of_a_simulator(of_process: tuple[Any, Any]) -> None:
    with service(SCENE, 3, "max", "balanced") as running:
        feed = RemoteFeed(running.address)
        assert (plots_of(feed), truth_of(feed)) == of_process
        feed.close()


def test_detections_are_where_the_truth_is(of_process: tuple[Any, Any]) -> None:
    """In the scans after the first one; within 2 m, on a map on which own ship moves."""
    plots, truth = of_process
    assert [time for time, _ in plots] == [time for time, _ in truth] == [scan_end(k, RADAR) for k in range(SCANS)]
    for (end, detections), (_, [(name, count, east, v_east, north, v_north)]) in zip(plots[1:], truth[1:], strict=True):
        earlier = {d: (end - d[0]) / timedelta(seconds=1) for d in detections}
        offsets = [
            np.hypot(
                own_east + distance * np.cos(angle) - east + earlier[d] * v_east,
                own_north + distance * np.sin(angle) - north + earlier[d] * v_north,
            )
            for d in detections
            for _, angle, distance, own_east, own_north in [d]
        ]
        assert name == "t" and count == 1 + plots.index((end, detections)) and min(offsets) < 2.0
        assert all(0.0 < later < 2.5 for later in earlier.values())


def test_a_misaligned_antenna_shows_in_the_plots_of_a_service(of_process: tuple[Any, Any]) -> None:
    """By 20 units of the wire, 0.11 degrees: bearings of mathematics turn the other way."""
    unit = 2.0 * np.pi / 65536
    errors = {"antenna": {"misalignment_deg": float(np.degrees(20 * unit))}}
    with service(SCENE | {"errors": errors}, 3, "max", "balanced") as running:
        feed = RemoteFeed(running.address)
        for (_, biased), (_, right) in zip(plots_of(feed), of_process[0], strict=False):
            turned = [float(one[1]) - float(other[1]) for one, other in zip(biased, right, strict=True)]
            np.testing.assert_allclose(np.exp(1j * np.array(turned)), np.exp(-20j * unit), atol=1e-12)  # rounding
        feed.close()


@pytest.mark.parametrize("association", ["gnn", "jpda"])
def test_the_reference_chains_take_a_reader(association: str) -> None:
    scene = rs.load_scene(SCENE)
    simulator = rs.Simulator(scene, "balanced", 3)
    reader = PlotReader((simulator.scan() for _ in range(SCANS)), scene.radar)
    *_, (time, tracks) = reference_tracks(Tuning("jpda" if association == "jpda" else "gnn"), reader)
    (track,) = tracks
    assert time == EPOCH + timedelta(seconds=2.5 * SCANS) and time - timedelta(seconds=2.5) < track.timestamp < time
    body = simulator.truth((track.timestamp - EPOCH) / timedelta(seconds=1)).bodies[0]
    east, _, north, _ = np.ravel(track.state.mean).tolist()
    assert np.hypot(east - body.position[0], north - body.position[1]) < 3.0
