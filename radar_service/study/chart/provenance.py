"""The machine, the libraries and the commit of a measurement."""

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

HERE = Path(__file__)


def machine() -> dict[str, str | int]:
    """Returns the processor and the versions that CPU times depend on."""
    libraries = {name: _version(name) for name in ("numpy", "scipy", "embreex")}
    return {"processor": _processor(), "cores": os.cpu_count() or 1, "system": platform.platform(),
            "python": platform.python_version(), **libraries}  # fmt: skip


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:  # embreex, where it has no wheel
        return "not installed"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def commit() -> str:
    """Returns the commit of this checkout, with "+" after local changes; outside of a checkout the version."""

    def git(*arguments: str) -> str:
        run = subprocess.run(["git", "-C", str(HERE.parent), *arguments], capture_output=True, text=True, timeout=10)
        return run.stdout.strip() if run.returncode == 0 else ""

    try:
        if git("ls-files", HERE.name):  # the environment may lie inside another project's checkout
            return git("rev-parse", "HEAD") + ("+" if git("status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.TimeoutExpired):
        pass
    try:
        return f"version {version('radar-service')}"
    except PackageNotFoundError:
        return "unknown"
