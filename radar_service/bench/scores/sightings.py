"""When a target can be seen, and when a tracker owes a state of it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from radar_service.bench.scores.scan_result import ScanResult, TargetTruth

ACQUISITION = 60.0  # s after a target is seen first, before it counts in OSPA and completeness: MSC.192(79) 5.25.4
MAX_GAP = 5  # scans in a row that a target may be missed and must be held
LEAVING = 20  # scans that a track may stay after its target has vanished
FIRST_STATE = 10  # scans within which a target that is seen has a state


@dataclass(frozen=True)
class Sightings:
    """A target in the scans of a run, which are numbered from 0. seen: those in which it is visible; scans: their number;
    settled: the first one that ends ACQUISITION after it is seen first. At least one scan has seen it."""

    seen: tuple[int, ...]
    scans: int
    settled: int

    @property
    def first(self) -> int:
        """The scan that sees it first."""
        return self.seen[0]

    @property
    def has_vanished(self) -> bool:
        """Whether it is gone at the end, for more scans than a target may be missed."""
        return self.scans - 1 - self.seen[-1] > MAX_GAP

    @property
    def last(self) -> int:
        """The last scan in which it is to be held."""
        return self.seen[-1] if self.has_vanished else self.scans - 1

    def may_have_track(self, scan: int) -> bool:
        """Whether a track of it is none too many."""
        return self.first <= scan <= self.last + LEAVING

    @property
    def owes_first_state(self) -> bool:
        """Whether it is there for long enough."""
        return self.last - self.first >= FIRST_STATE

    @property
    def gaps(self) -> Iterator[tuple[int, int]]:
        """Pairs of scans that see it, with scans between them that do not."""
        return ((a, b) for a, b in zip(self.seen, self.seen[1:], strict=False) if b - a > 1)

    @cached_property
    def due(self) -> frozenset[int]:
        """Scans in which a state is owed: not while it is missed for longer than MAX_GAP, and FIRST_STATE scans after that."""
        lost = {k for a, b in self.gaps if b - a - 1 > MAX_GAP for k in range(a + 1, b + FIRST_STATE)}
        return frozenset(range(self.settled, self.last + 1)) - lost


def sightings_of(results: Sequence[ScanResult]) -> dict[str, Sightings]:
    """Returns the sightings of each target of a run that any scan sees, by its name."""
    by_body: dict[str, list[tuple[int, TargetTruth]]] = {}
    for scan, result in enumerate(results):
        for truth in result.truths:
            if truth.visible:
                by_body.setdefault(truth.body, []).append((scan, truth))
    ends = [result.given.time for result in results]
    return {body: _sightings(seen, ends) for body, seen in by_body.items()}


def _sightings(seen: Sequence[tuple[int, TargetTruth]], ends: Sequence[float]) -> Sightings:
    begin = seen[0][1].time + ACQUISITION
    settled = next((scan for scan, end in enumerate(ends) if end >= begin), len(ends))
    return Sightings(tuple(scan for scan, _ in seen), len(ends), settled)
