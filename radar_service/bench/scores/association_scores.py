"""Which AIS target is associated with which track, and whose data are displayed: MSC.192(79) 5.30.

One physical target is one: an MMSI is owed to the track of the target whose state it reports (5.30.1), and is wrong on any other
(5.30.3). Nothing is judged before it has reported one target for SETTLED, nor after its reports ended.
Of an associated target the data of AIS are displayed, of any other those of the radar (5.30.1; no user changes it: 5.30.2).
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
    """What is right or wrong in a scan of one MMSI, or of the priority of one track.

    kind: "misassociated": on a track of another target; "unassociated": on no track; "priority": data of the other sensor.
    body: the target of the track, or of the reports; empty: none. is_owed: whether the MMSI is owed to a track. what: a sentence.
    """

    kind: AssociationKind
    body: str
    is_owed: bool
    what: str


@dataclass(frozen=True)
class _Claim:
    """The target that an MMSI reports, None: none that is there; since when it does, and its last report [s]."""

    body: str | None
    since: float
    last: float


def association_scores(run: JudgedRun) -> dict[str, float | None]:
    """Returns the metrics by name. What a tracker never says, or no target can be judged by, is left out."""
    tracks = [track for scan in run.scans for track in scan.result.tracks]
    found = [one for scan in associations(run) for one in scan]
    count = {kind: sum(one.kind == kind for one in found) for kind in ("right", "misassociated", "priority")}
    said, owed = count["right"] + count["misassociated"], [one.kind for one in found if one.is_owed]
    scores: dict[str, float | None] = {}
    if any(track.mmsi is not None for track in tracks):
        scores |= {"ais_wrong": count["misassociated"] / said} if said else {}
        shares = {"ais_right": owed.count("right"), "ais_missed": owed.count("unassociated")}
        scores |= {name: number / len(owed) for name, number in shares.items() if owed}
    return scores | ({"priority_errors": float(count["priority"])} if any(track.priority for track in tracks) else {})


def associations(run: JudgedRun) -> Iterator[list[Association]]:
    """Yields what is judged in each scan; nothing of MMSIs where no track of the run ever has one."""
    claims: dict[int, _Claim] = {}
    says = any(track.mmsi is not None for scan in run.scans for track in scan.result.tracks)
    for scan in run.scans:
        end = scan.result.given.time
        for report, body in zip(scan.result.given.ais or (), scan.result.ais_of, strict=True):
            known = claims.get(report.mmsi)
            claims[report.mmsi] = _Claim(body, known.since if known and known.body == body else end, end)
        settled = {mmsi: claim for mmsi, claim in claims.items() if end - claim.since >= SETTLED}
        found = [one for mmsi, claim in settled.items() if says and (one := _judged(scan, mmsi, claim))]
        yield [*found, *_priorities(scan)]


def _judged(scan: JudgedScan, mmsi: int, claim: _Claim) -> Association | None:
    """Whether an MMSI is on the track of its target; None where neither is to be said."""
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
