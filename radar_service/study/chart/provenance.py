"""Where and with what a chart was made."""

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

HERE = Path(__file__)


def machine() -> dict[str, str | int]:
    """The processor and the libraries that times depend on."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "embreex")}
    return {"processor": _processor(), "cores": os.cpu_count() or 1, "system": platform.platform(),
            "python": platform.python_version(), **libraries}  # fmt: skip


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def commit() -> str:
    """The commit of this checkout, with + where it has been changed since; the version where it is no checkout."""

    def git(*words: str) -> str:
        asked = subprocess.run(["git", "-C", str(HERE.parent), *words], capture_output=True, text=True, timeout=10)
        return asked.stdout.strip() if asked.returncode == 0 else ""

    try:
        if git("ls-files", HERE.name):  # an environment may lie inside somebody else's checkout
            return git("rev-parse", "HEAD") + ("+" if git("status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.TimeoutExpired):
        pass
    try:
        return f"version {version('radar-service')}"
    except PackageNotFoundError:
        return "unknown"
