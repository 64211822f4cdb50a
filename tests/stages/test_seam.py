"""The seam of effects: who knows of one, and what is left without it."""

import copy
import hashlib
import inspect
import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest
from pydantic import Field

import radar_service as rs
from radar_service.effects import (
    Attenuator,
    BeamWeightedEchoes,
    Context,
    Effect,
    EffectTruth,
    PlanItem,
    RandomField,
    Source,
    Stage,
    Tile,
)
from radar_service.plan import cost_model
from radar_service.plots.plot_report import kinds_of
from radar_service.radar_feed import crossing_from_line
from radar_service.records.truth import FalseEcho
from radar_service.scene_file.describe import describe, json_schema
from radar_service.scene_file.document import scene_content, scene_path
from radar_service.truth.truth_file import scene_hash
from tests.stages.fixtures import Installed

ROOT = Path(__file__).parents[2]
PACKAGE = f"{ROOT / 'radar_service'}{os.sep}"
OTHERS = [{"bearing_deg": 250, "level_db": 60, "prf_hz": 40e3, "beamwidth_deg": 60}]
RAIN_CELL = [{"position_m": [0, 2000], "radius_m": 1500, "rain_mm_h": 20, "speed_kn": 20}]
MAX_FILES = 3  # outside its folder that run lines for one effect alone
NEVER = ("engine", "plan", "sources", "truth")
SHARED = {  # functions of arrays that any effect may use, and that these scenes use for one alone
    "ResultCache.grow", "GaussianSpectrum.draw", "Kernel.weights", "PulseKernel.weights",
    "OcclusionScene.resting_shadow_sector",
}  # fmt: skip


class ToyEffect(Effect):
    """Another effect of bodies and radars, which both scenes have: what all effects run is no knowledge of one."""

    name, stage_at, sources, has_paths = "toy", f"{__name__}:ToyStage", (Source("toy"),), True
    radar_keys = body_keys = environment_keys = {"toy": (float | None, Field(None))}

    def environment_value(self, key: str, value: Any) -> Any:
        return ToyFog(value)

    def body_record(self, given: Any, mesh: Any) -> Any:
        return given["toy"]

    def radar_record(self, given: Any) -> Any:
        return given["toy"]


@dataclass(frozen=True)
class ToyFog(Attenuator):
    """Fog that takes nothing."""

    rate: float
    text = "fog"

    def one_way_db(self, radar: Any, lines: Any) -> Any:
        return np.zeros(len(lines.azimuth))


class ToyTruth(EffectTruth):
    """What it tells of bodies."""

    def at_crossing(self, body: int, time: float, boresight: float) -> Any:
        return {"body": body}

    def false_echoes(self, body: int, distance: float, bearing: float, heading: float) -> list[FalseEcho]:
        return [FalseEcho("toy", "toy", distance, bearing, None)]


class ToyField(RandomField):
    """A field without power."""

    def powers(self) -> Any:
        return {128: np.abs(self.field) ** 2}


class ToyStage(Stage):
    """A pane that takes nothing, a path without echoes, echoes near and far, and zeros for the first row and for all."""

    has_echoes, extent = True, 0.1

    def __init__(self, context: Context | None = None) -> None:
        self._context = context

    @classmethod
    def of(cls, context: Context) -> "ToyStage":
        return cls(context)

    @classmethod
    def field_changes(cls, record: Any, aperture: Any, wavelength: float, extent: float) -> list["ToyStage"]:
        return [cls()]

    @classmethod
    def paths(cls, scene: Any, beam: Any, echo_sources: Any) -> list["ToyStage"]:
        return [cls()]

    def subtract(self, field: Any, from_bow: Any, offset: Any) -> None:
        """Takes nothing."""

    def reaches(self, from_bow: Any) -> Any:
        return np.ones(len(from_bow), dtype=np.bool_)

    def received(self, echoes: BeamWeightedEchoes, sights: Any) -> BeamWeightedEchoes:
        return echoes.chosen(np.arange(0))

    def echoes(self, azimuths: Any) -> BeamWeightedEchoes:
        zeros, body = np.zeros((2, len(azimuths.time))), self._context.echo_sources["toy"]
        return BeamWeightedEchoes(
            np.array([500.0, 5000.0]), zeros.astype(np.float32), zeros.astype(np.complex64), np.full(2, body)
        )

    @classmethod
    def plan(cls, scene: Any, fidelity: Any, microseconds: float | None) -> list[PlanItem]:
        return [PlanItem("toy", True, "nothing")]

    @classmethod
    def truth(cls, scene: Any, line_of_sight: Any) -> ToyTruth:
        return ToyTruth()

    def add(self, tile: Tile) -> None:
        tile.add(self._context.numbers["toy"], 0, np.zeros(tile.field.shape[1]))
        tile.add_field(ToyField(np.zeros((len(tile.field), 9), dtype=np.complex64), np.zeros(9, dtype=np.float32)))


