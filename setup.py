"""Packages of the distribution: `clients/` and `scenes/` are installed inside `radar_service`. See pyproject.toml.

The kernels are plain C that Python opens by ctypes; radar_service/kernels/build_backend.py compiles them. A package index
resolves no path, and no address of this project is known: its page is the README without pictures, with paths of the sdist.
"""

import re
import sys
import tempfile
from pathlib import Path

from setuptools import Extension, find_packages, setup

KERNELS = "radar_service/kernels"
sys.path.insert(0, str(Path(__file__).parent / KERNELS))
from build_backend import KernelBuild  # noqa: E402

INSIDE = {"radar_service.clients": "clients", "radar_service.scenes": "scenes"}
README = (Path(__file__).parent / "README.md").read_text(encoding="utf-8")
PATHS = re.sub(r"\[([^]]+)\]\((?!https?:|#)([^)]+)\)", r"\1 (`\2`)", re.sub(r"^.*!\[.*\n", "", README, flags=re.M))
BUILD = tempfile.TemporaryDirectory()  # nothing of an earlier build, or of another tree, gets into this one

setup(
    long_description=PATHS.replace("\n\n", "\n\nPaths are those of the source distribution.\n\n", 1),
    long_description_content_type="text/markdown",
    packages=[
        *find_packages(include=["radar_service", "radar_service.*"]),
        *(f"radar_service.{name}" for name in find_packages(include=["clients", "clients.*", "scenes"])),
    ],
    package_dir=INSIDE,
    ext_modules=[Extension(KERNELS.replace("/", ".") + ".compiled", [])],
    cmdclass={"build_ext": KernelBuild},
    options={"build": {"build_base": BUILD.name}},
)
