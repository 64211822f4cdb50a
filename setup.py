"""Packages of the distribution: `clients/` and `scenes/` are installed inside `radar_service`. See pyproject.toml.

The kernels are plain C that Python opens by ctypes. A machine without a compiler installs without them.
"""

import hashlib
from pathlib import Path

from setuptools import Extension, find_packages, setup

INSIDE = {"radar_service.clients": "clients", "radar_service.scenes": "scenes"}
KERNELS = Path("radar_service/kernels")
SOURCES = sorted([*KERNELS.glob("*.c"), *KERNELS.glob("*.h")], key=lambda file: file.name)
DIGEST = hashlib.sha256(b"".join(file.read_bytes() for file in SOURCES)).hexdigest()[:15]  # as kernels/library.py has it
# One rounding for each operation, whatever the compiler would fuse: equal sources give equal bytes. No errno of `sqrt` is read.
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno"]

setup(
    packages=[
        *find_packages(include=["radar_service", "radar_service.*"]),
        *(f"radar_service.{name}" for name in find_packages(include=["clients", "clients.*", "scenes"])),
    ],
    package_dir=INSIDE,
    ext_modules=[
        Extension(
            "radar_service.kernels.compiled",
            [file.as_posix() for file in SOURCES if file.suffix == ".c"],
            depends=[file.as_posix() for file in SOURCES if file.suffix == ".h"],
            define_macros=[("SOURCES", f"0x{DIGEST}")],
            extra_compile_args=FLAGS,
            optional=True,
        )
    ],
)