OF_RADAR: dict[str, dict[str, Any]] = {
    "structures": {"structure": [{"bearing_deg": 100, "distance_m": 5, "width_m": 0.5}]},
    "multiple_echoes": {"multiple_echoes": {"own_rcs_dbsm": 60, "range_m": 5000}},
}


def content(without: str = "") -> dict[str, Any]:
    """A small scene with all effects but one."""
    scene = copy.deepcopy(dict(scene_content(scene_path("aids"))))
    scene["body"] = [scene["body"][k] for k in (0, 2, 9)]  # a racon, a buoy and a SART
    scene["radar"] |= {"azimuths": 90, "beamwidth_deg": 8, "range_max_m": 6000, "toy": 1.0}
    scene["radar"] |= {key: table[key] for effect, table in OF_RADAR.items() if effect != without for key in table}
    for body in scene["body"] if without == "beacons" else ():
        body.pop("racon", None), body.pop("sart", None)
    scene["body"][1]["toy"] = scene["environment"]["toy"] = 1.0
    scene["environment"] |= (
        {"sea_state": 3, "rain_mm_h": 4, "rain_cell": RAIN_CELL} if without != "clutter" else {"sea_state": 0}
    )
    return scene | ({"interference": OTHERS} if without != "interference" else {})


def play(scene_input: dict[str, Any]) -> None:
    """Everything that a scene with sources and truth goes through."""
    scene = rs.load_scene(scene_input)
    describe(scene), scene_hash(scene)
    sim = rs.Simulator(scene, "balanced", seed=5, labels=True, powers="all")
    sim.skip_to(2)
    for _ in sim.blocks(scans=1):
        pass
    kinds_of(scene, list(sim.label_names)), sim.source_powers(2)
    for crossing in sim.crossings(2):
        crossing_from_line(crossing.as_dict())
    sim.snapshot(2).as_dict(), str(sim.plan), sim.plan.as_dict()
    str(rs.Simulator(scene, "documented").unmeasured_info)


def lines_of(scene_input: dict[str, Any]) -> set[tuple[str, int]]:
    """File and number of the lines of the package that a scene runs, but for imports and what caches keep."""
    lines, left = set[tuple[str, int]](), dict[CodeType, set[int | None]]()

    def trace(frame: FrameType, event: str, argument: object) -> Any:
        """What has run all its lines is left alone."""
        code = frame.f_code
        if code not in left:
            watched = code.co_filename.startswith(PACKAGE) and code.co_qualname not in SHARED
            left[code] = {line for _, _, line in code.co_lines() if line} if watched else set()
        if not left[code]:
            return None
        left[code].discard(frame.f_lineno)
        lines.add((code.co_filename.removeprefix(PACKAGE), frame.f_lineno))
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        play(scene_input)
    finally:
        sys.settrace(before)
    return lines


@cache
def lines_with_all() -> set[tuple[str, int]]:
    """Those of the scene with all effects, whose first run imports and fills what caches keep for the other scenes."""
    play(content())
    return lines_of(content())


