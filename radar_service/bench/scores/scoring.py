"""All metrics of a run: of its plots, and of its tracks.

Where the power of an extended target lies, not at its reference point, is measured here: no tracker can
know the one from the other.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radar_service.bench.scores.acquisition import acquisition_scores
from radar_service.bench.scores.association_scores import association_scores
from radar_service.bench.scores.judged_scan import JudgedRun, judged
from radar_service.bench.scores.motion_scores import motion_scores, percentile_95
from radar_service.bench.scores.plot_scores import plot_metrics
from radar_service.bench.scores.scan_result import ScanResult, Surroundings, TargetTruth
from radar_service.bench.scores.set_scores import set_scores
from radar_service.bench.scores.track_life import NOWHERE, life_scores
from radar_service.bench.scores.warnings import warning_scores

CROSSINGS = 5  # on each side of a crossing; the centroid of a single one jumps (glint), and no tracker can follow that


def metrics_of(
    results: Sequence[ScanResult], around: Surroundings = NOWHERE, centred: JudgedRun | None = None
) -> dict[str, float | None]:
    """Returns the metrics of a run by name, extended targets at the mean centroid of their power. around: of what tracks may be
    false; centred: the run as it is judged, where it is known."""
    run = centred or judged(at_power_centroids(results))
    return {**scores(run, around), **effort(results), **plot_metrics([scan.result for scan in run.scans])}


def effort(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """Returns the time of 95 % of the answers, in turns of the antenna, and the growth of memory a scan [MB] in the second half
    of a run."""
    if not results or not any(result.seconds for result in results):
        return {}
    period = results[-1].given.time / (results[-1].given.scan + 1)
    turns: dict[str, float | None] = {"answer_turns": percentile_95([result.seconds for result in results]) / period}
    later = [result.memory for result in results[len(results) // 2 :] if result.memory]
    return turns | ({"growth_mb": (later[-1] - later[0]) / 1e6 / (len(later) - 1)} if len(later) > 1 else {})


def scores(run: JudgedRun, around: Surroundings = NOWHERE) -> dict[str, float | None]:
    """Returns the metrics of tracks by name. None: the tracker owes an answer and has none, or nothing is to be judged. What a
    run cannot judge, as a turn where nobody turns, is left out."""
    return {
        **set_scores(run), **life_scores(run, around), **motion_scores(run), **warning_scores(run), **association_scores(run),
        **acquisition_scores(run),
    }  # fmt: skip


def at_power_centroids(results: Sequence[ScanResult]) -> list[ScanResult]:
    """Returns a run whose extended targets stand at the mean centroid of their power, in the hull's frame.

    The mean is over the crossings of up to CROSSINGS scans before and after. A point stays where it is, and so does a target
    without power in all of these scans.
    """
    near = [results[max(0, number - CROSSINGS) : number + CROSSINGS + 1] for number in range(len(results))]
    pairs = zip(results, near, strict=True)
    return [replace(result, truths=tuple(_moved(truth, some) for truth in result.truths)) for result, some in pairs]


def _moved(truth: TargetTruth, near: Sequence[ScanResult]) -> TargetTruth:
    """A target at the mean of its centroids in these scans, with its heading of this one."""
    if not truth.length:
        return truth
    same = (then for result in near for then in result.truths if then.body == truth.body)
    if not (offsets := [then.centroid for then in same if then.centroid]):
        return truth
    along, across = np.mean(offsets, axis=0).tolist()
    sine, cosine = np.sin(truth.heading), np.cos(truth.heading)
    east, north = truth.position
    moved = east + along * sine + across * cosine, north + along * cosine - across * sine
    return replace(truth, position=(float(moved[0]), float(moved[1])))
