"""A scan as it is judged: all states at its end, in the frame that own ship reports, and which track follows which target."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from radar_service.bench.scores.scan_result import ScanResult, TargetTruth, as_reported, at_end
from radar_service.bench.scores.sightings import Sightings, sightings_of
from radar_service.bench.trackers.tracker import TrackState, moved_on
from radar_service.numerics import Floats

CUTOFF = 200.0  # m, of OSPA and GOSPA, and of an association
MAX_AGE = 3  # scans: the target of an older state is missed, unless the tracker says that it coasts


@dataclass(frozen=True)
class JudgedScan:
    """One scan. All states are at its end, moved there with their own velocity.

    result: what it is made of, without lost tracks; lost: names of these, None where nothing says so.
    truths: targets that may have a track, by name, as own ship reports them. due: those that must
    have one. tracks: by name, without those that are too old. near: tracks within CUTOFF of a target. pairs: the track of each
    target, one to one, with the least sum of distances. distance: of each pair [m], by target. stale: by target, name
    and age [s] of the nearest track within CUTOFF that is too old.
    """

    result: ScanResult
    truths: Mapping[str, TargetTruth]
    due: frozenset[str]
    tracks: Mapping[str, TrackState]
    near: frozenset[str]
    pairs: Mapping[str, str]
    distance: Mapping[str, float]
    stale: Mapping[str, tuple[str, float]]
    lost: frozenset[str] | None = None


@dataclass(frozen=True)
class JudgedRun:
    """A run. scans: by number; sightings: of each target that is ever seen, by name."""

    scans: tuple[JudgedScan, ...]
    sightings: Mapping[str, Sightings]


def judged(results: Sequence[ScanResult]) -> JudgedRun:
    """Returns a run as it is judged."""
    sightings = sightings_of(results)
    period = results[0].given.time / (results[0].given.scan + 1) if results else 0.0
    return JudgedRun(tuple(_judged(k, result, sightings, period) for k, result in enumerate(results)), sightings)


def _judged(scan: int, result: ScanResult, sightings: Mapping[str, Sightings], period: float) -> JudgedScan:
    end, says = result.given.time, any(track.lost is not None for track in result.tracks)
    lost = frozenset(track.track for track in result.tracks if track.lost) if says else None
    result = replace(result, tracks=tuple(track for track in result.tracks if not track.lost))
    possible = [truth for truth in result.truths if truth.body in sightings and sightings[truth.body].may_have_track(scan)]
    truths = {truth.body: as_reported(at_end(truth, end)) for truth in possible}
    tracks = {
        track.track: track_at(track, end)
        for track in result.tracks
        if track.coasting or end - track.time <= MAX_AGE * period
    }
    old = [track for track in result.tracks if track.track not in tracks]
    behind = distances([*truths.values()], [track_at(track, end) for track in old])
    distance = distances([*truths.values()], [*tracks.values()])
    names, bodies = [*tracks], [*truths]
    pairs = [(i, j) for i, j in zip(*assigned(distance), strict=True) if distance[i, j] < CUTOFF]
    return JudgedScan(
        result, truths, frozenset(body for body in truths if scan in sightings[body].due), tracks,
        frozenset(names[j] for j in np.nonzero((distance < CUTOFF).any(axis=0))[0].tolist()),
        {bodies[i]: names[j] for i, j in pairs}, {bodies[i]: float(distance[i, j]) for i, j in pairs},
        {
            body: (old[row.argmin()].track, end - old[row.argmin()].time)
            for body, row in zip(bodies, behind, strict=True) if len(old) and row.min() < CUTOFF
        },
        lost,
    )  # fmt: skip


def track_at(track: TrackState, time: float) -> TrackState:
    """Returns a track moved with its own velocity to a time [s]."""
    east, north = moved_on((track.east, track.north), (track.velocity_east, track.velocity_north), time - track.time)
    return replace(track, time=time, east=float(east), north=float(north))


def distances(truths: Sequence[TargetTruth], tracks: Sequence[TrackState]) -> Floats:
    """Returns the distance (truths, tracks) [m] of states of one time."""
    true = np.array([truth.position for truth in truths]).reshape(-1, 1, 2)
    tracked = np.array([(track.east, track.north) for track in tracks]).reshape(1, -1, 2)
    apart = true - tracked
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]))


def nearest_distances(scan: JudgedScan) -> dict[str, float]:
    """Returns how far the nearest track of each target is [m], however far; none where the scan has no track."""
    if not scan.tracks:
        return {}
    apart = distances([*scan.truths.values()], [*scan.tracks.values()])
    return dict(zip(scan.truths, apart.min(axis=1).tolist(), strict=True))


def assigned(distance: Floats) -> tuple[list[int], list[int]]:
    """Returns the pairs, one to one, of rows and columns with the least sum of distances, none of which counts above CUTOFF."""
    rows, columns = linear_sum_assignment(np.minimum(distance, CUTOFF))
    return rows.tolist(), columns.tolist()
