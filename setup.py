"""Packages of the distribution: `clients/` and `scenes/` are installed inside `radar_service`. See pyproject.toml.

The kernels are plain C that Python opens by ctypes; radar_service/kernels/build_backend.py compiles them.
"""

import sys
import tempfile
from pathlib import Path

from setuptools import Extension, find_packages, setup

KERNELS = "radar_service/kernels"
sys.path.insert(0, str(Path(__file__).parent / KERNELS))
from build_backend import KernelBuild  # noqa: E402

INSIDE = {"radar_service.clients": "clients", "radar_service.scenes": "scenes"}
BUILD = tempfile.TemporaryDirectory()  # nothing of an earlier build, or of another tree, gets into this one

setup(
    packages=[
        *find_packages(include=["radar_service", "radar_service.*"]),
        *(f"radar_service.{name}" for name in find_packages(include=["clients", "clients.*", "scenes"])),
    ],
    package_dir=INSIDE,
    ext_modules=[Extension(KERNELS.replace("/", ".") + ".compiled", [])],
    cmdclass={"build_ext": KernelBuild},
    options={"build": {"build_base": BUILD.name}},
)
