"""A long run costs no more time or memory: nothing is rebuilt, traced or kept without need."""

import gc
import subprocess
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import pytest

import radar_service as rs
from radar_service.scattering.fixed_scatterers import FixedScatterers
from radar_service.trace.embree import TriangleScene
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import point, scene

ROOT = Path(__file__).parent.parent
RADAR = {"range_max_m": 800, "azimuths": 90, "beamwidth_deg": 8}


def harbourlet(speed_kn: float = 0.0, **radar: Any) -> rs.Scene:
    """A quay, a mast on it, a ship that passes and a fluctuating buoy."""
    quay = {"name": "quay", "shape": "box", "length_m": 90, "width_m": 20, "height_m": 4, "position_m": [200, 200, 0]}
    ship = {"name": "ship", "shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "position_m": [0, 300, 0]}
    return scene(
        [
            {**quay, "material": "concrete"}, {**ship, "material": "wood", "speed_kn": 14, "course_deg": 80},
            point("mast", 200, 210), point("buoy", -100, 300, swerling=2),
        ],
        radar=RADAR | radar, own_ship={"speed_kn": speed_kn, "course_deg": 0}, environment={"noise": True},
    )  # fmt: skip


def counted(patch: pytest.MonkeyPatch, where: Any, name: str) -> list[int]:
    """Calls of a method from now on, as a list that grows."""
    calls: list[int] = []
    original = getattr(where, name)

    def counting(*args: Any, **more: Any) -> Any:
        calls.append(1)
        return original(*args, **more)

    patch.setattr(where, name, counting)
    return calls


def test_nothing_is_rebuilt_and_rest_is_traced_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No tree is built after the start, from rest or under way. With all at rest no ray is traced ever again; a passing ship
    has rays traced once in a visibility step (7.2 m/s: every 0.69 s, so 36 in 25 s), for what moves (once for each of the two
    scattering models that has anything in the sector of the step) and for what it occludes."""
    for speed in (0.0, 20.0):
        sim = rs.Simulator(harbourlet(speed))
        with monkeypatch.context() as patch:
            built = counted(patch, TriangleScene, "__init__")
            for _ in sim.blocks(scans=10):
                pass
            assert not built
    still = scene(
        [{"name": "b", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, 300, 0]}], radar=RADAR
    )
    sim = rs.Simulator(still)
    with monkeypatch.context() as patch:
        rays = counted(patch, TriangleScene, "first_hit_of")
        rays += counted(patch, TriangleScene, "occluded")
        sim.scan()
        assert not rays
    sim = rs.Simulator(harbourlet())
    with monkeypatch.context() as patch:
        visible, shadows = counted(patch, OcclusionScene, "visible"), counted(patch, OcclusionScene, "occluded_by_moving")
        models = counted(patch, FixedScatterers, "echoes")
        for _ in sim.blocks(scans=10):
            pass
        assert len(shadows) == pytest.approx(36, abs=1)
        assert len(models) == 2 * len(shadows)
        assert len(shadows) < len(visible) < len(models)


def bytes_after(*scans: int) -> list[int]:
    """Allocated bytes after so many scans, and so many more, under way with noise and draws."""
    sim = rs.Simulator(harbourlet(15.0, azimuths=36, beamwidth_deg=20, rpm=120))
    tracemalloc.start()
    traced = []
    for more in scans:
        for _ in sim.blocks(scans=more):
            pass
        gc.collect()
        traced.append(tracemalloc.get_traced_memory()[0])
    return traced


def test_memory_does_not_grow_with_scans() -> None:
    """24 more scans allocate no more than 8 did, to 64 KiB: a single azimuth kept from each would be 78 KiB.
    In a process of its own: threads that other tests leave behind would be counted."""
    script = "from tests.test_steady_state import bytes_after; print(*bytes_after(8, 24))"
    output = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    before, after = map(int, output.split())
    assert after - before < 65_536
