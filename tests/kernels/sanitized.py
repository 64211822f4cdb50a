"""Runs the tests of the compiled kernels on a build that stops at each access out of bounds and at undefined behaviour:
`python -m tests.kernels.sanitized`. It needs gcc and its sanitizers, and says so where they are absent."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from radar_service.kernels.library import FOLDER, SWITCH

CHECKS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-g"]
FLAGS = ["-std=c99", "-O1", "-ffp-contract=off", "-fno-math-errno", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]


def runtime() -> Path | None:
    """The library of the address sanitizer, which must be in the process before Python, or None."""
    if not shutil.which("gcc"):
        return None
    answer = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    file = Path(answer.stdout.strip())
    return file if file.is_absolute() else None  # gcc repeats a name that it does not find


def main() -> int:
    """Returns 0 where all tests pass, or where there are no sanitizers."""
    library = runtime()
    if library is None:
        print("kernels were not run under sanitizers: gcc or its libasan is absent")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        built = Path(folder) / "kernels.so"
        sources = [str(file) for file in sorted(FOLDER.glob("*.c"))]
        subprocess.run(["gcc", *CHECKS, *FLAGS, *sources, "-o", str(built), "-lm"], check=True)
        # The interpreter frees little at its end; of its own memory nothing is checked
        checked = {
            "LD_PRELOAD": str(library),
            "ASAN_OPTIONS": "detect_leaks=0",
            SWITCH: str(built),
            "PYTHONMALLOC": "malloc",
        }
        tests = [sys.executable, "-m", "pytest", "-q", "-s", "-n", "0", str(Path(__file__).parent)]
        return subprocess.run(tests, env={**os.environ, **checked}).returncode


if __name__ == "__main__":
    sys.exit(main())
