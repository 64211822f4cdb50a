"""The compiled kernels of this process: plain C, built by setuptools where there is a compiler. They are called by ctypes, which
releases the interpreter's lock meanwhile.

Each kernel does what the numpy code beside its call does, and agrees with it within -120 dB of the peak. That code runs where the
kernels were not built, and where the environment has RADAR_SERVICE_KERNELS=off. It may also name the file of another build.
"""

import ctypes
import hashlib
import os
from collections.abc import Callable
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

SWITCH = "RADAR_SERVICE_KERNELS"
FOLDER = Path(__file__).parent
NAME = "compiled"
NO_RAYS = -2  # what a kernel returns that stops, as its rays were not traced
ABSENT = (
    "compiled kernels are absent, or were built from other sources: ships take longer to compute; with a C compiler "
    "`pip install` (in a checkout `pip install -e .`) builds them"
)

# What each kernel takes: n and r are a count and a real number; f, s, c, i, b are C-contiguous arrays of float64, float32,
# complex128, int64, and of bytes (bool or int8); t is a call that traces rays. Each returns a count.
PROTOTYPES = {
    "own_shadow_rays": "nnfrrrrrfrffffssff",
    "own_shadow_hits": "niiffffi",
    "shadow_edge_step": "nriifffffiffiffffi",
    "shadow_tips": "nnfbibff",
    "shadow_cuts": "nnnfbfibffiffi",
    "stand_before": "nnnffffrrfb",
    "cast_lit": "nnfffb",
    "cast_dark": "nnfffb",
    "cast_cuts": "nnnnfffffffib",
    "shadow_planes": "nfffff",
    "silhouettes": "nfff",
    "leg_rays": "nnffrrfrfffffffb",
    "leg_lengths": "nnffrrfrf",
    "leg_weights": "nffrrfrf",
    "phasors": "nfc",
    "facet_shapes": "nfifff",
    "sags": "nnffffffff",
    "facet_fields": "nnnnniffbf" + 2 * "fffffffcf" + "c",
    "tube_fields": "nnnrffffffffiffffffffcf",
    "turned_corners": "nffff",
    "kept_tubes": "nnnriffffffff" + "ff" + "ffffff" + "fii",
    "lattice_nodes": "nnnffffif",
    "lattice_between": "nifff",
    "lattice_sums": "nnnifcc",
    "cut_triangles": "nnfffi",
    "welded": "nfif",
    "dry_facets": "nfiriii",
    "renumbered": "nniiii",
    "reflect_tubes": "nnnnnnn" + "fffffff" + "iiiffif" + "fiififff" + "rfti",
    "take_tubes": "nniiffffff",
    "surface_points": "nnfiffffi",
    "strata": "nnnfffriifff",
    "spread_points": "nnnnnififcs",
    "convex_fields": "nnnnnnnnnnrrrr" + "fiiffb" + "ifif" + "ffff" + "ifff" + "iiff" + "ci",
    "echo_positions": "nnnniffibifffff" + "f",
    "beam_weights": "nnnrsssssss",
    "lines_of_sight": "nnnrifffffifff" + "iffff",
    "points_behind": "niiiffiffii",
    "spread_series": "nnnnnnnnnfssss",
}
_DTYPES = {
    "f": (np.dtype(np.float64),),
    "s": (np.dtype(np.float32),),
    "c": (np.dtype(np.complex128),),
    "i": (np.dtype(np.int64),),
    "b": (np.dtype(np.bool_), np.dtype(np.int8)),
}
_memory: Callable[[Any], ctypes.c_char] = ctypes.c_char.from_buffer
_address = ctypes.addressof
RAY_CALL = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_SCALARS = {"n": ctypes.c_int64, "r": ctypes.c_double, "t": RAY_CALL}

FirstHit = Callable[[NDArray[np.float32], NDArray[np.float32]], NDArray[np.int64]]
Argument = NDArray[Any] | int | float | Any


class _Memory:
    """Memory as numpy takes it; a type of ctypes for each count takes 0.1 ms."""

    def __init__(self, address: int, shape: tuple[int, ...], kind: str) -> None:
        self.__array_interface__ = {"data": (address, False), "shape": shape, "typestr": kind, "version": 3}


