"""The cells of a plot about its peak: the gate in which the truth measures where the power of a ship lies (docs/truth.md)."""

from dataclasses import replace

import numpy as np

from radar_service.numerics.types import Flags, Indices
from radar_service.plots.clusters import ClusterRule, clusters
from radar_service.plots.detections import Detections
from radar_service.plots.groups import Groups

NEIGHBOURS = ClusterRule(1, 1)  # over corners too, as in the truth


def about_peak(detections: Detections, part: Indices, gate_db: float) -> Flags:
    """Returns which detections (C,) are within `gate_db` of the strongest of their part, and connect with it.

    part: the number (C,) of the part of each detection, from 0.
    """
    if not len(detections):
        return np.empty(0, dtype=np.bool_)
    groups = Groups(part)
    peak = groups.strongest(detections.power)[groups.of_each]
    strong = detections.power >= detections.power[peak] * 10.0 ** (-gate_db / 10.0)
    apart = (np.ptp(detections.spoke) + 2) * groups.of_each  # parts of one cluster may touch; here no two do
    label = np.full(len(part), -1, dtype=np.int64)
    label[strong] = clusters(replace(detections, spoke=detections.spoke + apart).only(strong), NEIGHBOURS)
    return np.asarray(label == label[peak], dtype=np.bool_)
