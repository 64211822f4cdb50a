"""Names the arithmetic of this process: all that its bytes depend on besides scene, fidelity, seed and commands.

Kernels of BLAS, and the vector instructions that numpy and the C library choose for the processor, round differently. Within one
arithmetic bytes are equal; between two they agree within -120 dB of the peak. The engine's compiled kernels are part of every
build, and have the same bytes whichever compiler made them.
"""

import os
import platform
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import scipy

from radar_service.numerics.parallel import loaded_blas

UMATH: Any = import_module("numpy._core._multiarray_umath")  # numpy has no public list of the instructions it chooses from
CPU_FEATURES: Mapping[str, bool] = UMATH.__cpu_features__


@cache
def arithmetic() -> str:
    """Returns the name of this process's arithmetic, such as
    "x86_64 glibc 2.36, numpy 2.3.5 AVX512_ICL, scipy 1.16.3, OpenBLAS 0.3.30 Haswell"."""
    return f"{_machine()}, numpy {np.__version__} {numpy_level()}, scipy {scipy.__version__}, {_blas()}"


def dispatched() -> list[str]:
    """Returns the groups of vector instructions, beyond its baseline, that numpy uses on this processor; rising."""
    return [name for name in UMATH.__cpu_dispatch__ if CPU_FEATURES.get(name)]


def numpy_level() -> str:
    """Returns the highest group of vector instructions that numpy uses here."""
    return str(["baseline", *UMATH.__cpu_baseline__, *dispatched()][-1])


def _machine() -> str:
    """The processor's family, and the C library, whose functions numpy calls."""
    libc = os.confstr("CS_GNU_LIBC_VERSION") if "CS_GNU_LIBC_VERSION" in getattr(os, "confstr_names", {}) else None
    return f"{platform.machine()} {libc or platform.system()}"


def _blas() -> str:
    """Name, version and core of the BLAS library that numpy multiplies with: its own, where it brings one."""
    libraries = sorted(loaded_blas(), key=lambda library: "numpy" not in library.filepath)
    return libraries[0].description if libraries else "BLAS of the system"
