"""Effects of other packages that are installed for a test, in this process."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from radar_service import plug_ins
from radar_service.scene_file.model.body import body_models
from radar_service.scene_file.model.scene import scene_model, scene_schema
from radar_service.stages.effect import Effect
from radar_service.stages.registry import effects


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
    for cached in (plug_ins.groups, effects, body_models, scene_model, scene_schema):
        cached.cache_clear()


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Installed]:
    """Installs effects of other packages for a test."""
    yield Installed(tmp_path, monkeypatch)
    monkeypatch.undo()
    forget()
