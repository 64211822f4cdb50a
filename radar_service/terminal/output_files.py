"""Files that commands write: folders are made and nothing is overwritten unasked, before anything is computed.

A file is written as a whole or not at all, and an error names it.
"""

import argparse
import contextlib
import errno
import os
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)  # numbers of errors: nothing more can be written


def add_overwrite(parser: "argparse._ActionsContainer") -> None:
    """Adds the option without which no file is overwritten."""
    parser.add_argument("--overwrite", action="store_true", help="write over files that exist")


def prepare(paths: Iterable[Path | None], overwrite: bool) -> None:
    """Makes the folders of files to write; None stands for no file. Raises FileExistsError, and OSError for a folder that
    cannot be made."""
    files = [path for path in paths if path is not None]
    for path in files:
        if path.exists() and not overwrite:
            raise FileExistsError(errno.EEXIST, "it exists already; give --overwrite, or another name", str(path))
    for path in files:
        make_folder(path.parent)


def make_folder(folder: Path) -> None:
    """Makes a folder and those about it, where it is not there yet. Raises OSError that names it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:  # mkdir says "File exists" of a file in the way
        reason = (
            "a file is in the way of this folder; name another" if isinstance(error, FileExistsError) else error.strerror
        )
        raise OSError(error.errno, reason, error.filename) from None


def write_file(path: Path, content: str | bytes) -> None:
    """Writes a file as a whole or not at all. Raises OSError that names it."""
    with written(path) as part:
        part.write_bytes(content.encode() if isinstance(content, str) else content)


@contextlib.contextmanager
def written(path: Path) -> Iterator[Path]:
    """Yields a path beside `path`: a file or folder that the block writes there takes its place, or goes after an error.

    Raises OSError that names `path`.
    """
    target = path.resolve()  # a link stays
    part = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    if target.exists() and not (target.is_file() or target.is_dir()):
        part = target  # a device or a pipe
    try:
        with named_errors(path):
            yield part
            if part.is_dir():
                remove(target)
            part.replace(target)
    finally:
        if part != target:
            remove(part)


def remove(path: Path) -> None:
    """Removes a file or a folder, as far as it is there and may be removed."""
    shutil.rmtree(path, ignore_errors=True)
    with contextlib.suppress(OSError):
        path.unlink()


@contextlib.contextmanager
def named_errors(path: Path | str) -> Iterator[None]:
    """Raises OSError of the block, as of a full disk, with the name of this file or address."""
    try:
        yield
    except OSError as error:
        if error.errno is None:  # of a program
            raise OSError(f"{path}: {error}") from None
        raise OSError(error.errno, error.strerror, str(path)) from None
