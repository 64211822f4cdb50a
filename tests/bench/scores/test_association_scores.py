"""Who associates AIS targets by 5.30 of MSC.192(79) passes, and each liar is caught with a sentence."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from radar_service.bench.run import answered
from radar_service.bench.scenario import load_scenario
from radar_service.bench.scores.association_scores import association_scores
from radar_service.bench.scores.events import events_of
from radar_service.bench.scores.judged_scan import JudgedRun, judged
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.trackers.ais_association import AssociatingTracker
from radar_service.bench.trackers.tracker import AisTarget, TrackerInput, TrackState, moved_on
from tests.bench.known_trackers import Truth
from tests.bench.test_ais_reports import reckoned

SCENARIOS = ("ais-late-and-offset", "ais-swapped", "ais-ghosts")
LIMITS = {"ais_missed", "ais_wrong", "priority_errors"}
NEAR = 100.0  # m


class _Liar:
    """Follows all targets truly, and lies of their MMSI."""

    def __init__(self, observed: Sequence[ScanResult]) -> None:
        self.truth, self.honest = Truth(observed), AssociatingTracker(Truth(observed))
        self.reports: dict[int, AisTarget] = {}
        self.first: dict[str, int] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.reports |= {report.mmsi: report for report in scan.ais or ()}
        return self.lie(scan)

    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        return self.honest.update(scan)

    def nearest(self, scan: TrackerInput, gate: float) -> Sequence[TrackState]:
        """The nearest reports, one to one, whatever their motion."""
        tracks, reports = self.truth.update(scan), [*self.reports.values()]
        velocity = [(r.speed * np.sin(r.course), r.speed * np.cos(r.course)) for r in reports]
        reported = [moved_on((r.east, r.north), v, scan.time - r.time) for r, v in zip(reports, velocity, strict=True)]
        places = [(track.east, track.north) for track in tracks]
        apart = np.linalg.norm(np.reshape(places, (-1, 1, 2)) - np.reshape(reported, (1, -1, 2)), axis=2)
        pairs = [(i, j) for i, j in zip(*linear_sum_assignment(apart), strict=True) if apart[i, j] < gate]
        return [replace(tracks[i], mmsi=reports[j].mmsi, priority="ais") for i, j in pairs]


class AlwaysNearest(_Liar):
    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        return self.nearest(scan, np.inf)


class IgnoresMotion(_Liar):
    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        return self.nearest(scan, NEAR)


class IgnoresTimeOfReport(_Liar):
    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        return self.honest.update(replace(scan, ais=tuple(replace(report, time=scan.time) for report in scan.ais or ())))


class KeepsAfterSwap(_Liar):
    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = self.honest.update(scan)
        self.first = {state.track: state.mmsi for state in states if state.mmsi} | self.first
        return [replace(state, mmsi=self.first.get(state.track)) for state in states]


class AssociatesGhosts(_Liar):
    """Gives what is left to the ships that have no AIS."""

    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = self.honest.update(scan)
        rest = iter(sorted(self.reports.keys() - {state.mmsi for state in states}))
        return [state if state.mmsi else replace(state, mmsi=next(rest, None)) for state in states]


class AssociatesHalf(_Liar):
    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [replace(s, mmsi=s.mmsi if s.mmsi == 211000001 else None, priority=None) for s in self.honest.update(scan)]


class DisplaysAis(_Liar):
    def lie(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [replace(state, priority="ais") for state in self.honest.update(scan)]


def run_of(tracker: Callable[[Sequence[ScanResult]], Any], name: str) -> JudgedRun:
    observed = reckoned(load_scenario(name))
    return judged([*answered(observed, tracker(observed))])


def missed(run: JudgedRun, name: str) -> set[str]:
    return {*load_scenario(name).missed(association_scores(run))} & LIMITS


@pytest.mark.parametrize("name", SCENARIOS)
def test_who_associates_by_position_and_motion_passes(name: str) -> None:
    run = run_of(_Liar, name)
    assert missed(run, name) == set() and events_of(run) == []
    assert association_scores(run)["ais_right"] == 1.0


@pytest.mark.parametrize("name", SCENARIOS)
def test_who_ignores_ais_is_not_judged_by_it(name: str) -> None:
    assert association_scores(run_of(Truth, name)) == {}


@pytest.mark.parametrize(
    ("liar", "name", "metric", "words"),
    [
        (
            AlwaysNearest,
            "ais-ghosts",
            "ais_wrong",
            "track displaced of displaced has MMSI 211000004, which reports no target",
        ),
        (IgnoresMotion, "ais-ghosts", "ais_wrong", "track crossed of crossed has MMSI 211000002, which reports no target"),
        (IgnoresTimeOfReport, "ais-late-and-offset", "ais_missed", "track late of late has no MMSI, but 211000001 reports"),
        (
            KeepsAfterSwap,
            "ais-swapped",
            "ais_wrong",
            "track eastbound of eastbound has MMSI 211000001, which reports westbound",
        ),
        (AssociatesGhosts, "ais-ghosts", "ais_wrong", "which reports no target that is there"),
        (AssociatesHalf, "ais-late-and-offset", "ais_missed", "track offset of offset has no MMSI, but 211000002 reports"),
        (DisplaysAis, "ais-ghosts", "priority_errors", "track crossed displays ais, without an MMSI"),
    ],
)
def test_each_liar_is_caught_with_a_sentence(liar: type[_Liar], name: str, metric: str, words: str) -> None:
    run = run_of(liar, name)
    assert metric in missed(run, name)
    assert any(words in event.what for event in events_of(run))
