"""The cells of a plot about its peak: the gate in which the truth measures where the power of a ship lies (docs/truth.md)."""

import numpy as np

from radar_service.tracking.clusters import ClusterRule, clusters
from radar_service.tracking.detections import Detections

NEIGHBOURS = ClusterRule(1, 1)  # over corners too, as in the truth


def about_peak(detections: Detections, gate_db: float) -> Detections:
    """Returns the detections of a plot within `gate_db` of its strongest that connect with it."""
    strong = detections.only(detections.power >= detections.power.max() * 10.0 ** (-gate_db / 10.0))
    label = clusters(strong, NEIGHBOURS)
    return strong.only(np.asarray(label == label[int(strong.power.argmax())], dtype=np.bool_))
