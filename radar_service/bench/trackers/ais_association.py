"""AIS targets are associated with tracks by position and motion: MSC.192(79) 5.30.1."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from radar_service.bench.trackers.tracker import AisTarget, Tracker, TrackerInput, TrackState, moved_on
from radar_service.numerics import Floats

POSITION, VELOCITY = 30.0, 1.0  # m, m/s: standard deviations of differences, for sensors of low accuracy (above 10 m)
DRIFT = 0.2  # m/s by which a reported velocity errs, as a position that is moved on
GATE = 18.5  # squared normalised distance: 1 in 1000 of the same ship is beyond (chi squared, 4 degrees of freedom)
MEMORY = 0.8  # of the distance so far, in each scan: one ship is near in all of them
OLDEST = 60.0  # s of a report


class AssociatingTracker:
    """A tracker.Tracker that adds MMSI and priority to the tracks of another."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._reports: dict[int, AisTarget] = {}
        self._squares: dict[tuple[str, int], float] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Returns the tracks after a scan, as Tracker.update."""
        tracks = self._tracker.update(scan)
        if scan.ais is None:
            return tracks
        self._reports |= {report.mmsi: report for report in scan.ais}
        reports = [report for report in self._reports.values() if scan.time - report.time <= OLDEST]
        pairs = self._associated(tracks, reports, squares(tracks, reports, scan.time))
        return [
            replace(track, mmsi=pairs.get(track.track), priority="ais" if track.track in pairs else "radar")
            for track in tracks
        ]

    def _associated(self, tracks: Sequence[TrackState], reports: Sequence[AisTarget], square: Floats) -> dict[str, int]:
        """The MMSI of tracks by name, one to one, with the least sum of distances over the last scans."""
        keys = [[(track.track, report.mmsi) for report in reports] for track in tracks]
        past = np.reshape([self._squares.get(key, np.nan) for row in keys for key in row], square.shape)
        mean = np.where(np.isnan(past), square, MEMORY * past + (1.0 - MEMORY) * square)
        self._squares = {key: float(mean[i, j]) for i, row in enumerate(keys) for j, key in enumerate(row)}
        rows, columns = (indices.tolist() for indices in linear_sum_assignment(np.minimum(mean, GATE)))
        return {tracks[i].track: reports[j].mmsi for i, j in zip(rows, columns, strict=True) if mean[i, j] < GATE}


def squares(tracks: Sequence[TrackState], reports: Sequence[AisTarget], time: float) -> Floats:
    """Returns the squared normalised distance (tracks, reports) of states at a time [s], at most twice the GATE."""
    states = [((track.east, track.north), (track.velocity_east, track.velocity_north), track.time) for track in tracks]
    place, speed = _at(states, time)
    reported = [((r.east, r.north), (r.speed * np.sin(r.course), r.speed * np.cos(r.course)), r.time) for r in reports]
    said_place, said_speed = _at(reported, time)
    spread = np.hypot(POSITION, DRIFT * (time - np.array([report.time for report in reports])))
    apart = np.linalg.norm(place[:, None] - said_place, axis=2) / spread
    faster = np.linalg.norm(speed[:, None] - said_speed, axis=2) / VELOCITY
    return np.asarray(np.minimum(apart**2 + faster**2, 2.0 * GATE))


def _at(states: Sequence[tuple[tuple[float, float], tuple[float, float], float]], time: float) -> tuple[Floats, Floats]:
    """Positions (N, 2) moved on to a time, and velocities (N, 2)."""
    moved = [moved_on(position, velocity, time - then) for position, velocity, then in states]
    return np.reshape(moved, (-1, 2)), np.reshape([velocity for _, velocity, _ in states], (-1, 2))
