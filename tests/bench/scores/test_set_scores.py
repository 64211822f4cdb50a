"""Sets of tracks against sets of targets, compared with Stone Soup, which shares no code."""

from dataclasses import replace
from datetime import datetime, timedelta
from typing import Any

import numpy as np
import pytest

from radar_service.bench.scores.judged_scan import CUTOFF, JudgedRun, judged
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.set_scores import ospa_parts, set_scores
from radar_service.bench.trackers.tracker import TrackState
from tests.bench.scores.test_scoring import given, results, track, truth

BEGIN = 24  # scans until the first minute is over


def drawn(seed: int, far: float = 1000.0) -> list[ScanResult]:
    """Targets some of which are missed, tracks that are off, and false ones, as many of each as chance has it."""
    rng = np.random.default_rng(seed)
    made = []
    for scan in range(BEGIN + 8):
        truths = [truth(str(k), 2.5 * (scan + 1), 0.0, far * (k + 1)) for k in range(4)]
        tracks = [
            replace(track(str(k), one), east=one.position[0] + float(rng.normal(0, 60)), velocity_north=float(rng.normal()))
            for k, one in enumerate(truths)
            if rng.random() < 0.8
        ]
        false = [
            TrackState(
                track=f"false {k}", time=given(scan).time, east=9e4 * (k + 1), north=0, velocity_east=0, velocity_north=0
            )
            for k in range(rng.integers(0, 3))
        ]
        made.append(ScanResult(given(scan), (*tracks, *false), tuple(truths)))
    return made


def stone_soup(run: JudgedRun) -> dict[str, float]:
    """OSPA and GOSPA of the scans from the first minute on."""
    ospa = pytest.importorskip("stonesoup.metricgenerator.ospametric", reason="the extra `tracking` is absent")
    from stonesoup.measures import Euclidean
    from stonesoup.types.state import State

    def states(points: Any) -> list[State]:
        return [State(point, timestamp=datetime(2000, 1, 1)) for point in points]

    found: dict[str, list[float]] = {"ospa_m": [], "gospa_m": []}
    for scan in run.scans[BEGIN:]:
        truths = states(one.position for one in scan.truths.values())
        tracks = states((one.east, one.north) for one in scan.tracks.values())
        measure = Euclidean((0, 1))
        found["ospa_m"].append(ospa.OSPAMetric(c=CUTOFF, p=2, measure=measure).compute_OSPA_distance(tracks, truths).value)
        gospa, _ = ospa.GOSPAMetric(c=CUTOFF, p=2, measure=measure).compute_gospa_metric(tracks, truths)
        found["gospa_m"].append(gospa.value["distance"])
    return {name: float(np.mean(some)) for name, some in found.items()}


@pytest.mark.parametrize("seed", range(5))
def test_ospa_and_gospa_are_those_of_stone_soup(seed: int) -> None:
    """Within rounding of sums of a dozen squares."""
    run = judged(drawn(seed))
    expected = stone_soup(run)
    assert {name: set_scores(run)[name] for name in expected} == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_siap_is_that_of_stone_soup(seed: int) -> None:
    """Targets 1000 m apart, so that each track has one target or none."""
    pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")
    from stonesoup.measures import Euclidean
    from stonesoup.metricgenerator.manager import MultiManager
    from stonesoup.metricgenerator.tracktotruthmetrics import SIAPMetrics
    from stonesoup.types.groundtruth import GroundTruthPath
    from stonesoup.types.state import State
    from stonesoup.types.track import Track

    run = judged(drawn(seed))
    tracks: dict[str, Any] = {}
    paths: dict[str, Any] = {}
    for number, scan in enumerate(run.scans[BEGIN:]):
        at = datetime(2000, 1, 1) + timedelta(seconds=number)
        for body, one in scan.truths.items():
            paths.setdefault(body, GroundTruthPath(id=body)).append(State([*one.position], timestamp=at))
        for one_track in scan.tracks.values():
            name = next((body for body, its in scan.pairs.items() if its == one_track.track), f"{number} {one_track.track}")
            tracks.setdefault(name, Track(id=name)).append(State([one_track.east, one_track.north], timestamp=at))
    siap = SIAPMetrics(position_measure=Euclidean((0, 1)), velocity_measure=Euclidean((0, 1)))
    manager = MultiManager([siap], associator=_ByName())
    manager.add_data({"tracks": {*tracks.values()}, "groundtruth_paths": {*paths.values()}})
    expected = manager.generate_metrics()["siap_generator"]
    mine = set_scores(JudgedRun(run.scans[BEGIN:], run.sightings))
    for name, theirs in (("completeness", "SIAP Completeness"), ("ambiguity", "SIAP Ambiguity"),
                         ("spurious", "SIAP Spuriousness"), ("position_error_m", "SIAP Position Accuracy")):  # fmt: skip
        assert mine[name] == pytest.approx(float(expected[theirs].value), rel=1e-9), name


