"""What a tracker says of danger and of itself, judged where it says it: CPA and TCPA, alarms, lost targets, a full table.

Nothing is judged before three minutes, nor within the errors of table 3 of MSC.192(79).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from radar_service.bench.scores.judged_scan import JudgedRun, JudgedScan
from radar_service.bench.trackers.tracker import CPA_LIMIT, TCPA_LIMIT, TrackState
from radar_service.numerics import NAUTICAL_MILE
from radar_service.truth.crossings import closest_approach

SETTLED = 180.0  # s after a target is seen first
CPA_ERROR, TCPA_ERROR = 0.3 * NAUTICAL_MILE, 30.0  # m, s: table 3, three minutes
CAPACITY = 20  # tracks of the smallest radar: table 1


def warning_scores(run: JudgedRun) -> dict[str, float | None]:
    """Returns the metrics by name. What a tracker never says, or no target can be judged by, is left out."""
    states = [_said(run, body) for body in run.sightings]
    cpa = [abs(track.cpa - true) / NAUTICAL_MILE for some in states for track, true, _ in some if track.cpa is not None]
    tcpa = [abs(track.tcpa - true) / 60.0 for some in states for track, _, true in some if track.tcpa is not None]
    alarms = [alarm for some in states if (alarm := _alarms(some))]
    errors = {"lost_errors": [*_lost(run)], "full_errors": [*_full(run)], "false_alarms": [false for _, false, _ in alarms]}
    late = [late for late, _, _ in alarms if late is not None]
    lead = [lead for _, _, lead in alarms if lead is not None]
    return {
        **{name: float(sum(some)) for name, some in errors.items() if some},
        **({"alarm_late_scans": max(late)} if late else {}), **({"alarm_lead_min": min(lead) / 60.0} if lead else {}),
        **{
            name: float(np.percentile(some, 95.0, method="higher"))
            for name, some in {"said_cpa_nm": cpa, "said_tcpa_min": [*filter(np.isfinite, tcpa)]}.items() if some
        },
    }  # fmt: skip


def _said(run: JudgedRun, body: str) -> list[tuple[TrackState, float, float]]:
    """The tracks of a target from SETTLED on, with its true CPA [m] and TCPA [s] at the end of their scans."""
    begin = run.scans[run.sightings[body].first].result.given.time + SETTLED
    scans = [scan for scan in run.scans if scan.result.given.time >= begin and body in scan.due & scan.pairs.keys()]
    return [(scan.tracks[scan.pairs[body]], *true_approach(scan, body)) for scan in scans]


def true_approach(scan: JudgedScan, body: str) -> tuple[float, float]:
    """Returns CPA [m] and TCPA [s] of a target from the end of a scan as they truly are; a TCPA of nan: it keeps its range."""
    truth = next(truth for truth in scan.result.truths if truth.body == body)
    velocity = np.subtract(truth.velocity, truth.own_velocity)
    offset = np.subtract(truth.position, truth.own_position) + (scan.result.given.time - truth.time) * velocity
    (cpa,), (tcpa,) = closest_approach(offset[None], velocity[None])
    return float(cpa), float(tcpa)


def _alarms(states: Sequence[tuple[TrackState, float, float]]) -> tuple[float | None, bool, float | None] | None:
    """How many scans the alarm of a target is late, None where none is due; whether one is false; and its true TCPA [s] at the
    first alarm within the limits of CPA, None where none is."""
    alarms = [track.alarm for track, _, _ in states]
    if all(alarm is None for alarm in alarms):
        return None
    within = [cpa <= CPA_LIMIT - CPA_ERROR and TCPA_ERROR <= tcpa <= TCPA_LIMIT - TCPA_ERROR for _, cpa, tcpa in states]
    beyond = [cpa > CPA_LIMIT + CPA_ERROR or tcpa < -TCPA_ERROR or tcpa > TCPA_LIMIT + TCPA_ERROR for _, cpa, tcpa in states]
    due = within.index(True) if True in within else None
    late = None if due is None else next((k for k, alarm in enumerate(alarms[due:]) if alarm), len(alarms) - due)
    lead = next((tcpa for track, cpa, tcpa in states if track.alarm and cpa <= CPA_LIMIT and tcpa >= 0.0), None)
    return late, any(alarm and far for alarm, far in zip(alarms, beyond, strict=True)), lead


def _lost(run: JudgedRun) -> Iterator[bool]:
    """Whether each track of a target ends without a word within two scans, and each lost one goes on in the next."""
    lost = [scan.lost or frozenset() for scan in run.scans]
    if all(scan.lost is None for scan in run.scans):
        return
    names = [{track.track for track in scan.result.tracks} for scan in run.scans]
    last = {name: k for k, some in enumerate(names) for name in some}
    for name in {name for scan in run.scans for name in scan.pairs.values()}:
        if (k := last[name]) < len(names) - 2:  # else the word may still come
            yield not any(name in warned for warned in lost[k + 1 : k + 3])
    for k, warned in enumerate(lost[:-1]):
        yield from (name in names[k + 1] | lost[k + 1] for name in warned)


def _full(run: JudgedRun) -> Iterator[bool]:
    """Whether each scan leaves a target out of a full table without a word, or calls one below CAPACITY full."""
    tracks = [scan.result.tracks for scan in run.scans]
    if all(track.full is None for some in tracks for track in some):
        return
    most = max(CAPACITY, *map(len, tracks))
    for some, scan in zip(tracks, run.scans, strict=True):
        is_short = len(some) >= most and bool(scan.due - scan.pairs.keys())
        yield len(some) < CAPACITY if any(track.full for track in some) else is_short
