"""A temporary folder that belongs to one process. What a process that was killed has left goes when the next one starts.

The owner holds a lock on its folder, which the system releases however the owner ends; numbers of processes return, locks do not.
"""

import contextlib
import os
import shutil
import sys
import tempfile
import weakref
from pathlib import Path

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
