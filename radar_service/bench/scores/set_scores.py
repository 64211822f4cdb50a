"""How far the tracks of a run are from its targets, as a set: OSPA, GOSPA and its parts, SIAP, localisation."""

from collections.abc import Mapping, Sequence

import numpy as np

from radar_service.bench.scores.judged_scan import CUTOFF, JudgedRun, JudgedScan, assigned, distances

ORDER = 2.0
LAST = 20  # scans that `held` is averaged over, the last ones with a target that is due
POINT = 15.0  # m that a track of a point may be off; of a ship LENGTH_SHARE of its length where that is more
LENGTH_SHARE = 1.0 / 6.0  # the glint of A.823(19) appendix 3


def set_scores(run: JudgedRun) -> dict[str, float | None]:
    """Returns the metrics by name; None where there is nothing to judge."""
    due = [scan for scan in run.scans if scan.due]
    parts = [ospa_parts(scan) for scan in due]
    return {
        **{name: mean([part[name] for part in parts]) for name in PARTS},
        **_siap(run.scans),
        "position_error_m": mean([scan.distance[body] for scan in due for body in scan.due & scan.pairs.keys()]),
        "velocity_error_m_s": mean([velocity_error(scan, body) for scan in due for body in scan.due & scan.pairs.keys()]),
        "held": mean([len(scan.due & scan.pairs.keys()) / len(scan.due) for scan in due[-LAST:]]),
        **_localisation(due),
    }  # fmt: skip


PARTS = ("gospa_m", "gospa_localisation_m", "gospa_missed_m", "gospa_false_m", "ospa_m")


def ospa_parts(scan: JudgedScan) -> dict[str, float]:
    """Returns OSPA and GOSPA of the targets that are due in a scan [m], and what localisation, missed targets and false tracks
    have in GOSPA: the squares of the three add up to its square. A track of a target that is not due does not count.

    Source: Schuhmacher, Vo and Vo 2008, eq. 3; Rahmathullah, Garcia-Fernandez and Svensson 2017, eq. 1 with alpha = 2.
    """
    optional = {track for body, track in scan.pairs.items() if body not in scan.due}
    truths = [scan.truths[body] for body in sorted(scan.due)]
    tracks = [track for name, track in scan.tracks.items() if name not in optional]
    distance = distances(truths, tracks)
    near = [distance[i, j] for i, j in zip(*assigned(distance), strict=True) if distance[i, j] < CUTOFF]
    square, number = float(np.sum(np.square(near))), max(len(truths), len(tracks), 1)
    missed, false = len(truths) - len(near), len(tracks) - len(near)
    more = max(false - missed, 0)  # OSPA has a false track beside a missed target as one error
    return {
        "gospa_m": _root(square + CUTOFF**ORDER / 2.0 * (missed + false), 1), "gospa_localisation_m": _root(square, 1),
        "gospa_missed_m": _root(CUTOFF**ORDER / 2.0 * missed, 1), "gospa_false_m": _root(CUTOFF**ORDER / 2.0 * false, 1),
        "ospa_m": _root(square + CUTOFF**ORDER * (missed + more), number),
    }  # fmt: skip


def _root(total: float, number: int) -> float:
    return float((total / number) ** (1.0 / ORDER))


def _siap(scans: Sequence[JudgedScan]) -> dict[str, float | None]:
    """SIAP: completeness of the targets that are due; ambiguity and spuriousness of the tracks of all scans."""
    due, held = sum(len(scan.due) for scan in scans), sum(len(scan.due & scan.pairs.keys()) for scan in scans)
    tracks, near = sum(len(scan.tracks) for scan in scans), sum(len(scan.near) for scan in scans)
    paired = sum(len(scan.pairs) for scan in scans)
    return {
        "completeness": held / due if due else None,
        "ambiguity": near / paired if paired else None,
        "spurious": (tracks - near) / tracks if tracks else 0.0,
    }


def velocity_error(scan: JudgedScan, body: str) -> float:
    """Returns the length [m/s] of the difference of velocities of a target and its track, as own ship reports both."""
    truth, track = scan.truths[body], scan.tracks[scan.pairs[body]]
    return float(np.hypot(track.velocity_east - truth.velocity[0], track.velocity_north - truth.velocity[1]))


def allowed_distance(length: float) -> float:
    """Returns how far a track may be on average [m] from a target of a length [m], 0 for a point."""
    return max(POINT, LENGTH_SHARE * length)


def _localisation(due: Sequence[JudgedScan]) -> dict[str, float | None]:
    """The mean distance of the worst target [m], and the largest share that such a mean has of what is allowed."""
    held: dict[str, list[float]] = {body: [] for scan in due for body in scan.due}
    length: Mapping[str, float] = {body: scan.truths[body].length for scan in due for body in scan.due}
    for scan in due:
        for body in scan.due & scan.pairs.keys():
            held[body].append(scan.distance[body])
    if not all(held.values()) or not held:
        return {"localisation_m": None, "localisation_share": None} if held else {}
    means = {body: float(np.mean(some)) for body, some in held.items()}
    shares = [mean / allowed_distance(length[body]) for body, mean in means.items()]
    return {"localisation_m": max(means.values()), "localisation_share": max(shares)}


def mean(values: Sequence[float]) -> float | None:
    """Returns the mean; None of nothing."""
    return float(np.mean(values)) if values else None
