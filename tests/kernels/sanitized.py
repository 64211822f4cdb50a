"""Runs the tests of the compiled kernels on a build that stops at each access out of bounds and at undefined behaviour:
`python -m tests.kernels.sanitized`. It needs gcc and its sanitizers, and says so where they are absent."""

import os
import shutil
import subprocess
import sys
import tempfile
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

from radar_service.kernels.build_backend import digest
from radar_service.kernels.library import FOLDER, NAME

CHECKS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-g"]
FLAGS = ["-std=c99", "-O1", "-ffp-contract=off", "-fno-math-errno", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]


def runtime() -> Path | None:
    """The library of the address sanitizer, which must be in the process before Python, or None."""
    if not shutil.which("gcc"):
        return None
    answer = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    file = Path(answer.stdout.strip())
    return file if file.is_absolute() else None  # gcc repeats a name that it does not find


def copied(root: Path, folder: Path) -> None:
    """Puts a tree into a folder whose package lies there itself, so that it may have other kernels."""
    shutil.copytree(
        root / "radar_service", folder / "radar_service", ignore=shutil.ignore_patterns("__pycache__", f"{NAME}.*")
    )
    for name in ("clients", "scenes", "tests", "pyproject.toml"):
        (folder / name).symlink_to(root / name)


def main() -> int:
    """Returns 0 where all tests pass, or where there are no sanitizers."""
    library = runtime()
    if library is None:
        print("kernels were not run under sanitizers: gcc or its libasan is absent")
        return 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copied(FOLDER.parents[1], folder)
        kernels = folder / "radar_service" / "kernels"
        built, sources = kernels / f"{NAME}{EXTENSION_SUFFIXES[0]}", sorted(map(str, kernels.glob("*.c")))
        subprocess.run(["gcc", *CHECKS, *FLAGS, f"-DSOURCES=0x{digest()}", *sources, "-o", str(built), "-lm"], check=True)
        # The interpreter frees little at its end; of its own memory nothing is checked
        checked = {"LD_PRELOAD": str(library), "ASAN_OPTIONS": "detect_leaks=0", "PYTHONMALLOC": "malloc"}
        environment = {**os.environ, **checked, "PYTHONPATH": name, "PYTHONDONTWRITEBYTECODE": "1"}
        look = "from radar_service.kernels import library; print(library.FOLDER)"
        used = subprocess.run(
            [sys.executable, "-c", look], cwd=name, env=environment, stdout=subprocess.PIPE, text=True, check=True
        )
        assert Path(used.stdout.strip()) == kernels, f"{used.stdout.strip()} was used in place of {kernels}"
        deselected = ["--deselect", "tests/kernels/test_build_backend.py", "--deselect", "tests/kernels/test_library.py"]
        tests = [sys.executable, "-m", "pytest", "-q", "-s", "-n", "0", "tests/kernels", *deselected]
        return subprocess.run(tests, cwd=name, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
