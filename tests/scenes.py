"""Small scenes that tests share."""

from typing import Any

import radar_service as rs
from radar_service.radar.parameters import Radar

ONE_TARGET: dict[str, Any] = {
    "name": "one target",
    "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "body": [{"name": "p", "shape": "point", "position_m": [0, 300, 10], "rcs_dbsm": 10}],
}


def scene(bodies: list[dict[str, Any]] | None = None, **sections: Any) -> rs.Scene:
    """A scene of these bodies; sections: radar, own_ship, environment as mappings."""
    return rs.load_scene({"name": "test", "body": bodies or [], **sections})


def radar(**settings: Any) -> Radar:
    """A radar with these settings of the scene file."""
    return scene(radar=settings).radar


def point(name: str, east: float, north: float, up: float = 15.0, rcs_dbsm: float = 10.0, **more: Any) -> dict[str, Any]:
    """A point body; by default as high as the default antenna."""
    return {"name": name, "shape": "point", "position_m": [east, north, up], "rcs_dbsm": rcs_dbsm, **more}
