"""Processor time and memory of `check` for a mesh of 3.5 million triangles and for one in millimetres:
`pytest -m bench -s tests/measurements/test_large_meshes.py` (about a minute)."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs

SIDE = 1322  # of a grid, whose 2 n^2 triangles are 3.5 million
GIB = 2**30


def wavy_sheet(file: Path) -> None:
    """Writes a steel plain of 120 m with waves, as binary STL."""
    place = np.linspace(-60.0, 60.0, SIDE + 1)
    x, y = np.meshgrid(place, place, indexing="ij")
    points = np.stack([x, y, 0.2 * np.sin(x) * np.sin(y) + 3.0], axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[:-1, 1:], points[1:, 1:]
    records = np.zeros(2 * SIDE**2, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    records["corners"] = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (c, b, d))])
    file.write_bytes(bytes(80) + np.uint32(len(records)).tobytes() + records.tobytes())


def checked(folder: Path, body: str) -> tuple[float, float, str]:
    """Processor time [s] and peak memory [GiB] of `check` of one body, and what it says."""
    scene = folder / "scene.toml"
    scene.write_text(f"[environment]\nmultipath = true\n[[body]]\nname = 'b'\nposition_m = [3e3, 4e3, 0]\n{body}")
    command = [sys.executable, "-m", "radar_service", "check", str(scene)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        assert process.stdout is not None
        said = process.stdout.read().decode()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / GIB, said


@pytest.mark.bench
def test_check_of_large_meshes(tmp_path: Path) -> None:
    """The small one first: a child begins with the memory of its parent, which then has no sheet yet."""
    shutil.copy(Path(rs.__file__).parents[1] / "scenes" / "coaster.obj", tmp_path)
    judge("in millimetres", *checked(tmp_path, "mesh = 'coaster.obj'\nscale = 1000"), "set scale", (5.0, 0.5))
    wavy_sheet(tmp_path / "sheet.stl")
    judge("3.5 million triangles", *checked(tmp_path, "mesh = 'sheet.stl'"), "--all", (30.0, 1.5))


def judge(name: str, seconds: float, memory: float, said: str, words: str, limits: tuple[float, float]) -> None:
    """Prints what a check took, and compares it with limits: processor time [s] and memory [GiB]."""
    print(f"{name}: {seconds:.1f} s of processor time, {memory:.2f} GiB; {said.splitlines()[0]}")
    assert words in said and (seconds, memory) < limits and memory < limits[1]