@pytest.mark.parametrize("effect", ["interference", "beacons", "clutter", *OF_RADAR])
def test_an_effect_runs_lines_of_its_own_folder_alone(
    effect: str, installed: Installed, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A scene with another effect of the kind, then with this one too: what only the second run executes."""
    monkeypatch.setattr(cost_model, "MAX_SECONDS", 0.0)  # else the pace of the machine decides what is timed
    installed.package("toys", ToyEffect)
    only = Counter(file for file, _ in lines_with_all() - lines_of(content(effect)))
    own = f"stages/{effect}/"
    elsewhere = {file: count for file, count in only.items() if not file.startswith(own)}
    assert sum(count for file, count in only.items() if file.startswith(own)) > 30
    assert len(elsewhere) <= MAX_FILES and not [file for file in elsewhere if file.startswith(NEVER)], elsewhere


IMPORTS = """
import hashlib, json, pkgutil
from importlib import import_module
from typing import Any
import radar_service as rs
from radar_service.scene_file.describe import json_schema
for name in [module.name for module in pkgutil.walk_packages(rs.__path__, "radar_service.") if "__main__" not in module.name]:
    if not name.startswith(("radar_service.clients", "radar_service.pytest_plugin", "radar_service.kernels.compiled")):
        import_module(name)
"""


def keys_and_digest() -> list[Any]:
    """The keys of scene files, and a digest of a scene that needs no effect."""
    schema = json_schema()
    sim = rs.Simulator(rs.load_scene("worked-example"), "fast", seed=3, labels=True)
    data = b"".join(block.field.tobytes() + block.labels.tobytes() for block in sim.blocks(scans=1))
    kinds = [schema, *(schema["$defs"][name] for name in ("ShapeBodyModel", "EnvironmentModel", "RadarModel"))]
    return [[key for kind in kinds for key in kind["properties"]], hashlib.sha256(data).hexdigest()]


def test_the_tree_without_effects_still_works(tmp_path: Path) -> None:
    """Without their folders and lines of the registry all imports hold, their keys are unknown, and other scenes keep their
    bytes; the next test shows that no effect needs another one."""
    effects = ["interference", "beacons", "clutter", *OF_RADAR]
    keys = {"interference", "racon", "sart", "sea_texture_shape", "rain_cell", *OF_RADAR["structures"], "multiple_echoes"}
    shutil.copytree(ROOT / "radar_service", tmp_path / "radar_service")
    for name in ("clients", "scenes"):
        shutil.copytree(ROOT / name, tmp_path / "radar_service" / name)
    for effect in effects:
        shutil.rmtree(tmp_path / "radar_service" / "stages" / effect)
    registry = tmp_path / "radar_service" / "stages" / "registry.py"
    lines = registry.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if not any(f'"radar_service.stages.{effect}.' in line for effect in effects)]
    assert len(kept) == len(lines) - len(effects)
    registry.write_text("".join(kept), encoding="utf-8")
    code = f"{IMPORTS}\n{inspect.getsource(keys_and_digest)}\nprint(json.dumps([rs.__file__, *keys_and_digest()]))"
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    file, left, digest = json.loads(done.stdout)
    whole, same = keys_and_digest()
    assert file.startswith(str(tmp_path)) and {*whole} - {*left} == keys and digest == same


def test_no_effect_imports_another() -> None:
    folders = [folder.name for folder in (ROOT / "radar_service" / "stages").iterdir() if (folder / "__init__.py").exists()]
    for folder in folders:
        for file in (ROOT / "radar_service" / "stages" / folder).glob("*.py"):
            source = file.read_text(encoding="utf-8")
            assert not [other for other in folders if other != folder and f"stages.{other}" in source], file


def test_declarations_import_nothing_of_the_engine() -> None:
    code = "import sys; from radar_service.stages.registry import effects; effects(); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = ("trace", "echo", "receive", "clutter", "engine", "plan", "simulator")
    assert not [name for name in loaded if name.startswith(tuple(f"radar_service.{room}" for room in heavy))]
