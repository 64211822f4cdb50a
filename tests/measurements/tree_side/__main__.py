"""Runs a part of the comparison in the tree whose interpreter this is:
python -m tests.measurements.tree_side FOLDER PART [REAL]."""

import sys
import tempfile
from pathlib import Path

from tests.measurements.tree_side import in_process, service
from tests.measurements.tree_side.kept import Kept

PARTS = ("presets", "effects", "commands", "errors", "files", "service")


def main(folder: str, part: str, real: str = "") -> str:
    """Leaves the results in the folder; returns how many files they are. real: a folder of real input."""
    kept = Kept(Path(folder))
    with tempfile.TemporaryDirectory() as scratch:
        if part == "presets":
            in_process.presets(kept, Path(real) if real else None)
        elif part == "effects":
            in_process.effects(kept)
        elif part == "commands":
            in_process.commands(kept)
        elif part == "errors":
            in_process.errors(kept)
        elif part == "files":
            service.replayed(kept, in_process.files(kept, Path(scratch)))
        else:
            service.service(kept, Path(scratch))
    return f"{sum(path.is_file() for path in Path(folder).rglob('*'))} files"


if __name__ == "__main__":
    print(main(*sys.argv[1:]))
