"""Truth where the power of an extended target lies, not at her reference point: no tracker can know the one from the other."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radar_service.tracking.scoring import ScanResult, TargetTruth

CROSSINGS = 5  # on each side of a crossing; the centroid of a single one jumps (glint), and no tracker can follow that


def at_power_centroids(results: Sequence[ScanResult]) -> list[ScanResult]:
    """Returns a run whose extended targets stand at the mean centroid of their power, in the hull's frame.

    The mean is over the crossings of up to CROSSINGS scans before and after. A point stays where it is, and so does a target
    without power in all of these scans.
    """
    moved = []
    for number, result in enumerate(results):
        near = results[max(0, number - CROSSINGS) : number + CROSSINGS + 1]
        moved.append(replace(result, truths=tuple(_moved(truth, near) for truth in result.truths)))
    return moved


def _moved(truth: TargetTruth, near: Sequence[ScanResult]) -> TargetTruth:
    """A target at the mean of its centroids in these scans, with her heading of this one."""
    offsets = [one.centroid for result in near for one in result.truths if one.body == truth.body and one.centroid]
    if not offsets:
        return truth
    along, across = np.mean(offsets, axis=0).tolist()
    sine, cosine = np.sin(truth.heading), np.cos(truth.heading)
    east, north = truth.position
    return replace(
        truth, position=(float(east + along * sine + across * cosine), float(north + along * cosine - across * sine))
    )
