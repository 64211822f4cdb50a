"""A small turning ship whose reports tests compare with the truth."""

from typing import Any

import numpy as np

import radar_service as rs
from radar_service.records.spokes import SpokeBlock, joined

AZIMUTHS = 64
SCENE: dict[str, Any] = {
    "name": "errors", "radar": {"azimuths": AZIMUTHS, "beamwidth_deg": 8, "range_max_m": 256, "rpm": 60, "pulse_s": 1e-6},
    "own_ship": {"waypoints": [{"position_m": place, "speed_kn": 10} for place in ([0, 6], [6, 6], [6, 0], [0, 0])],
                 "turn_radius_m": 2, "loop": True},
    "body": [{"name": "buoy", "shape": "point", "position_m": [60, 90, 5], "rcs_dbsm": 20, "mmsi": 1},
             {"name": "before north", "shape": "point", "position_m": [-2, 240, 5], "rcs_dbsm": 20}],
    "environment": {"noise": True},
}  # fmt: skip


def simulator(errors: Any = None, seed: int = 5, **changes: Any) -> rs.Simulator:
    """A simulator of the scene with these errors."""
    return rs.Simulator(rs.load_scene(SCENE | changes | ({"errors": errors} if errors else {})), "fast", seed)


def whole(simulator: rs.Simulator, scans: int = 1) -> SpokeBlock:
    """The spokes of the next scans as one block."""
    return joined(list(simulator.blocks(scans)))


def same(one: SpokeBlock, other: SpokeBlock) -> bool:
    """Whether two blocks report the same, to the bit."""
    names = ("time", "azimuth", "heading", "position", "course", "speed", "field", "power")
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in names)
