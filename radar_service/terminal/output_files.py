"""Files that commands write: their folders are made, and no file is overwritten unasked. Both before anything is computed."""

import argparse
import errno
from collections.abc import Iterable
from pathlib import Path


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
