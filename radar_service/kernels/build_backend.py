"""Builds the package as setuptools does, always with its kernels. Where no C compiler works, and on Windows, it asks for the
package `ziglang`, which brings one. It imports nothing of the package: an environment that builds has setuptools alone.
"""

import hashlib
import os
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from setuptools import Extension
from setuptools.build_meta import *  # noqa: F403  # the hooks of a build, but for two below
from setuptools.command.build_ext import build_ext

KERNELS = Path(__file__).resolve().parent
COMPILER = "ziglang>=0.14"
# One rounding for each operation, whatever the compiler would fuse: equal sources give equal bytes. No errno of `sqrt` is read.
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fwrapv", "-shared"]
FLAGS += [] if sys.platform == "win32" else ["-fPIC"]
ZIG = [
    "-m",
    "ziglang",
    "cc",
    "-mcpu=baseline",
    "-fno-sanitize=undefined",
]  # for any processor of the kind, as others compile
TRIAL = "#include <math.h>\n#include <stdint.h>\ndouble trial(double x) { return sin(x); }\n"
NONE = (
    "radar-service compiles kernels, and no C compiler works here: install one (Debian: apt-get install gcc libc6-dev), or "
    "ziglang into this environment, or leave out --no-build-isolation, so that pip fetches ziglang for the build"
)


def get_requires_for_build_wheel(config_settings: object = None) -> list[str]:
    """What the environment of a build needs besides setuptools."""
    return [] if compiler() else [COMPILER]


get_requires_for_build_editable = get_requires_for_build_wheel


def compiler() -> list[str] | None:
    """The command of a C compiler of this machine that works: the one that CC names, or Python's own, or `cc`; else None."""
    if sys.platform == "win32":
        return None
    named = os.environ.get("CC")
    candidates = [named] if named else [str(sysconfig.get_config_var("CC") or "cc"), "cc", "gcc", "clang"]
    return next((command for text in candidates if _compiles(command := shlex.split(text))), None)


def _compiles(command: Sequence[str]) -> bool:
    """Whether a command makes a library of a few lines of C; not without the C library's headers, and `/bin/false` never."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "trial.c")
        source.write_text(TRIAL, encoding="ascii")
        try:
            return not subprocess.run(
                [*command, *FLAGS, str(source), "-o", f"{source}.so", "-lm"], capture_output=True
            ).returncode
        except OSError:
            return False


def digest() -> str:
    """The digest of the sources, as library.py has it."""
    sources = sorted([*KERNELS.glob("*.c"), *KERNELS.glob("*.h")], key=lambda file: file.name)
    return hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()[:15]


class KernelBuild(build_ext):  # type: ignore[misc]  # setuptools has no types
    """Compiles the kernels in one command, always anew. Ends the build in a sentence where that fails."""

    def build_extension(self, ext: Extension) -> None:
        """Puts the library where setuptools expects the module `ext`."""
        command = compiler() or ([sys.executable, *ZIG] if find_spec("ziglang") else None)
        if command is None:
            raise SystemExit(NONE)
        target = Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        files = sorted(str(file) for file in KERNELS.glob("*.c"))
        with tempfile.TemporaryDirectory() as cache:  # of ziglang; of another build it is of no use
            environment = {"ZIG_LOCAL_CACHE_DIR": cache, "ZIG_GLOBAL_CACHE_DIR": cache, **os.environ}
            code = subprocess.run(
                [*command, *FLAGS, f"-DSOURCES=0x{digest()}", *files, "-o", str(target), "-lm"], env=environment
            ).returncode
        if code:
            raise SystemExit(f"{shlex.join(command)} could not compile the kernels of radar-service: its words are above")
