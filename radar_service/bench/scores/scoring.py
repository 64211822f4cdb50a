"""All metrics of the tracks of a run."""

from collections.abc import Sequence

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.motion_scores import motion_scores
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.set_scores import set_scores
from radar_service.bench.scores.track_life import life_scores


def scores(results: Sequence[ScanResult]) -> dict[str, float | None]:
    """Returns the metrics of a run by name. None: the tracker owes an answer and has none, or nothing is to be judged. What a
    run cannot judge, as a turn where nobody turns, is left out."""
    run = judged(results)
    return {**set_scores(run), **life_scores(run), **motion_scores(run)}
