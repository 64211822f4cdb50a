"""What a sweep is made of: its specification, its scenes and their files, by content. Workers need nothing else."""

import hashlib
import json
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from radar_service.bench.kept_plots import named_files, program_version, source_digest
from radar_service.radar import Radar
from radar_service.scene_file import load_scene, put, radar_entries, radar_from_model, scene_content, scene_path, validated
from radar_service.sweep.spec import KeyValues, Runs, SweepError, SweepRun, SweepSpec, load_spec
from radar_service.terminal import make_folder, write_file
from radar_service.world import Scene, SceneError, known_radar

SCHEMA = 1  # of stores


@dataclass(frozen=True)
class SceneSource:
    """A scene before values are put into it. name: as the specification has it. files: by the names in the content."""

    name: str
    content: Mapping[str, Any]
    files: Mapping[str, bytes]


@dataclass(frozen=True)
class Inputs:
    """Specification and scenes, in its order."""

    spec: SweepSpec
    scenes: tuple[SceneSource, ...]

    @cached_property
    def runs(self) -> Runs:
        """All runs. Raises SweepError."""
        return Runs(self.spec)

    def content(self, run: SweepRun) -> dict[str, Any]:
        """Returns the content of the scene of a run, with its values. Raises SweepError."""
        source = self.scenes[run.scene]
        content = deepcopy(dict(source.content))
        try:
            for key, value in run.values.items():
                put(content, key, deepcopy(value), f"vary: {key!r} in {source.name}")
        except SceneError as error:
            raise SweepError(str(error)) from None
        return content

    def radar(self, run: SweepRun) -> Radar:
        """Returns the radar of a run. Raises SweepError where the scene is not valid, as far as that shows without its files."""
        try:
            entries = {entry.id: entry.model for entry in radar_entries(validated(self.content(run)).radar)}
            return radar_from_model(entries[known_radar(run.radar, tuple(entries))])
        except ValueError as error:
            raise SweepError(_with_values(error, run, self.scenes[run.scene].name)) from None

    def scene(self, run: SweepRun) -> Scene:
        """Returns the scene of a run, as its radar has it. Raises SweepError."""
        source = self.scenes[run.scene]
        content = self.content(run)
        with TemporaryDirectory(prefix="radar-sweep-") as folder:
            for name in named_in(content, source.files):
                path = Path(folder) / name
                make_folder(path.parent)
                write_file(path, source.files[name])
            try:
                return load_scene(content, folder=Path(folder)).for_radar(run.radar)
            except ValueError as error:
                raise SweepError(_with_values(error, run, source.name)) from None

    def made_of(self, arithmetic: str) -> dict[str, Any]:
        """Returns all that the values of a store depend on, as plain data."""
        files = {f"{scene.name}: {name}": _hash(content) for scene in self.scenes for name, content in scene.files.items()}
        return {
            "schema": SCHEMA, "program": program(), "arithmetic": arithmetic,
            "spec": plain_spec(self.spec) | {"vary": [*map(list, plain_spec(self.spec)["vary"].items())]},  # in their order
            "scenes": {scene.name: _hash(_json(scene.content)) for scene in self.scenes}, "files": files,
        }  # fmt: skip

    def as_bytes(self) -> tuple[bytes, list[bytes]]:
        """Returns specification and scenes as JSON, and the content of each file that it numbers."""
        files = {content: None for scene in self.scenes for content in scene.files.values()}
        number = {content: k for k, content in enumerate(files)}
        scenes = [
            {
                "name": scene.name,
                "content": scene.content,
                "files": {name: number[each] for name, each in scene.files.items()},
            }
            for scene in self.scenes
        ]
        return json.dumps({"spec": plain_spec(self.spec), "scenes": scenes}).encode(), list(files)


def program() -> str:
    """Returns the version of this program, and a hash of the source of what computes."""
    return f"{program_version()}, source {source_digest()}"


def inputs_of(path: Path) -> Inputs:
    """Returns what the specification in a TOML file names; scenes are files beside it, or packaged. Raises SweepError."""
    spec = load_spec(path)
    try:
        return Inputs(spec, tuple(_source(name, path.parent, spec) for name in spec.scene))
    except SceneError as error:
        raise SweepError(f"{path}: scene: {error}") from None


def inputs_from_bytes(description: bytes, files: Mapping[int, bytes]) -> Inputs:
    """Returns what `as_bytes` has made."""
    plain = json.loads(description)
    scenes = (
        SceneSource(source["name"], source["content"], {name: files[k] for name, k in source["files"].items()})
        for source in plain["scenes"]
    )
    return Inputs(SweepSpec(**plain["spec"]), tuple(scenes))


def plain_spec(spec: SweepSpec) -> dict[str, Any]:
    """Returns a specification as plain data, keys of `vary` in their order."""
    return spec.model_dump(mode="json", exclude_none=True)


def named_in(content: object, files: Mapping[str, bytes]) -> list[str]:
    """Returns which of some files the content of a scene names."""
    text = json.dumps(content, default=str)
    return [name for name in files if json.dumps(name) in text and _stays_inside(name)]


def _stays_inside(name: str) -> bool:
    """Whether a name leads to a file below the folder that it is relative to. Scenes may read no other."""
    return not Path(name).is_absolute() and ".." not in Path(name).parts


def _source(name: str, folder: Path, spec: SweepSpec) -> SceneSource:
    """A scene with all files that it, or a value in it, names. Raises SceneError."""
    beside = folder / name
    path = scene_path(beside if beside.is_file() else name)
    content = json.loads(_json(scene_content(path)))
    varied = [values.choice if isinstance(values, KeyValues) else values for values in spec.vary.values()]
    named = named_files([content, varied], path.parent)
    return SceneSource(name, content, {text: file.read_bytes() for text, file in named.items() if _stays_inside(text)})


def _json(content: object) -> bytes:
    return json.dumps(content, sort_keys=True, default=str, separators=(",", ":")).encode()


def _hash(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def _with_values(error: Exception, run: SweepRun, name: str) -> str:
    """The text of an error, with the values that a run has."""
    values = "".join(f", {key} = {value!r:.60}" for key, value in run.values.items())
    return f"{name}{values}: {error}"
