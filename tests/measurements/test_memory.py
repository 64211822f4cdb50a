"""Memory of a thousand revolutions more with everything on:
`pytest -m bench -s tests/measurements/test_memory.py` (about a minute)."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import radar_service as rs
from tests.scenes import point, scene

SCANS = (500, 1500)
GROWTH = 1.0  # MB between them: a leak of two float64 a spoke would make 1.4; the allocator settles before
LAP = [
    {"position_m": [300, 300], "speed_kn": 12},
    {"position_m": [300, 500], "speed_kn": 8},
    {"position_m": [-300, 450], "speed_kn": 12},
]


def everything() -> rs.Scene:
    """Noise, sea, rain, another radar, multipath, a quay, a ship at rest and one under way by optics, a hull and a buoy."""
    hull = {"shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 8}
    quay = {"shape": "box", "length_m": 120, "width_m": 20, "height_m": 4, "material": "concrete"}
    bodies: list[dict[str, Any]] = [
        {"name": "quay", **quay, "position_m": [350, -200, 0]},
        {"name": "at rest", **hull, "scattering": "optics", "position_m": [-400, -200, 0]},
        {"name": "by optics", **hull, "scattering": "optics", "position_m": [-300, 300, 0], "waypoints": LAP, "loop": True},
        {"name": "wood", **hull, "material": "wood", "position_m": [300, -400, 0], "waypoints": LAP[::-1], "loop": True},
        point("buoy", -100, 250, swerling=2),
    ]
    return scene(
        bodies,
        radar={"range_max_m": 800, "azimuths": 90, "beamwidth_deg": 8, "rpm": 60},
        environment={"noise": True, "sea_state": 3, "rain_mm_h": 4, "multipath": True},
        interference=[{"bearing_deg": 70, "level_db": 30}],
    )


def resident() -> float:
    """Resident size [MB] of this process, now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def report() -> None:
    """Prints the resident size [MB] after each of SCANS."""
    sim, done = rs.Simulator(everything(), seed=1), 0
    for until in SCANS:
        for _ in sim.blocks(scans=until - done):
            pass
        done = until
        print(f"{resident():.2f}", flush=True)


@pytest.mark.bench
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads resident sizes from /proc")
def test_a_thousand_more_scans_take_no_more_memory() -> None:
    """In a process of its own, so that nothing else is counted."""
    script = "from tests.measurements.test_memory import report; report()"
    done = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True, cwd=Path.cwd())
    early, late = map(float, done.stdout.split())
    print(f"resident: {early:.1f} MB after {SCANS[0]} scans, {late:.1f} MB after {SCANS[1]}: {late - early:+.2f} MB")
    assert late - early < GROWTH
