"""The scenes of a server: packaged ones, those in the owner's folders, and uploads, each in a folder of its own."""

import json
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from radar_service.scene.error import SceneError
from radar_service.scene.files.mesh_reader import MeshReader
from radar_service.scene.files.scene_file import packaged_scenes, scene_path
from radar_service.scene.load import load_scene, model_from
from radar_service.scene.world import Scene

MAX_UPLOADS = 32
MAX_UPLOAD_BYTES = 64 * 2**20  # of one scene with its meshes
MAX_UPLOAD_FILES = 64
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _-]{0,63}")
FILE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,127}")

Origin = Literal["packaged", "folder", "uploaded"]


class Conflict(Exception):
    """A request that contradicts the present state of a scene. The text says why and what to do."""


@dataclass(frozen=True)
class SceneEntry:
    """A scene of the list: its name, its file, and where it comes from."""

    name: str
    path: Path
    origin: Origin

    def summary(self) -> dict[str, Any]:
        """Returns what the scene contains, read from its file but not built; `problems` where it cannot be read."""
        summary: dict[str, Any] = {"name": self.name, "origin": self.origin, "problems": []}
        try:
            model = model_from(self.path)
        except SceneError as error:
            problems = _without_folder(error.problems, self.path.parent)
            return summary | {"title": self.name, "summary": "cannot be read", "problems": problems}
        text = f"{len(model.body)} bodies, {model.radar.range_max_m:g} m, {model.radar.rpm:g} rpm"
        return summary | {"title": model.name, "summary": text}


def checked_name(name: str) -> str:
    """Returns a name that can be listed and be part of an address. Raises SceneError otherwise."""
    if not NAME.fullmatch(name):
        raise SceneError(
            f"name: {name[:80]!r} is not a name for a scene; use 1 to 64 letters, digits, spaces, - and _, "
            "a letter or digit first"
        )
    return name


class SceneStore:
    """All scenes of a server. Uploads live in the temporary folder `home`, which `close` removes.

    trusted, untrusted: parse the files of the server's owner, and those of uploads.
    """

    def __init__(self, folders: Iterable[Path], trusted: MeshReader, untrusted: MeshReader) -> None:
        self._folders = tuple(folders)
        self._readers: dict[Origin, MeshReader] = {"packaged": trusted, "folder": trusted, "uploaded": untrusted}
        self.home = Path(tempfile.mkdtemp(prefix="radar-scenes-"))
        self._uploads: dict[str, SceneEntry] = {}

    def close(self) -> None:
        """Removes the uploads."""
        shutil.rmtree(self.home, ignore_errors=True)

    def entries(self) -> list[SceneEntry]:
        """Returns the scenes by name. Of equal names an upload comes before a scene of a folder, that before a packaged one."""
        entries = {name: SceneEntry(name, scene_path(name), "packaged") for name in packaged_scenes()}
        for folder in self._folders:
            for path in sorted([*folder.glob("*.toml"), *folder.glob("*.json")]):
                entries[path.stem] = SceneEntry(path.stem, path, "folder")
        return [entry for _, entry in sorted((entries | self._uploads).items())]

    def load(self, name: str) -> Scene:
        """Returns the scene of that name, built. Raises KeyError where there is none, SceneError where it is not valid."""
        entry = {entry.name: entry for entry in self.entries()}[name]
        try:
            return load_scene(entry.path, mesh_reader=self._readers[entry.origin])
        except SceneError as error:
            raise SceneError(*_without_folder(error.problems, entry.path.parent)) from None

    def add(
        self, name: str, scene: bytes, kind: str, files: Mapping[str, bytes], plan: Callable[[Scene], dict[str, Any]]
    ) -> tuple[Scene, dict[str, Any]]:
        """Adds an uploaded scene (text of a file, kind ".toml" or ".json") and its files; replaces one of the same name.

        Returns the scene and its plan. The scene is built and planned once: where that fails nothing of it is kept and an
        earlier upload stays. Raises SceneError, what `plan` raises, and Conflict when the store is full.
        """
        checked_name(name)
        if name not in self._uploads and len(self._uploads) >= MAX_UPLOADS:
            raise Conflict(f"{MAX_UPLOADS} uploaded scenes are kept; delete one first")
        folder = Path(tempfile.mkdtemp(dir=self.home))
        try:
            path = _stored(folder, scene, kind, files)
            built = load_scene(path, mesh_reader=self._readers["uploaded"])
            its_plan = plan(built)
        except BaseException as error:
            shutil.rmtree(folder, ignore_errors=True)
            if isinstance(error, SceneError):
                raise SceneError(*_without_folder(error.problems, folder)) from None
            raise
        replaced = self._uploads.get(name)
        self._uploads[name] = SceneEntry(name, path, "uploaded")
        if replaced:
            shutil.rmtree(replaced.path.parent, ignore_errors=True)
        return built, its_plan

    def remove(self, name: str) -> None:
        """Deletes an upload. Raises KeyError where there is no such scene, Conflict where it is not an upload."""
        if name not in self._uploads:
            if any(entry.name == name for entry in self.entries()):
                raise Conflict(f'"{name}" is not an upload and cannot be deleted here')
            raise KeyError(name)
        shutil.rmtree(self._uploads.pop(name).path.parent, ignore_errors=True)


def _without_folder(problems: Iterable[str], folder: Path) -> list[str]:
    """Returns the lines without the folder's path on the server, which clients need not know."""
    return [line.replace(f"{folder}/", "").replace(str(folder), "the scene's folder") for line in problems]


def _stored(folder: Path, scene: bytes, kind: str, files: Mapping[str, bytes]) -> Path:
    if kind not in (".toml", ".json"):
        raise SceneError(f'scene: the ending "{kind[:20]}" is not known; send a .toml or .json file')
    if len(files) > MAX_UPLOAD_FILES:
        raise SceneError(f"files: {len(files)} files; at most {MAX_UPLOAD_FILES} are allowed with a scene")
    path = folder / f"scene{kind}"
    for name, content in files.items():
        if not FILE_NAME.fullmatch(name) or name == path.name:
            raise SceneError(
                f"files: {name[:80]!r} is not a plain file name; letters, digits, spaces and ._- without folders"
            )
        (folder / name).write_bytes(content)
    path.write_bytes(scene)
    return path


def json_bytes(scene: Mapping[str, Any]) -> bytes:
    """Returns a scene given as data as the text of a file; the loader then reports numbers that are not finite."""
    return json.dumps(scene).encode()
