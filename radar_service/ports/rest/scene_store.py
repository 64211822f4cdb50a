"""The scenes of a server: packaged ones, those in the owner's folders, and uploads, each in a folder of its own.

A folder belongs to the process that holds its lock, as numbers of processes return. What a killed one has left goes at the next
start.
"""

import contextlib
import os
import re
import shutil
import sys
import tempfile
import weakref
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from radar_service.service.jobs import Busy
from radar_service.service.scene_request import SceneRequest
from radar_service.world import SceneError, SceneOutline

HOME = "radar-scenes-"  # how the names of the folders of uploads begin
MAX_UPLOADS = 32
MAX_UPLOAD_BYTES = 64 * 2**20  # of one scene with its meshes
MAX_UPLOAD_FILES = 64
MAX_RECEIVING = 16  # bodies that arrive at a time: a gigabyte on the disk
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _-]{0,63}")
FILE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,127}")

Origin = Literal["packaged", "folder", "uploaded"]


if sys.platform != "win32":
    import fcntl

NO_LOCK = -1


class OwnedFolder:
    """A new folder whose name begins with a prefix. It goes with `close`, or with this object. Raises OSError.

    path: of the folder.
    """

    def __init__(self, prefix: str) -> None:
        remove_abandoned(prefix)
        lock = None
        while lock is None:  # another process may take it for abandoned
            path = Path(tempfile.mkdtemp(prefix=prefix))
            try:
                lock = NO_LOCK if sys.platform == "win32" else _locked(path)
            except OSError:  # the system has no locks there, so that nobody takes it for abandoned
                lock = NO_LOCK
        self.path = path
        self._remove = weakref.finalize(self, _remove, path, lock)

    def close(self) -> None:
        """Removes the folder."""
        self._remove()


def remove_abandoned(prefix: str) -> None:
    """Removes the folders of that prefix whose owners have ended, where the system has locks. Folders of other users stay."""
    if sys.platform == "win32":
        return
    for path in Path(tempfile.gettempdir()).glob(f"{prefix}*"):
        with contextlib.suppress(OSError):
            if path.lstat().st_uid == os.geteuid() and (lock := _locked(path)) is not None:
                _remove(path, lock)


def _locked(path: Path) -> int | None:
    """Returns the descriptor that holds the lock on a folder; None where it is gone, or another process holds it.

    Raises OSError where it cannot be locked.
    """
    try:
        lock = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(os.fstat(lock), path.stat()):
            return lock
    except (BlockingIOError, FileNotFoundError):
        pass
    except OSError:
        os.close(lock)
        raise
    os.close(lock)
    return None


def _remove(path: Path, lock: int) -> None:
    shutil.rmtree(path, ignore_errors=True)
    if lock != NO_LOCK:
        os.close(lock)


class Conflict(Exception):
    """A request that contradicts the present state of a scene. The text says why and what to do."""


class UploadFolder:
    """A folder that is removed when nobody uses it any more: neither the list of scenes nor a radar that runs its scene."""

    def __init__(self, home: Path) -> None:
        self.path = Path(tempfile.mkdtemp(dir=home))
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)

    def scene_request(self, name: str) -> SceneRequest:
        """Returns the scene request of the scene in one of its files."""
        return SceneRequest(self.path / name, sandboxed=True, folder=self)


@dataclass(frozen=True)
class SceneEntry:
    """A scene of the list: its name, how to run it, where it comes from, and what an upload was found to contain."""

    name: str
    scene_request: SceneRequest
    origin: Origin
    outline: SceneOutline | None = None

    def summary(self) -> dict[str, Any]:
        """Returns what the scene contains, but for uploads read from its file; `problems` where it cannot be read."""
        summary: dict[str, Any] = {"name": self.name, "origin": self.origin, "problems": []}
        try:
            return summary | (_of_outline(self.outline) if self.outline else _of_file(self.scene_request))
        except SceneError as error:
            problems = _without_folder(error.problems, Path(str(self.scene_request.scene_input)).parent)
            return summary | {"title": self.name, "summary": "cannot be read", "problems": problems}


def checked_name(name: str) -> str:
    """Returns a name that can be listed and be part of an address. Raises SceneError otherwise."""
    if not NAME.fullmatch(name):
        raise SceneError(
            f"name: {name[:80]!r} is not a name for a scene; use 1 to 64 letters, digits, spaces, - and _, "
            "a letter or digit first"
        )
    return name


def checked_file_names(names: Iterable[str], *taken: str) -> None:
    """Raises SceneError where the files of an upload cannot lie in one folder beside those whose names are taken."""
    names = list(names)
    if len(names) > MAX_UPLOAD_FILES:
        raise SceneError(f"files: {len(names)} files; at most {MAX_UPLOAD_FILES} are allowed with a scene")
    for name in names:
        if not FILE_NAME.fullmatch(name) or name in taken:
            raise SceneError(
                f"files: {name[:80]!r} is not a plain file name; letters, digits, spaces and ._- without folders"
            )


