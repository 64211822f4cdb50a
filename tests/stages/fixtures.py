"""Effects of other packages that are installed for a test, in this process."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import radar_service as rs
from radar_service import plug_ins
from radar_service.engine.preparation import prepare, scattering_context
from radar_service.records.fidelity import PRESETS
from radar_service.scene_file.model.body import body_models
from radar_service.scene_file.model.platform import radar_models
from radar_service.scene_file.model.scene import scene_model, scene_schema
from radar_service.stages.effect import Effect
from radar_service.stages.registry import effects
from radar_service.stages.stage import Context


class Installed:
    """Installs packages below a folder. What is known of effects is forgotten before and after."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self._folder, self._patch = folder, patch
        patch.syspath_prepend(str(folder))

    def package(self, name: str, *kinds: type[Effect], **broken: str) -> None:
        """Installs a package with effects. broken: names of entry points, with what these refer to."""
        module = ModuleType(name.replace("-", "_"))
        for kind in kinds:
            setattr(module, kind.__name__, kind)
        self._patch.setitem(sys.modules, module.__name__, module)
        lines = {kind.__name__.lower(): f"{module.__name__}:{kind.__name__}" for kind in kinds} | broken
        info = self._folder / f"{module.__name__}-1.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
        (info / "entry_points.txt").write_text(
            "\n".join(["[radar_service.effects]", *(f"{key} = {lines[key]}" for key in lines)])
        )
        forget()


def forget() -> None:
    """Lets effects, and the models of scenes, be made anew."""
    for cached in (plug_ins.groups, effects, body_models, radar_models, scene_model, scene_schema):
        cached.cache_clear()


def context_of(made: rs.Scene, name: str, seed: int = 0) -> Context:
    """What a stage of a scene, in which nothing asks for it, is made from."""
    fidelity = PRESETS["fast"]
    ready = prepare(made, fidelity, seed)
    parts = (made, fidelity, seed, ready.line_of_sight, ready.compression, {}, {}, seed)
    return Context(name, *parts, scattering_context(made, fidelity, seed), ready.moving)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Installed]:
    """Installs effects of other packages for a test."""
    yield Installed(tmp_path, monkeypatch)
    monkeypatch.undo()
    forget()
