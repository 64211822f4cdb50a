"""Results of jobs as JSON files of a folder, so that a command that was stopped goes on where it was."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from radar_service.batch.jobs import Job
from radar_service.terminal.output_files import make_folder

MAX_NAME = 100  # characters of a file's name: a job may be named after a command that is longer than file systems take


class ResultFolder:
    """A `Kept`. Results are JSON objects."""

    def __init__(self, folder: Path) -> None:
        """folder: is made where it is absent. Raises OSError."""
        make_folder(folder)
        self.folder = folder

    def path(self, name: str) -> Path:
        """The file of a job."""
        plain = "".join(c if c.isascii() and c.isalnum() or c in "-_" else "-" for c in name)[:MAX_NAME]
        return self.folder / f"{plain}-{hashlib.blake2b(name.encode(), digest_size=4).hexdigest()}.json"

    def read(self, job: Job) -> dict[str, Any] | None:
        """Returns the result of a job, where its file is whole and was made of the same; None otherwise."""
        try:
            result: dict[str, Any] = json.loads(self.path(job.name).read_text(encoding="utf-8"))
            return result if {name: result[name] for name in job.made_of} == dict(job.made_of) else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def write(self, job: Job, result: Any) -> Any:
        """Writes the file as a whole or not at all; returns the result as JSON has it. Raises OSError."""
        path, text = self.path(job.name), json.dumps(result, allow_nan=False)
        part = path.with_suffix(".part")
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
        return json.loads(text)
