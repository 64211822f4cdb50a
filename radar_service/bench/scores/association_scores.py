"""Which AIS target is associated with which track, and whose data are displayed: MSC.192(79) 5.30.

An MMSI is owed to the track of the target that it reports, and wrong on any other, from SETTLED after its first report of this
target on. Of an associated target the data of AIS are displayed, of others those of the radar.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from radar_service.bench.scores.judged_scan import JudgedRun, JudgedScan

SETTLED = 60.0  # s, in which motion is known: MSC.192(79) 5.25.4
SILENT = 60.0  # s without a report, after which an association is no longer owed
AssociationKind = Literal["right", "misassociated", "unassociated", "priority"]


@dataclass(frozen=True)
class Association:
    """An MMSI, or the priority of a track, in one scan.

    kind: "misassociated": on a track of another target; "unassociated": on no track; "priority": data of the other sensor.
    body: the target, empty: none. is_owed: whether a track should have the MMSI. what: a sentence.
    """

    kind: AssociationKind
    body: str
    is_owed: bool
    what: str


@dataclass(frozen=True)
class _Claim:
    """The target that an MMSI reports, if any; since when, and its last report [s]."""

    body: str | None
    since: float
    last: float


def association_scores(run: JudgedRun) -> dict[str, float | None]:
    """Returns the metrics by name, without what a tracker never says."""
    tracks = [track for scan in run.scans for track in scan.result.tracks]
    results = [result for scan in associations(run) for result in scan]
    count = {kind: sum(result.kind == kind for result in results) for kind in ("right", "misassociated", "priority")}
    associated, owed = count["right"] + count["misassociated"], [result.kind for result in results if result.is_owed]
    scores: dict[str, float | None] = {}
    if any(track.mmsi is not None for track in tracks):
        scores |= {"ais_wrong": count["misassociated"] / associated} if associated else {}
        shares = {"ais_right": owed.count("right"), "ais_missed": owed.count("unassociated")}
        scores |= {name: number / len(owed) for name, number in shares.items() if owed}
    return scores | ({"priority_errors": float(count["priority"])} if any(track.priority for track in tracks) else {})


def associations(run: JudgedRun) -> Iterator[list[Association]]:
    """Yields what is judged in each scan; nothing of MMSIs where no track ever has one."""
    claims: dict[int, _Claim] = {}
    says = any(track.mmsi is not None for scan in run.scans for track in scan.result.tracks)
    for scan in run.scans:
        end = scan.result.given.time
        for report, body in zip(scan.result.given.ais or (), scan.result.ais_of, strict=True):
            known = claims.get(report.mmsi)
            claims[report.mmsi] = _Claim(body, known.since if known and known.body == body else end, end)
        settled = {mmsi: claim for mmsi, claim in claims.items() if end - claim.since >= SETTLED}
        results = [result for mmsi, claim in settled.items() if says and (result := _judged(scan, mmsi, claim))]
        yield [*results, *_priorities(scan)]


def _judged(scan: JudgedScan, mmsi: int, claim: _Claim) -> Association | None:
    """Whether an MMSI is on the track of its target; None: not judged."""
    target_of = {track: body for body, track in scan.pairs.items()}
    track = next((track.track for track in scan.result.tracks if track.mmsi == mmsi), None)
    is_present = claim.body in scan.due and claim.body in scan.pairs
    is_owed = is_present and scan.result.given.time - claim.last <= SILENT
    if track is None:
        what = f"track {scan.pairs.get(claim.body or '')} of {claim.body} has no MMSI, but {mmsi} reports this target"
        return Association("unassociated", claim.body or "", True, what) if is_owed else None
    body = target_of.get(track, "")
    if claim.body is not None and body == claim.body:
        return Association("right", body, is_owed, "")
    if claim.body is not None and not (body or is_present):
        return None  # neither the track nor the target of the reports can be judged
    what = f"track {track} of {body or 'no target'} has MMSI {mmsi}, which reports {claim.body or 'no target that is there'}"
    return Association("misassociated", body, is_owed, what)


def _priorities(scan: JudgedScan) -> Iterator[Association]:
    for track in scan.result.tracks:
        if track.priority is not None and (track.priority == "ais") != (track.mmsi is not None):
            what = f"track {track.track} displays {track.priority}, {'with' if track.mmsi else 'without'} an MMSI"
            yield Association("priority", "", False, what)
