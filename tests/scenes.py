"""Small scenes that tests share."""

from typing import Any

import radar_service as rs
from radar_service.radar.parameters import Radar
from radar_service.scene_file.document import scene_content, scene_path

ONE_TARGET: dict[str, Any] = {
    "name": "one target",
    "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "body": [{"name": "p", "shape": "point", "position_m": [0, 300, 10], "rcs_dbsm": 10}],
}

TWO_RADARS: dict[str, Any] = {  # one on own ship, one on a pier that turns twice as fast and sees it
    "name": "two radars",
    "radar": [
        {"id": "bow", **ONE_TARGET["radar"]},
        {"id": "pier", **ONE_TARGET["radar"], "rpm": 120, "platform": {"position_m": [100, 0], "heading_deg": 90}},
    ],
    "own_ship": {"body": "tug"},
    "body": [
        {"name": "tug", "shape": "box", "length_m": 20, "width_m": 8, "height_m": 6, "rcs_dbsm": 20, "speed_kn": 9},
        *ONE_TARGET["body"],
    ],
}

SHIPPED = scene_path("harbour").parent
BASIN = {  # a compressed pulse that no maker sells: a nonlinear chirp of 50 MHz behind its inverse filter
    "frequency_hz": 9.41e9, "bandwidth_hz": 50e6, "pulse_s": 10e-6, "modulation": "nlfm", "window": "nuttall",
    "compression": "inverse", "azimuths": 720, "rpm": 24, "range_max_m": 5000, "beamwidth_deg": 1.9, "beamwidth_el_deg": 25,
    "pattern": "taylor", "height_m": 20, "power_w": 100, "gain_dbi": 30, "noise_figure_db": 4,
}  # fmt: skip


def basin(**radar: Any) -> dict[str, Any]:
    """The document of the shipped harbour with the radar BASIN; radar: settings that replace those of BASIN."""
    return dict(scene_content(scene_path("harbour"))) | {"name": "basin", "radar": BASIN | radar}


def scene(bodies: list[dict[str, Any]] | None = None, **sections: Any) -> rs.Scene:
    """A scene of these bodies; sections: radar, own_ship, environment as mappings."""
    return rs.load_scene({"name": "test", "body": bodies or [], **sections})


def radar(**settings: Any) -> Radar:
    """A radar with these settings of the scene file."""
    return scene(radar=settings).radar


def averaging(settings: dict[str, Any], pulses: int) -> dict[str, Any]:
    """Settings of a radar whose spokes average so many pulses, at its azimuths and rpm."""
    turns = settings.get("rpm", 24) / 60.0
    return settings | {"integration": pulses > 1, "prf_hz": pulses * settings["azimuths"] * turns}


def point(name: str, east: float, north: float, up: float = 15.0, rcs_dbsm: float = 10.0, **more: Any) -> dict[str, Any]:
    """A point body; by default as high as the default antenna."""
    return {"name": name, "shape": "point", "position_m": [east, north, up], "rcs_dbsm": rcs_dbsm, **more}


def everything() -> rs.Scene:
    """Metal and wood under way, a coast at rest behind them, sea, rain, noise, interference, a blind sector and sway."""
    ship = {"shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "speed_kn": 12, "course_deg": 70}
    quay = {"name": "quay", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 8, "position_m": [0, 500, 0]}
    bodies = [
        {**quay, "material": "concrete"}, {**ship, "name": "steel", "position_m": [0, 300, 0], "scattering": "optics"},
        {**ship, "name": "wood", "position_m": [-200, -300, 0], "material": "wood"}, point("buoy", 250, -100, swerling=2),
        {"name": "corner", "shape": "trihedral", "edge_m": 0.5, "position_m": [300, 200, 5], "heading_deg": 240,
         "scattering": "optics"},
    ]  # fmt: skip
    return scene(
        bodies,
        radar={"range_max_m": 800, "azimuths": 72, "beamwidth_deg": 8, "pulse_s": 1e-6, "blind_sectors_deg": [[170, 180]]},
        environment={"noise": True, "multipath": True, "sea_state": 4, "rain_mm_h": 20},
        interference=[{"bearing_deg": 100, "level_db": 20, "prf_hz": 2100}],
        own_ship={"speed_kn": 8, "course_deg": 30, "roll_deg": 4},
    )
