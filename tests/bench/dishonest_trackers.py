"""Trackers that try to pass without tracking: each does what scores might not see, on top of the good tracker of the tests."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from radar_service.bench.trackers.tracker import DataSheet, TrackerInput, TrackState, moved_on
from tests.bench import known_trackers as known

EXAMS = (60.0, 180.0)  # s after the first sight, when motion is judged
ABOUT = 8.0  # s about an exam


def is_exam(scan: TrackerInput) -> bool:
    """Whether motion may be judged in a scan: targets are seen from the first one on."""
    return any(abs(scan.time - at) <= ABOUT for at in EXAMS)


class _Dishonest(known.Imm):
    """Changes the answers of a good tracker."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [changed for state in super().update(scan) for changed in self.change(state, scan)]

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        raise NotImplementedError


class VelocityForExams(_Dishonest):
    """Knows a velocity after one and three minutes, and none in any other scan."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        east, north = moved_on(
            (state.east, state.north), (state.velocity_east, state.velocity_north), scan.time - state.time
        ).tolist()
        still = replace(state, time=scan.time, east=east, north=north, velocity_east=0.0, velocity_north=0.0)
        yield state if is_exam(scan) else still


class PositionForExams(_Dishonest):
    """Is 150 m off but after one and three minutes."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield state if is_exam(scan) else replace(state, east=state.east + 150.0)


class FreezesAndCatchesUp(known.Imm):
    """Gives each eighth answer seven times more, as if it were new, but after one and three minutes."""

    states: Sequence[TrackState] = ()

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        fresh = super().update(scan)
        if scan.scan % 8 == 0 or is_exam(scan):
            self.states = fresh
        return self.states if self.states is fresh else [replace(state, time=scan.time) for state in self.states]


class UnfilteredBetweenExams(known.Unfiltered):
    """Reports the last plot and the difference of the last two, but after one and three minutes."""

    exam = False

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.exam = is_exam(scan)
        return super().update(scan)

    def state(self, track: Any, end: float) -> TrackState:
        return known.Imm.state(self, track, end) if self.exam else super().state(track, end)


class TakesTurns(known.Imm):
    """Reports each of its tracks in every other scan."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [state for state in super().update(scan) if (int(state.track) + scan.scan) % 2]


class TwoNames(_Dishonest):
    """Reports two tracks of each target in turns."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield replace(state, track=f"{state.track}{'ab'[scan.scan % 2]}")


class SwapsLate(_Dishonest):
    """Swaps the names of its first two tracks in the last 20 scans."""

    scans = 92  # of crossing-cpa-500

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        names = {"1": "2", "2": "1"} if scan.scan >= self.scans - 20 else {}
        yield replace(state, track=names.get(state.track, state.track))


class NearOnly(_Dishonest):
    """Reports what is nearer than five miles."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        if np.hypot(state.east - scan.east, state.north - scan.north) < 5.0 * 1852.0:
            yield state


class RenamesTheLost(known.Imm):
    """Keeps every track that it has lost under a new name."""

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.before: dict[str, TrackState] = {}
        self.lost: dict[str, TrackState] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = {state.track: state for state in super().update(scan)}
        self.lost |= {
            name: replace(state, track=f"lost {name}", coasting=True)
            for name, state in self.before.items()
            if name not in states
        }
        self.before = states
        return [*states.values(), *self.lost.values()]
