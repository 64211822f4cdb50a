"""Reading a scene's files: only regular files inside the scene's own folder, symbolic links resolved, sizes capped."""

import stat
from dataclasses import dataclass
from pathlib import Path

from radar_service.scene.error import SceneError


@dataclass(frozen=True)
class SceneFolder:
    """The folder that a scene may read from; None where the scene came without one."""

    path: Path | None

    def find(self, name: str, place: str) -> Path:
        """The file `name` (relative, forward slashes). SceneError naming `place` where it cannot be had."""
        if self.path is None:
            raise SceneError(f'{place}: "{name:.200}" is a file, but this scene came without a folder; pass folder=')
        if Path(name).is_absolute() or "\\" in name or ":" in name or ".." in Path(name).parts:
            raise SceneError(
                f'{place}: "{name:.200}" leaves the scene\'s folder; only paths below {self.path} are allowed: '
                "copy the file there"
            )
        try:
            root = self.path.resolve()
            found = (root / name).resolve()
            if not found.is_relative_to(root):
                raise SceneError(f'{place}: "{name:.200}" leads out of {self.path} through a link; copy the file there')
            mode = _mode(found)
            if stat.S_ISDIR(mode):
                raise SceneError(f'{place}: "{name:.200}" is a folder; name a file in it')
            if not stat.S_ISREG(mode):
                raise SceneError(
                    f'{place}: "{name:.200}" is not a file in {self.path}; correct the name or put the file there'
                )
        except (OSError, ValueError, RuntimeError) as fault:
            if isinstance(fault, SceneError):
                raise
            raise SceneError(f'{place}: "{name[:200]!r}" cannot be looked up ({fault}); use a plain file name') from None
        return found

    def read(self, name: str, place: str, limit: int) -> bytes:
        """The content of the file `name`, at most `limit` bytes. Raises SceneError naming `place`."""
        return read_limited(self.find(name, place), f'{place}: "{name:.200}"', limit)


def _mode(path: Path) -> int:
    """What stands there, as `stat` says; 0 for nothing. Raises OSError for links in a circle, which `is_file` would hide."""
    try:
        return path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return 0


def read_limited(path: Path, place: str, limit: int) -> bytes:
    """The content of a file of at most `limit` bytes. Raises SceneError that begins with `place`."""
    try:
        with path.open("rb") as file:
            content = file.read(limit + 1)
    except (OSError, ValueError) as fault:
        raise SceneError(f"{place}: cannot be read ({fault}); make it a readable file") from None
    if len(content) > limit:
        raise SceneError(f"{place}: larger than {limit} bytes, the most that is read; make it smaller")
    return content