class SceneStore:
    """All scenes of a server. Uploads live in the temporary folder `home`, which goes with `close` or with the store,
    or where the service was killed when the next one starts.

    sandbox_all: whether the files of the server's owner, too, are parsed in a limited process.
    """

    def __init__(self, folders: Iterable[Path], sandbox_all: bool = False) -> None:
        self._folders, self._sandbox_all = tuple(folders), sandbox_all
        self._folder = OwnedFolder(HOME)
        self.home = self._folder.path
        self._uploads: dict[str, SceneEntry] = {}
        self._receiving = 0

    def close(self) -> None:
        """Removes the uploads."""
        self._folder.close()

    def entries(self) -> list[SceneEntry]:
        """Returns the scenes by name. Of equal names an upload comes before a scene of a folder, that before a packaged one."""
        from radar_service.scene_file import packaged_scenes, scene_path  # here: a start does not wait for them

        entries = {name: self._owned(name, scene_path(name), "packaged") for name in packaged_scenes()}
        for folder in self._folders:
            for path in sorted([*folder.glob("*.toml"), *folder.glob("*.json")]):
                entries[path.stem] = self._owned(path.stem, path, "folder")
        return [entry for _, entry in sorted((entries | self._uploads).items())]

    def scene_request(self, name: str) -> SceneRequest:
        """Returns how to run the scene of that name. Raises KeyError where there is none."""
        return {entry.name: entry for entry in self.entries()}[name].scene_request

    @contextlib.contextmanager
    def receiving(self) -> Iterator[UploadFolder]:
        """Gives a folder for a body that arrives. Raises Busy where too many arrive."""
        if self._receiving >= MAX_RECEIVING:
            raise Busy(f"{self._receiving} bodies arrive; try again later")
        self._receiving += 1
        try:
            yield UploadFolder(self.home)
        finally:
            self._receiving -= 1

    def check_room(self, name: str) -> None:
        """Raises SceneError for a name that cannot be listed, and Conflict when the store is full."""
        checked_name(name)
        if name not in self._uploads and len(self._uploads) >= MAX_UPLOADS:
            raise Conflict(f"{MAX_UPLOADS} uploaded scenes are kept; delete one first")

    def add(self, name: str, scene_request: SceneRequest, outline: SceneOutline) -> None:
        """Adds an uploaded scene that was found to be good; replaces one of the same name. Raises as check_room."""
        self.check_room(name)
        self._uploads[name] = SceneEntry(name, scene_request, "uploaded", outline)

    def remove(self, name: str) -> SceneRequest:
        """Deletes an upload, and returns its scene request. Raises KeyError where there is no such scene, Conflict where it
        is not an upload."""
        if name not in self._uploads:
            if any(entry.name == name for entry in self.entries()):
                raise Conflict(f'"{name}" is not an upload and cannot be deleted here')
            raise KeyError(name)
        return self._uploads.pop(name).scene_request

    def _owned(self, name: str, path: Path, origin: Origin) -> SceneEntry:
        return SceneEntry(name, SceneRequest(path, self._sandbox_all), origin)


@contextlib.contextmanager
def without_folder(scene_request: SceneRequest) -> Iterator[None]:
    """Removes the path of the scene's folder from the lines of a SceneError: clients need not know it."""
    try:
        yield
    except SceneError as error:
        if isinstance(scene_request.scene_input, Path):
            raise SceneError(*_without_folder(error.problems, scene_request.scene_input.parent)) from None
        raise


def _without_folder(problems: Iterable[str], folder: Path) -> list[str]:
    return [line.replace(f"{folder}/", "").replace(str(folder), "the scene's folder") for line in problems]


def _of_outline(scene: SceneOutline) -> dict[str, str]:
    rpm = 60.0 / scene.radar.rotation_period
    return {"title": scene.name, "summary": _text(scene.body_count, scene.radar.range_max, rpm, len(scene.radar_ids))}


def _of_file(scene_request: SceneRequest) -> dict[str, str]:
    from radar_service.scene_file import (
        model_from,  # here, as above
        radar_entries,
    )

    model = model_from(scene_request.scene_input)
    first, *others = (entry.model for entry in radar_entries(model.radar))
    return {"title": model.name, "summary": _text(len(model.body), first.range_max_m, first.rpm, 1 + len(others))}


def _text(bodies: int, range_max: float, rpm: float, radars: int) -> str:
    several = f"{radars} radars, the first: " if radars > 1 else ""
    return f"{several}{bodies} bodies, {range_max:g} m, {rpm:g} rpm"
