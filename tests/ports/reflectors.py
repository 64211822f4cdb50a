"""Five reflectors as a turning ship meets them: batches that a port gets, and the truth of each crossing."""

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import numpy as np

import radar_service as rs
from radar_service.display.video import Controls
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch

START = datetime(2026, 12, 31, 23, 59, 59, tzinfo=UTC)
GAIN = Controls(gain=30.0, gain_auto=False, sea_auto=False)
PLACES = [(300, 20), (700, 80), (1000, 170), (1333, 250), (1700, 340)]  # m, and degrees from the map's north


def scene(azimuths: int = 720) -> dict[str, Any]:
    """Reflectors on a circle each, seen from a ship that turns to port; its heading is not that of the map."""
    bodies = []
    for number, (distance, bearing) in enumerate(PLACES):
        east, north = distance * np.sin(np.deg2rad(bearing)), distance * np.cos(np.deg2rad(bearing))
        place = [float(east), float(north), 10.0]
        bodies.append({"name": f"r{number}", "shape": "point", "rcs_dbsm": 12 + 3 * number, "position_m": place})
    return {
        "name": "reflectors", "origin": {"latitude_deg": 50.0, "longitude_deg": 1.0},
        "radar": {"azimuths": azimuths, "coarse_azimuths": True, "beamwidth_deg": 1.5, "range_max_m": 1852,
                  "pulse_s": 8e-8, "height_m": 10},
        "environment": {"noise": False, "multipath": False}, "body": bodies,
        "own_ship": {"course_deg": 33, "manoeuvre": [{"time_s": 0.1, "turn_rate_deg_s": -3.0}]},
    }  # fmt: skip


def simulator(azimuths: int = 720) -> rs.Simulator:
    return rs.Simulator(rs.load_scene(scene(azimuths)), "fast", 1)


def radar_of(source: Any, display_range: float | None = None) -> RadarInfo:
    """The first notice of an epoch."""
    return RadarInfo.unnamed(Epoch("e", source, display_range, start_utc=START))


def batches(radar: RadarInfo, source: Any, scans: int = 1, size: int = 16) -> Iterator[SpokeBatch]:
    first = 0
    for block in source.blocks(scans=scans, size=size):
        yield SpokeBatch(radar.epoch, first, block, GAIN)
        first += len(block)


def crossings(source: Any, scan: int = 0) -> list[dict[str, Any]]:
    lines = [json.loads(line.text) for line in source.truth_lines(scan)]
    return [line for line in lines if line["type"] == "crossing"]
