"""Access to the folder of a scene: regular files inside it only, symbolic links resolved, sizes limited."""

import stat
from dataclasses import dataclass
from pathlib import Path

from radar_service.world import SceneError

ESCAPED = "\b\t\n\f\r"  # what a backslash before a letter makes in TOML and JSON
FORWARD = 'write paths with forward slashes, as "meshes/ferry.obj"'


@dataclass(frozen=True)
class SceneFolder:
    """The folder that a scene may read from; path is None where the scene came without one."""

    path: Path | None

    def find(self, name: str, location: str) -> Path:
        """Returns the path of the file `name` (relative, forward slashes). Raises SceneError at `location` if it may not
        be read or does not exist."""
        if self.path is None:
            raise SceneError(f'{location}: "{name:.200}" is a file, but this scene came without a folder; pass folder=')
        if "\\" in name or any(letter in name for letter in ESCAPED):
            plain = name[:200].encode("unicode_escape").decode()
            raise SceneError(f'{location}: "{plain}" has a backslash, or what an escape makes of one; {FORWARD}')
        if Path(name).is_absolute() or ":" in name or ".." in Path(name).parts:
            raise SceneError(
                f'{location}: "{name:.200}" leaves the scene\'s folder; only paths below {self.path} are allowed: '
                "copy the file there"
            )
        try:
            root = self.path.resolve()
            path = (root / name).resolve()
            if not path.is_relative_to(root):
                raise SceneError(f'{location}: "{name:.200}" is a link out of {self.path}; copy the file there')
            mode = _mode(path)
            if stat.S_ISDIR(mode):
                raise SceneError(f'{location}: "{name:.200}" is a folder; name a file in it')
            if not stat.S_ISREG(mode):
                raise SceneError(
                    f'{location}: "{name:.200}" is not a file in {self.path}; correct the name or put the file there'
                )
        except (OSError, ValueError, RuntimeError) as error:
            if isinstance(error, SceneError):
                raise
            raise SceneError(f'{location}: "{name[:200]!r}" cannot be looked up ({error}); use a plain file name') from None
        return path

    def read(self, name: str, location: str, max_bytes: int) -> bytes:
        """Returns the content of the file `name`. Raises SceneError at `location`, also above `max_bytes`."""
        return read_limited(self.find(name, location), f'{location}: "{name:.200}"', max_bytes)


def _mode(path: Path) -> int:
    """Returns the mode of a file, 0 if it does not exist. Raises OSError for links in a circle, which `is_file` ignores."""
    try:
        return path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return 0


def read_limited(path: Path, location: str, max_bytes: int) -> bytes:
    """Returns the content of a file of at most `max_bytes`. Raises SceneError at `location`."""
    try:
        with path.open("rb") as file:
            content = file.read(max_bytes + 1)
    except (OSError, ValueError) as error:
        raise SceneError(f"{location}: cannot be read ({error}); make it a readable file") from None
    if len(content) > max_bytes:
        raise SceneError(f"{location}: the file is larger than {max_bytes} bytes; make it smaller")
    return content
