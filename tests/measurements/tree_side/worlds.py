"""The scenes of the comparison: small enough for a run of each preset, with each thing that a scene may have."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.scene_file.document import scene_content, scene_path

SHIPPED = ("worked-example", "orientation", "far-target", "open-sea", "harbour")
AT_REST = SHIPPED[:3]
PRESETS = ("documented", "fast", "balanced", "auto", "reference")
DAY = 86_400.0  # s
COMMANDS = 300
RPM = {"bow": 24.0, "pier": 40.0}
ERRORS = {
    "profile": "imo-a823",
    "gyro": {"latency_s": 0.3},
    "position": {"noise_m": 5},
    "antenna": {"misalignment_deg": 1.5},
    "feed": {"drop_rate": 0.05, "repeat_rate": 0.05, "late_rate": 0.05, "swap_rate": 0.05, "heading_lost_s": [[4, 5]]},
}


def two_radars(errors: bool = False) -> dict[str, Any]:
    """Own ship with a radar and a radar ashore, over a sea with clutter: metal that rolls, a point that fades, a rock wall."""
    small = {"azimuths": 120, "beamwidth_deg": 4, "range_max_m": 1500, "pulse_s": 1e-6, "power_w": 4000}
    tug = {
        "name": "tug", "shape": "hull", "length_m": 25, "beam_m": 8, "height_m": 6, "material": "steel", "speed_kn": 6,
        "steerable": {}, "roll_deg": 4, "roll_period_s": 7,
    }  # fmt: skip
    ship = {
        "name": "ship", "shape": "box", "length_m": 8, "width_m": 3, "height_m": 3, "material": "steel",
        "position_m": [300, 500, 0], "course_deg": 200, "heading_deg": 200, "speed_kn": 9, "steerable": {},
        "roll_deg": 6, "roll_period_s": 6,
    }  # fmt: skip
    buoy = {
        "name": "buoy", "shape": "point", "rcs_dbsm": 10, "swerling": 1, "position_m": [-400, 300, 3], "steerable": {},
    }  # fmt: skip
    wall = {
        "name": "wall", "shape": "box", "length_m": 4, "width_m": 60, "height_m": 3, "material": "rock",
        "position_m": [200, 420, 0],
    }  # fmt: skip
    return {
        "name": "two radars",
        "origin": {"latitude_deg": 50.9, "longitude_deg": 1.4},
        "radar": [
            {"id": "bow", **small, "rpm": RPM["bow"]},
            {"id": "pier", **small, "rpm": RPM["pier"], "platform": {"position_m": [600, -200]}},
        ],
        "own_ship": {"body": "tug"},
        "environment": {"noise": True, "multipath": True, "sea_state": 2, "rain_mm_h": 4},
        "body": [tug, ship, buoy, wall],
        **({"errors": ERRORS} if errors else {}),
    }


def with_effects() -> Iterator[tuple[str, dict[str, Any], str]]:
    """Name, content and preset of scenes with beacons and with other radars, which no shipped scene has together."""
    aids = dict(scene_content(scene_path("aids")))
    others = [
        {"bearing_deg": 250, "level_db": 60, "prf_hz": 40e3, "beamwidth_deg": 60},
        {"position_m": [4000, 3000], "level_db": 90, "prf_hz": 1500, "rpm": 30},
    ]
    quick = {**aids["radar"], "azimuths": 480, "beamwidth_deg": 2}
    chirp = {"modulation": "lfm", "pulse_s": 5e-6, "bandwidth_hz": 10e6, "sample_rate_hz": 15e6, "power_w": 500}
    pulses = {"pulses": [{"modulation": "none", "pulse_s": 1e-7, "bandwidth_hz": 12e6, "range_max_m": 3000}, {}]}
    pulses["pulses"][1] = {key: aids["radar"][key] for key in ("modulation", "pulse_s", "bandwidth_hz")}
    shared = {key: value for key, value in quick.items() if key not in pulses["pulses"][1]}
    mast = {"structure": [{"name": "mast", "bearing_deg": 180, "width_m": 0.5, "distance_m": 4}]}
    blind = {"blind_sectors_deg": [[40, 120]]}
    both = aids | {"interference": others}
    yield "aids", aids | {"radar": quick}, "balanced"
    yield "both", both | {"radar": quick}, "balanced"
    yield "exact", both | {"radar": {**quick, "azimuths": 180, "beamwidth_deg": 4}}, "reference"
    yield "specified", both | {"radar": {**quick, "azimuths": 180, "beamwidth_deg": 4, "rays": 200}}, "documented"
    yield "chirp", both | {"radar": quick | chirp}, "fast"
    yield "pulses", both | {"radar": shared | pulses}, "balanced"
    yield "structures", both | {"radar": quick | mast | blind}, "balanced"
    yield "open sea", dict(scene_content(scene_path("open-sea"))) | {"interference": others}, "auto"


def day_of_commands(seed: int, own_ship: str | None) -> Iterator[tuple[str | None, float, dict[str, Any]]]:
    """Body, time [s] and values of commands over a day, in order. own_ship: what a radar calls her."""
    rng = np.random.default_rng(seed)
    for time in np.sort(rng.uniform(0.0, DAY, COMMANDS)).tolist():
        body = [own_ship, "ship", "buoy"][rng.integers(3)]
        kinds: list[dict[str, Any]] = [
            {"course_deg": round(rng.uniform(0.0, 360.0), 3), "speed_kn": round(rng.uniform(0.0, 15.0), 3)},
            {"course_deg": round(rng.uniform(0.0, 360.0), 3), "turn_rate_deg_s": round(rng.uniform(0.5, 3.0), 3)},
            {"position_m": rng.uniform(-700.0, 700.0, 2).round(2).tolist()},
            {"heading_deg": round(rng.uniform(0.0, 360.0), 3)},
            {"present": bool(rng.integers(2))} if body != own_ship else {"turn_rate_deg_s": 0.0},
        ]
        yield body, time, kinds[rng.integers(len(kinds))]


def real_scenes(folder: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Folder and scene of real input: buildings of the Swinomish Channel; Catalina's coast passed by a steel ship in a seaway."""
    tile = folder / "swinomish" / "osm_2_2.obj"
    radar = {"range_max_m": 3000, "beamwidth_deg": 1.9, "height_m": 15}
    buildings = {"name": "houses", "mesh": tile.name, "up": "y", "position_m": [300, 200, 0]}
    yield tile.parent, {"name": "swinomish", "radar": radar, "body": [buildings]}
    island = {
        "name": "island", "heightmap": "catalina.png", "low_m": -2063, "high_m": 633, "material": "land",
        "extent_m": [40000, 40000], "position_m": [-6000, 4000, 0],
    }  # fmt: skip
    ship = {
        "name": "ship", "shape": "hull", "length_m": 90, "beam_m": 16, "height_m": 14, "material": "steel",
        "position_m": [800, 900, 0], "course_deg": 200, "heading_deg": 200, "speed_kn": 14,
    }  # fmt: skip
    yield (
        folder,
        {
            "name": "catalina",
            "radar": {"range_max_m": 6000},
            "own_ship": {"speed_kn": 10, "course_deg": 30, "heading_deg": 30},
            "environment": {"noise": True, "multipath": True, "sea_state": 3, "rain_mm_h": 4},
            "body": [island, ship],
        },
    )
