"""A prepared scene: it crosses to another process, and bodies of it may be silent or transparent."""

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.engine.pipeline import Engine, profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from tests.scenes import everything, point, scene

CHILD = """
import pickle, sys
from radar_service.engine.pipeline import profiles, tile_azimuths
for path in sys.argv[1:]:
    prepared = pickle.load(open(path, "rb"))
    for scan in (1, 0):
        for start in range(0, prepared.scene.radar.azimuths, prepared.tile):
            sys.stdout.buffer.write(profiles(prepared, tile_azimuths(prepared, scan, start)).tobytes())
"""


def test_a_prepared_scene_crosses_to_another_process(tmp_path: Path) -> None:
    """There its profiles have the same bytes, scans in another order too, whether or not its caches were filled here."""
    prepared = prepare(everything(), PRESETS["balanced"], 5)
    as_prepared, used = tmp_path / "prepared.pickle", tmp_path / "used.pickle"
    as_prepared.write_bytes(pickle.dumps(prepared))
    fields = [b"".join(field.tobytes() for _, field, _ in Engine(prepared).tiles(scan)) for scan in (0, 1)]
    used.write_bytes(pickle.dumps(prepared))
    command = [sys.executable, "-c", CHILD, str(as_prepared), str(used)]
    child = subprocess.run(command, capture_output=True, check=True, cwd=Path(__file__).parents[2])
    assert child.stdout == 2 * (fields[1] + fields[0])
    assert fields[0] != fields[1] and np.frombuffer(fields[0], np.complex64).any()


def test_silent_and_transparent_bodies() -> None:
    """A silent body still occludes; a transparent one still echoes, its far side too, and what is behind it is visible."""
    ship = {"name": "ship", "shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 40, "rcs_dbsm": 20,
            "position_m": [0, 400, 0], "course_deg": 90, "speed_kn": 1}  # fmt: skip
    made = scene([ship, point("behind", 0, 900)], radar={"range_max_m": 1200, "pulse_s": 1e-6})
    near, far = slice(180, 230), slice(440, 460)

    def levels(**options: Any) -> tuple[float, float]:
        prepared = prepare(made, PRESETS["balanced"], 1, **options)
        power = np.abs(profiles(prepared, tile_azimuths(prepared, 0, 0))[0]) ** 2
        return float(power[near].max()), float(power[far].max())

    plain, silent, transparent = levels(), levels(silent=[0]), levels(transparent=[0])
    assert silent[0] < 1e-6 * plain[0] and silent[1] < 1e-4 * transparent[1]
    assert transparent[0] > 0.1 * plain[0] and plain[1] < 1e-4 * transparent[1]