class Kernels:
    """The kernels of one library."""

    def __init__(self, file: Path) -> None:
        library = ctypes.CDLL(str(file))
        self._functions = {name: (getattr(library, name), kinds) for name, kinds in PROTOTYPES.items()}
        for function, kinds in self._functions.values():
            function.argtypes = [_SCALARS.get(kind, ctypes.c_void_p) for kind in kinds]
            function.restype = ctypes.c_int64

    def run_with_rays(self, name: str, first_hit: FirstHit, *arguments: Argument) -> int:
        """Runs a kernel whose last but one argument is a call that traces rays: first_hit takes begins and directions (M, 3) and
        returns triangles (M,). Raises what it raises, MemoryError, and KeyboardInterrupt where ctypes dropped it."""
        raised: list[BaseException] = []

        def traced(count: int, begin: int, direction: int, hit: int) -> int:
            try:
                rays = (np.asarray(_Memory(at, (count, 3), "<f4")) for at in (begin, direction))
                np.asarray(_Memory(hit, (count,), "<i8"))[:] = first_hit(*rays)
            except BaseException as error:  # C cannot pass it on
                raised.append(error)
                return 1
            return 0

        count = self._returned(name, *arguments[:-1], RAY_CALL(traced), arguments[-1])
        if raised:
            raise raised[0]
        if count == NO_RAYS:  # a signal came before the first line of `traced`: what its handler raised is lost
            raise KeyboardInterrupt
        return _counted(name, count)

    def run(self, name: str, *arguments: Argument) -> int:
        """Runs a kernel. Raises TypeError for an array of another type than it takes, or one that is not C-contiguous."""
        return _counted(name, self._returned(name, *arguments))

    def _returned(self, name: str, *arguments: Argument) -> int:
        """What a kernel returns."""
        function, kinds = self._functions[name]
        return int(function(*[_passed(kind, argument) for kind, argument in zip(kinds, arguments, strict=True)]))


def _counted(name: str, count: int) -> int:
    """What a kernel returned, where it is a count."""
    if count < 0:
        raise MemoryError(f"{name}: no memory")
    return count


def _passed(kind: str, argument: Argument) -> int | float:
    """An argument as ctypes takes it: a number, or where an array lies."""
    if not isinstance(argument, np.ndarray):
        return argument
    if argument.dtype in _DTYPES[kind]:
        try:
            return _address(_memory(argument))  # a fifth of the time of `ctypes.data`
        except (TypeError, ValueError):  # read-only, empty, or with gaps
            if argument.flags.c_contiguous:
                return int(argument.ctypes.data)
    raise TypeError(f"array of {argument.dtype}, strides {argument.strides}: a kernel takes C-contiguous {_DTYPES[kind]}")


def library_file() -> Path | None:
    """Where the library lies that setuptools built from these sources, or None."""
    files = (FOLDER / f"{NAME}{suffix}" for suffix in EXTENSION_SUFFIXES)
    return next((file for file in files if file.is_file() and _sources_of(file) == _digest()), None)


def _digest() -> int:
    """The digest of the sources, as setup.py has it."""
    files = sorted([*FOLDER.glob("*.c"), *FOLDER.glob("*.h")], key=lambda file: file.name)
    return int(hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:15], 16)


def _sources_of(file: Path) -> int | None:
    """The digest of the sources that a library was built from; None for one of another kind, or of another machine."""
    try:
        sources = ctypes.CDLL(str(file)).sources
    except (OSError, AttributeError):
        return None
    sources.restype = ctypes.c_int64
    return int(sources())


def chosen_file() -> Path | None:
    """Where the library lies that the environment chooses, or None for numpy."""
    choice = os.environ.get(SWITCH, "")
    if choice == "off":
        return None
    if choice and not Path(choice).is_file():
        raise ValueError(
            f'{SWITCH}: "{choice}" is neither off nor the file of a library; leave it out for the kernels built with the package'
        )
    return Path(choice) if choice else library_file()


def _loaded() -> Kernels | None:
    file = chosen_file()
    return Kernels(file) if file is not None else None


LOADED = _loaded()


def kernels() -> Kernels | None:
    """The kernels of this process; None: numpy does their work."""
    return LOADED


def complaint() -> str | None:
    """What to tell the user at the start of a program, where there is anything to tell."""
    return ABSENT if LOADED is None and os.environ.get(SWITCH) != "off" else None
