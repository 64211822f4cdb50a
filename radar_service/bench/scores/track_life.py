"""The life of tracks: when they begin and end, whether they keep their names, and what they hold through."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial import cKDTree

from radar_service.bench.scores.judged_scan import CUTOFF, JudgedRun, JudgedScan, distances, track_at
from radar_service.bench.scores.scan_result import Surroundings
from radar_service.bench.scores.sightings import LEAVING, MAX_GAP, Sightings

NOWHERE = Surroundings()


def life_scores(run: JudgedRun, around: Surroundings = NOWHERE) -> dict[str, float | None]:
    """Returns the metrics by name; None where a tracker owes an answer and has none. What a run cannot judge is left out.

    around: of what tracks may be false.
    """
    present = run.sightings.items()
    first = [_first_state(run, body, sightings) for body, sightings in present if sightings.owes_first_state]
    gone = [_gone(run, body, sightings) for body, sightings in present if _leaves(sightings)]
    return {
        "identity_changes": float(sum(_changes(run, body) for body in run.sightings)),
        **_worst("first_state_scans", first), **_worst("gone_scans", gone), **_bridged(run), **_false_tracks(run, around),
    }  # fmt: skip


def _worst(name: str, values: Sequence[float | None]) -> dict[str, float | None]:
    """The largest of the values under a name, None where one is missing; nothing without values."""
    numbers = [value for value in values if value is not None]
    return {name: max(numbers) if len(numbers) == len(values) else None} if values else {}


def _changes(run: JudgedRun, body: str) -> int:
    """How often the track of a target changed its name."""
    names = [scan.pairs[body] for scan in run.scans if body in scan.pairs]
    return sum(earlier != later for earlier, later in zip(names, names[1:], strict=False))


def _first_state(run: JudgedRun, body: str, sightings: Sightings) -> float | None:
    """The scan that has its first state, counted from 1 for the one that sees it first."""
    first = next((k for k, scan in enumerate(run.scans) if body in scan.pairs), None)
    return None if first is None else float(first - sightings.first + 1)


def _leaves(sightings: Sightings) -> bool:
    """Whether a target vanishes early enough to see its track end."""
    return sightings.has_vanished and sightings.scans - 1 - sightings.last > LEAVING


def _gone(run: JudgedRun, body: str, sightings: Sightings) -> float:
    """How many scans after it was seen last a track of it was still there, whatever its age. Tracks of it are those that it
    had in its last MAX_GAP scans, but for scans in which they follow another target."""
    begin = max(sightings.last - MAX_GAP, 0)
    names = {scan.pairs[body] for scan in run.scans[begin : sightings.last + 1] if body in scan.pairs}
    still = [
        k
        for k, scan in enumerate(run.scans)
        if names
        & {track.track for track in scan.result.tracks} - {scan.pairs[other] for other in scan.pairs if other != body}
    ]
    return float(max(still[-1] - sightings.last, 0)) if still else 0.0


def _bridged(run: JudgedRun) -> dict[str, float | None]:
    """The share of gaps of up to MAX_GAP scans through which a target that was held keeps a state, and its name."""
    held = [held for body, sightings in run.sightings.items() for held in _gaps(run, body, sightings)]
    return {"bridged": sum(held) / len(held)} if held else {}


def _gaps(run: JudgedRun, body: str, sightings: Sightings) -> Iterator[bool]:
    """Whether each gap of a target is bridged, of those that begin when it is settled."""
    for before, after in sightings.gaps:
        if after - before - 1 <= MAX_GAP and before >= sightings.settled:
            names = [scan.pairs.get(body) for scan in run.scans[before : after + 1]]
            yield None not in names and names[0] == names[-1]


def _false_tracks(run: JudgedRun, around: Surroundings) -> dict[str, float | None]:
    """How many names in an hour follow no target in some scan: those of land, and all others, which are of noise, sea or rain."""
    ghosts = [ghost for scan in run.scans for ghost in _ghosts(scan)]
    land = cKDTree(np.reshape(around.land, (-1, 2)))
    apart = np.atleast_1d(land.query(np.reshape([place for _, place in ghosts], (-1, 2)))[0])  # inf without land
    near = {name for (name, _), far in zip(ghosts, apart, strict=True) if far < CUTOFF}
    hours = run.scans[-1].result.given.time / 3600.0 if run.scans else 1.0
    others = {name for name, _ in ghosts} - near
    return {f"false_{around.clutter}_h": len(others) / hours, **({"false_land_h": len(near) / hours} if land.n else {})}


def _ghosts(scan: JudgedScan) -> Iterator[tuple[str, tuple[float, float]]]:
    """Names and places of the tracks within CUTOFF of no target, whatever their age."""
    tracks = [track_at(track, scan.result.given.time) for track in scan.result.tracks]
    apart = distances([*scan.truths.values()], tracks).min(axis=0, initial=np.inf)
    yield from ((track.track, (track.east, track.north)) for track, far in zip(tracks, apart, strict=True) if far >= CUTOFF)
