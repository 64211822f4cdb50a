"""What goes wrong in a run, scan by scan: swaps, breaks, late first states, ghosts, duplicates."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from radar_service.bench.scores.association_scores import associations
from radar_service.bench.scores.judged_scan import JudgedRun, JudgedScan, distances
from radar_service.bench.scores.sightings import FIRST_STATE, Sightings

Kind = Literal["swap", "break", "late", "stale", "ghost", "duplicate", "misassociated", "unassociated", "priority"]
KINDS: tuple[Kind, ...] = get_args(Kind)  # the gravest first


@dataclass(frozen=True)
class Event:
    """An error of a tracker.

    kind: "swap", a track goes over to another target; "break", a target loses its track, or has another one; "late", a target
    has no state FIRST_STATE scans after it is seen first; "stale", a target has only a state that is too old; "ghost", a track
    of nothing; "duplicate", a track beside another one; the others as of an Association. scan, last: the first and the last
    scan. body: the target, empty for a ghost that never had one; other: the one it swaps with. what: a sentence.
    """

    kind: Kind
    scan: int
    last: int
    body: str
    other: str
    what: str


def events_of(run: JudgedRun) -> list[Event]:
    """Returns all events of a run, by scan, the gravest first."""
    of_targets = [event for body, sightings in run.sightings.items() for event in _of_target(run, body, sightings)]
    events = [*_renamed(run), *of_targets, *_ghosts(run), *_duplicates(run), *_associations(run)]
    return sorted(events, key=lambda event: (event.scan, KINDS.index(event.kind), event.body))


def gravest(events: Sequence[Event], count: int) -> list[Event]:
    """Returns the gravest events, by kind, then the longest, in the order in which they came."""
    by_gravity = sorted(events, key=lambda event: (KINDS.index(event.kind), event.scan - event.last))
    return [event for event in events if event in by_gravity[:count]]


def _renamed(run: JudgedRun) -> Iterator[Event]:
    """A swap or a break where a target has another track than before, and where its first one was another target's. Two
    targets that swap in one scan are one event."""
    name_of: dict[str, str] = {}
    target_of: dict[str, str] = {}
    for number, scan in enumerate(run.scans):
        done: set[str] = set()
        for body, track in scan.pairs.items():
            before, other = name_of.get(body), target_of.get(track, body)
            if other != body and body not in done:
                mutual = scan.pairs.get(other) == before is not None and target_of.get(before) == body
                done.update((body, other) if mutual else (body,))
                taken = f"{body} takes track {track} of {other}"
                what = f"{body} and {other} swap tracks {before} and {track}" if mutual else taken
                yield Event("swap", number, number, body, other, what)
            elif other == body and before not in (None, track):
                yield Event("break", number, number, body, "", f"{body} has track {track} in place of {before}")
        name_of |= scan.pairs
        target_of |= {track: body for body, track in scan.pairs.items()}


def _of_target(run: JudgedRun, body: str, sightings: Sightings) -> Iterator[Event]:
    """Whether it is late, and where it is lost after its first state; what has a state that is too old is neither."""
    begin = next((k for k, scan in enumerate(run.scans) if body in scan.pairs), len(run.scans))
    owed, until = sightings.first + FIRST_STATE - 1, min(begin - 1, sightings.last)
    late = range(owed, until + 1) if sightings.owes_first_state else range(0)
    lost = [k for k in sorted(sightings.due) if k > begin and body not in run.scans[k].pairs]
    old = {k for k in (*late, *lost) if body in run.scans[k].stale}
    for first, last in _stretches([k for k in late if k not in old]):
        yield Event("late", first, last, body, "", f"{body} has no first state")
    for first, last in _stretches([k for k in lost if k not in old]):
        yield Event("break", first, last, body, "", f"{body} has no track")
    for first, last in _stretches(sorted(old)):
        track, age = run.scans[last].stale[body]
        what = f"state of {age:.1f} s ago; say coasting, or move it on (track {track} of {body})"
        yield Event("stale", first, last, body, "", what)


def _ghosts(run: JudgedRun) -> Iterator[Event]:
    """Tracks that are within reach of no target, with the target that they had before."""
    followed: dict[str, list[tuple[int, str]]] = {}
    for number, scan in enumerate(run.scans):
        for body, track in scan.pairs.items():
            followed.setdefault(track, []).append((number, body))
    for track, first, last in _of_tracks([scan.tracks.keys() - scan.near for scan in run.scans]):
        body = next((name for number, name in reversed(followed.get(track, [])) if number < first), "")
        yield Event("ghost", first, last, body, "", f"track {track} follows nothing" + (f", before {body}" if body else ""))


def _duplicates(run: JudgedRun) -> Iterator[Event]:
    """Tracks near a target that has another one."""
    for track, first, last in _of_tracks([scan.near - {*scan.pairs.values()} for scan in run.scans]):
        scan = run.scans[first]
        body = _nearest_target(scan, track)
        beside = f" beside {scan.pairs[body]}" if body in scan.pairs else ""
        yield Event("duplicate", first, last, body, "", f"track {track} follows {body}{beside}")


def _associations(run: JudgedRun) -> Iterator[Event]:
    """Errors of association and priority, over scans in a row."""
    scans: dict[tuple[Kind, str, str], list[int]] = {}
    for number, results in enumerate(associations(run)):
        for result in results:
            if result.kind != "right":
                scans.setdefault((result.kind, result.body, result.what), []).append(number)
    for (kind, body, what), numbers in scans.items():
        yield from (Event(kind, first, last, body, "", what) for first, last in _stretches(numbers))


def _nearest_target(scan: JudgedScan, track: str) -> str:
    near = distances([*scan.truths.values()], [scan.tracks[track]])[:, 0]
    return [*scan.truths][int(near.argmin())]


def _of_tracks(scans: Sequence[Iterable[str]]) -> Iterator[tuple[str, int, int]]:
    """Each track of the given ones of each scan, with the first and the last of scans in a row."""
    of: dict[str, list[int]] = {}
    for number, tracks in enumerate(scans):
        for track in sorted(tracks):
            of.setdefault(track, []).append(number)
    return ((track, first, last) for track, numbers in of.items() for first, last in _stretches(numbers))


def _stretches(numbers: Sequence[int]) -> Iterator[tuple[int, int]]:
    """The first and the last of each row of numbers that follow each other."""
    those = {*numbers}
    begins = [number for number in numbers if number - 1 not in those]
    ends = [number for number in numbers if number + 1 not in those]
    return zip(begins, ends, strict=True)
