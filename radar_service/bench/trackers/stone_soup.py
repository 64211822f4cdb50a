"""The reference tracker: Stone Soup's extended Kalman filter with nearest neighbours (GNN) or joint probabilities (JPDA).

It needs the extra `tracking`. Stone Soup is not imported before a tracker is made.
"""

from collections import deque
from collections.abc import Sequence
from datetime import datetime, timedelta
from functools import partial
from typing import Any, Literal

import numpy as np

from radar_service.bench.trackers.ais_association import AssociatingTracker
from radar_service.bench.trackers.gating import EPOCH, Tuning
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import DataSheet, Tracker, TrackerInput, TrackState
from radar_service.terminal import extra

LEAST_CLUTTER = 1e-8  # false plots per m^2 where hardly any are told


def gnn(sheet: DataSheet) -> Tracker:
    """Returns the reference tracker with nearest neighbours, tuned by a data sheet; it associates AIS targets."""
    return AssociatingTracker(ReckonedTracker(StoneSoupTracker(tuning_of(sheet, "gnn"))))


def jpda(sheet: DataSheet) -> Tracker:
    """Returns the reference tracker with joint probabilities, tuned by a data sheet."""
    return ReckonedTracker(StoneSoupTracker(tuning_of(sheet, "jpda")))


def tuning_of(sheet: DataSheet, association: Literal["gnn", "jpda"]) -> Tuning:
    """Returns how the reference tracker is tuned: the same but for what the data sheet tells."""
    return Tuning(
        association=association, range_error=sheet.range_error, bearing_error=sheet.bearing_error, glint=sheet.glint,
        clutter=max(sheet.clutter, LEAST_CLUTTER),
    )  # fmt: skip


class StoneSoupTracker:
    """A tracker.Tracker."""

    def __init__(self, tuning: Tuning | None = None) -> None:
        """Raises MissingExtra where Stone Soup is absent."""
        with extra("tracking", "the reference trackers"):
            from radar_service.bench.trackers.stone_soup_parts import detection, reference_tracks
        self._detection = partial(detection, tuning=tuning or Tuning())
        self._scans = deque[tuple[datetime, set[Any]]]()
        self._tracker = reference_tracks(tuning or Tuning(), iter(self._scans.popleft, None))
        self._names: dict[str, str] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Returns the tracks after a scan, as Tracker.update; each at the time of its last plot, or at the end of the scan."""
        self._scans.append((EPOCH + timedelta(seconds=scan.time), {*map(self._detection, scan.plots)}))
        _, tracks = next(self._tracker)
        first = sorted(tracks, key=lambda track: (track[0].timestamp, *np.ravel(track[0].mean).tolist()))
        return sorted((self._state(track) for track in first), key=lambda state: int(state.track))

    def _state(self, track: Any) -> TrackState:
        east, velocity_east, north, velocity_north = (float(value) for value in np.ravel(track.state.mean))
        name = self._names.setdefault(track.id, str(len(self._names) + 1))
        time = (track.state.timestamp - EPOCH) / timedelta(seconds=1)
        return TrackState(
            track=name, time=time, east=east, north=north, velocity_east=velocity_east, velocity_north=velocity_north
        )
