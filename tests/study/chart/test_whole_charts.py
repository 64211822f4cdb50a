"""Full charts of the shipped scenes and of scenes from real input: run with -m study."""

import json
import shutil
import time
from pathlib import Path
from typing import Any

import pytest

from radar_service.__main__ import main
from tests.real import places

SHIPPED = ("far-target", "harbour", "open-sea", "orientation", "worked-example")
# Largest share of missed targets: far slopes of Catalina show slivers, some without a scatterer (measured 0.19 and 0.08);
# elsewhere none is missed
MAX_MISSED = {"fast": 0.25, "balanced": 0.12, "reference": 0.0}
MAX_SECONDS = 180.0  # CPU time of a full chart
ISLAND = (33.3, -118.6)  # latitude, longitude [degrees] of a ship off Santa Catalina


def full_chart(scene: str, out: Path) -> dict[str, Any]:
    """Returns the data of a full chart of a scene."""
    out.mkdir()
    begin = time.process_time()
    assert main(["chart", scene, "-o", str(out)]) == 0
    assert time.process_time() - begin < MAX_SECONDS
    data: dict[str, Any] = json.loads((out / "chart.json").read_text())
    assert all((out / name).stat().st_size for name in ("chart.svg", "chart.png", "summary.txt"))
    return data


def assert_presets_keep_their_limits(data: dict[str, Any]) -> None:
    """Field errors keep the limits of tests/test_presets.py within 10 dB, which the echoes of a scene change them by.

    The mean powers of the samplers, of at least two draws, are within the spread of one draw and 0.1 dB of the lattice.
    """
    named = [(name, p) for p in data["points"] for name in (p["preset"] or "").split(", ")]  # presets may share a point
    field = {name: p["error_db"] for name, p in named if p["panel"] == "field"}
    limits = {"fast": -50, "balanced": -70, "reference": -80, "balanced under way": -50, "reference under way": -80}
    assert all(field[preset] < limit for preset, limit in limits.items())
    models = {p["setting"]: p for p in data["points"] if p["panel"] == "scattering"}
    assert models["3 bounces"]["error_db"] < 0.5 < 10 < models["2 bounces"]["error_db"] < models["1 bounce"]["error_db"]
    for name, point in named:
        if point["panel"] == "power" and name in MAX_MISSED:
            assert point["missed"] <= MAX_MISSED[name] and point["error_db"] < point["spread_db"] + 0.1, point["setting"]


@pytest.mark.study
@pytest.mark.parametrize("scene", SHIPPED)
def test_a_shipped_scene(scene: str, tmp_path: Path) -> None:
    assert_presets_keep_their_limits(full_chart(scene, tmp_path / "out"))


@pytest.mark.study
@places.present
@pytest.mark.parametrize("name", ["swinomish", "catalina", "buoys"])
def test_a_scene_of_the_real_input(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "scene"
    folder.mkdir()
    made = {"swinomish": places.swinomish, "catalina": lambda f: places.catalina(f, ISLAND), "buoys": buoys}[name](folder)
    (folder / "scene.json").write_text(json.dumps(made))
    assert_presets_keep_their_limits(full_chart(str(folder / "scene.json"), tmp_path / "out"))


def buoys(folder: Path) -> dict[str, Any]:
    """Returns a scene of four light buoys, two by physical optics and two diffuse."""
    shutil.copy(places.REAL / "light_buoy.stl", folder)
    body = [
        {"name": f"buoy {k}", "mesh": "light_buoy.stl", "material": "steel", "position_m": [300 * k + 200, 400 + 100 * k, 0],
         "scattering": "optics" if k % 2 else "diffuse"}
        for k in range(4)
    ]  # fmt: skip
    return {"name": "light buoys", "radar": {"range_max_m": 3000}, "body": body}
