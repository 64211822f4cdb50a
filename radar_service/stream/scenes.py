"""The scenes that a server offers: packaged ones, those in folders of its owner, and uploads in folders of their own."""

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
    """Something cannot be done to a scene as things stand. Its text says why and what to do."""


@dataclass(frozen=True)
class Offer:
    """A scene on the list: where its file lies and where it came from."""

    name: str
    path: Path
    origin: Origin

    def summary(self) -> dict[str, Any]:
        """What the scene holds, read from its file but not built; `problems` where it cannot be read."""
        about: dict[str, Any] = {"name": self.name, "origin": self.origin, "problems": []}
        try:
            model = model_from(self.path)
        except SceneError as fault:
            return about | {
                "title": self.name,
                "summary": "cannot be read",
                "problems": _discreet(fault.problems, self.path.parent),
            }
        summary = f"{len(model.body)} bodies, {model.radar.range_max_m:g} m, {model.radar.rpm:g} rpm"
        return about | {"title": model.name, "summary": summary}


def checked_name(name: str) -> str:
    """A name fit for a list and an address. Raises SceneError otherwise."""
    if not NAME.fullmatch(name):
        raise SceneError(
            f"name: {name[:80]!r} cannot name a scene; 1 to 64 letters, digits, spaces, - and _ can, a letter or digit first"
        )
    return name


class SceneShelf:
    """All scenes on offer. Uploads live in a temporary folder that goes with the shelf.

    own, strange: who parses the files of the server's owner, and those of uploads.
    """

    def __init__(self, folders: Iterable[Path], own: MeshReader, strange: MeshReader) -> None:
        self._folders = tuple(folders)
        self._builders: dict[Origin, MeshReader] = {"packaged": own, "folder": own, "uploaded": strange}
        self._home = Path(tempfile.mkdtemp(prefix="radar-scenes-"))
        self._uploads: dict[str, Offer] = {}

    def close(self) -> None:
        """Remove the uploads."""
        shutil.rmtree(self._home, ignore_errors=True)

    def offers(self) -> list[Offer]:
        """The scenes, by name; an upload hides a scene of a folder, that a packaged one of the same name."""
        found = {name: Offer(name, scene_path(name), "packaged") for name in packaged_scenes()}
        for folder in self._folders:
            for path in sorted([*folder.glob("*.toml"), *folder.glob("*.json")]):
                found[path.stem] = Offer(path.stem, path, "folder")
        return [offer for _, offer in sorted((found | self._uploads).items())]

    def load(self, name: str) -> Scene:
        """The scene of that name, built. Raises KeyError where there is none, SceneError where it cannot be run."""
        offer = {offer.name: offer for offer in self.offers()}[name]
        try:
            return load_scene(offer.path, mesh_reader=self._builders[offer.origin])
        except SceneError as fault:
            raise SceneError(*_discreet(fault.problems, offer.path.parent)) from None

    def add(
        self, name: str, scene: bytes, kind: str, files: Mapping[str, bytes], plan: Callable[[Scene], dict[str, Any]]
    ) -> tuple[Scene, dict[str, Any]]:
        """Take in an uploaded scene (TOML or JSON text, kind ".toml" or ".json") and its files; it replaces one of its name.

        The scene is built and planned once, so that what cannot be run is refused here, nothing is kept of it, and an
        earlier one stays. Raises SceneError, what `plan` raises, and Conflict when the shelf is full.
        """
        checked_name(name)
        if name not in self._uploads and len(self._uploads) >= MAX_UPLOADS:
            raise Conflict(f"{MAX_UPLOADS} uploaded scenes are kept; delete one first")
        folder = Path(tempfile.mkdtemp(dir=self._home))
        try:
            path = _stored(folder, scene, kind, files)
            built = load_scene(path, mesh_reader=self._builders["uploaded"])
            planned = plan(built)
        except BaseException as fault:
            shutil.rmtree(folder, ignore_errors=True)
            if isinstance(fault, SceneError):
                raise SceneError(*_discreet(fault.problems, folder)) from None
            raise
        replaced = self._uploads.get(name)
        self._uploads[name] = Offer(name, path, "uploaded")
        if replaced:
            shutil.rmtree(replaced.path.parent, ignore_errors=True)
        return built, planned

    def remove(self, name: str) -> None:
        """Delete an upload. Raises KeyError where there is no such scene, Conflict where it is not an upload."""
        if name not in self._uploads:
            if any(offer.name == name for offer in self.offers()):
                raise Conflict(f'"{name}" is not an upload and cannot be deleted here')
            raise KeyError(name)
        shutil.rmtree(self._uploads.pop(name).path.parent, ignore_errors=True)


def _discreet(problems: Iterable[str], folder: Path) -> list[str]:
    """The lines without the place of the folder on the server, which is nobody's business."""
    return [line.replace(f"{folder}/", "").replace(str(folder), "the scene's folder") for line in problems]


def _stored(folder: Path, scene: bytes, kind: str, files: Mapping[str, bytes]) -> Path:
    if kind not in (".toml", ".json"):
        raise SceneError(f'scene: the ending "{kind[:20]}" is not known; send a .toml or .json file')
    if len(files) > MAX_UPLOAD_FILES:
        raise SceneError(f"files: {len(files)} files; at most {MAX_UPLOAD_FILES} go with a scene")
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
    """A scene given as data, as the text of a file; non-finite numbers stay in it, for the loader to name their place."""
    return json.dumps(scene).encode()