class _ByName:
    """Associates tracks with the path of their name."""

    def associate_tracks(self, tracks: Any, truths: Any) -> Any:
        from stonesoup.types.association import AssociationSet, TimeRangeAssociation
        from stonesoup.types.time import TimeRange

        paths = {path.id: path for path in truths}
        pairs = [(track, paths[track.id]) for track in tracks if track.id in paths]
        near = timedelta(seconds=0.1)
        return AssociationSet(
            {
                TimeRangeAssociation({track, path}, TimeRange(state.timestamp - near, state.timestamp + near))
                for track, path in pairs
                for state in track
            }
        )


@pytest.mark.parametrize("seed", range(5))
def test_the_parts_of_gospa_add_up(seed: int) -> None:
    for scan in judged(drawn(seed)).scans[BEGIN:]:
        parts = ospa_parts(scan)
        squares = sum(parts[f"gospa_{name}_m"] ** 2 for name in ("localisation", "missed", "false"))
        assert squares == pytest.approx(parts["gospa_m"] ** 2, rel=1e-12)


def test_the_first_minute_and_the_time_after_vanishing_are_free() -> None:
    """A track that comes with scan 20 and stays for 20 scans after her last plot costs nothing; one more scan is false."""
    for after, false in ((20, 0.0), (21, CUTOFF)):
        made = []
        for scan in range(90):
            one, two = truth("one", 2.5 * scan, 0, 1000), truth("two", 2.5 * scan, 0, 9000)
            tracks = [track("1", one)] if scan >= 20 else []
            tracks += [track("2", two)] if 20 <= scan < 50 + after else []
            made.append(ScanResult(given(scan), tuple(tracks), (one, replace(two, visible=scan < 50))))
        run = judged(made)
        assert set_scores(run)["completeness"] == 1.0
        assert ospa_parts(run.scans[70])["gospa_false_m"] == pytest.approx(false / np.sqrt(2.0))


def test_localisation_is_a_share_of_what_points_and_ships_may_have() -> None:
    """Tracks 3 m and 4 m off: of 15 m for points; of a sixth of 300 m."""
    metrics = set_scores(judged(results()))
    assert metrics["localisation_m"] == pytest.approx(4.0) and metrics["localisation_share"] == pytest.approx(4.0 / 15.0)
    ships = [replace(one, truths=tuple(replace(truth, length=300.0) for truth in one.truths)) for one in results()]
    assert set_scores(judged(ships))["localisation_share"] == pytest.approx(4.0 / 50.0)
    assert set_scores(judged(results(missing=True)))["localisation_share"] is None


def test_a_second_track_of_a_target_is_ambiguous_and_a_far_one_spurious() -> None:
    twice = [replace(one, tracks=(*one.tracks, replace(one.tracks[0], track="again"))) for one in results()]
    assert set_scores(judged(twice))["ambiguity"] == pytest.approx(1.5) and set_scores(judged(twice))["spurious"] == 0.0
    ghosts = [replace(one, tracks=(*one.tracks, replace(one.tracks[0], track="ghost", north=0.0))) for one in results()]
    assert set_scores(judged(ghosts))["spurious"] == pytest.approx(1.0 / 3.0)
