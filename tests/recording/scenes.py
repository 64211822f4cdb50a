"""What the tests of recordings record: a small scene in which everything moves, and its spokes as a client has them."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import radar_service as rs
from radar_service import wire
from radar_service.commands.record import record_scans
from radar_service.recording.radar_recording import NOTHING, RadarRecording
from radar_service.recording.recording_file import RecordingFile
from radar_service.records.cell_sources import SourceRequest

AZIMUTHS, SEED = 64, 5
MOVING: dict[str, Any] = {
    "name": "two ships",
    "origin": {"latitude_deg": 50.0, "longitude_deg": 1.0},
    "radar": {"azimuths": AZIMUTHS, "beamwidth_deg": 8, "range_max_m": 250, "rpm": 33, "pulse_s": 1e-6,
              "blind_sectors_deg": [[90, 180]], "height_m": 12},
    "own_ship": {"heading_deg": 0, "speed_kn": 7, "course_deg": 10},
    "environment": {"noise": True},
    "body": [
        {"name": "a", "shape": "point", "position_m": [60, 90, 5], "rcs_dbsm": 10, "swerling": 1, "speed_kn": 20,
         "course_deg": 300},
        {"name": "b", "shape": "point", "position_m": [-80, 20, 5], "rcs_dbsm": 5, "speed_kn": 10, "course_deg": 90},
    ],
}  # fmt: skip


def simulator(fidelity: str = "balanced") -> rs.Simulator:
    return rs.Simulator(rs.load_scene(MOVING), fidelity, SEED)


def recorded(
    path: Path, scans: int = 3, fidelity: str = "balanced", with_truth: bool = True, told: SourceRequest = NOTHING
) -> Path:
    """A recording of its first scans. told: of their sources."""
    with RecordingFile(path) as file:
        made = simulator(fidelity)
        made.request_sources(told.labels, told.powers)
        record_scans(RadarRecording(file, "0", with_truth, told), made, MOVING, scans, with_truth)
    return path


def spokes_of(messages: Iterable[bytes]) -> list[dict[str, Any]]:
    """Every spoke of the `spokes` messages of a feed, with all that a client has of it but for the name of the epoch."""
    spokes = []
    for message in (wire.unpack(data) for data in messages):
        if message["type"] == "spokes":
            of_all = {key: message[key] for key in ("scan", "bins", "range_step_m", "range_first_m", "range", "encoding")}
            lists = {key: message[key] for key in ("time", "azimuth", "heading", "position", "course", "speed")}
            samples, rows = wire.samples(message), message.get("row_first", range(message["count"]))
            blind = message.get("blind", [False] * len(samples))
            spokes += [
                {"number": message["first"] + row, "index": message["index"] + row, "data": samples[k].tobytes()}
                | of_all | {"blind": blind[k]} | {key: value[k] for key, value in lists.items()}
                for k, row in enumerate(rows)
            ]  # fmt: skip
    return spokes
