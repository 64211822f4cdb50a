"""The compiled kernels: plain C, built with the package (`build_backend`). ctypes calls them without the interpreter's lock.

The C text declares each kernel, and this module makes a function of it: `KERNELS.phasors(count, phase, result)`. Types, and what
is written, are those of the prototype; a kernel of more than twelve arguments takes a struct of them. A comment gives the shapes:

    /* Arrays: points (V, 3); corner (3, count) < V; area (count) */

`count` is an argument, V what the first array that has it says. Indices may have a range, `from -1 < V`, and so may counts, which
are not negative. Each array that does not fit, or lies in memory with gaps, is a ValueError that names it.
"""

import ctypes
import hashlib
import operator
import re
import struct
from collections.abc import Callable, Iterator
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

FOLDER = Path(__file__).parent
NAME = "compiled"
ABSENT = (
    "the compiled kernels are absent, or were built from other sources: `pip install` (in a checkout `pip install -e .`) "
    "builds them"
)
NO_MEMORY = -1  # what a kernel returns that stops for it, as geometry.h has it; another negative number: it refuses
DTYPES = {
    "double": (np.dtype(np.float64),),
    "float": (np.dtype(np.float32),),
    "Complex": (np.dtype(np.complex128),),
    "int64_t": (np.dtype(np.int64),),
    "int8_t": (np.dtype(np.int8), np.dtype(np.bool_)),
    "uint8_t": (np.dtype(np.bool_), np.dtype(np.uint8)),
}
SCALARS: dict[str, Any] = {"int64_t": ctypes.c_int64, "double": ctypes.c_double}
PROTOTYPE = re.compile(r"(?:/\* Arrays: ((?:(?!\*/)[^\0])*) \*/\n)?^KERNEL int64_t (\w+)\(([^)]*)\) \{", re.M)
STRUCT = re.compile(r"^typedef struct \{([^}]*)\} (\w+);", re.M)
FIELD = re.compile(r"(const )?(\w+) (\*?)(\w+)")
ENTRY = re.compile(r"([\w, ]+?)(?: \(([^)]*)\))?(?: from (.+?))?(?: < (.+))?")
_memory: Callable[[Any], ctypes.c_char] = ctypes.c_char.from_buffer  # of what is writable and contiguous

Function = Callable[..., int]


class Argument(NamedTuple):
    """An argument of a kernel: `kind` in C; `shape`, of expressions, None for a number; the range of its integers."""

    name: str
    kind: str
    is_written: bool
    shape: tuple[str, ...] | None
    low: str | None
    limit: str | None


class Prototype(NamedTuple):
    """A kernel as the C text declares it; is_struct: whether it takes the arguments in a struct. `free` names sizes that no
    argument has: the array and the axis that say each."""

    name: str
    arguments: tuple[Argument, ...]
    is_struct: bool
    free: dict[str, tuple[str, int]]


def prototypes(text: str) -> dict[str, Prototype]:
    """The kernels that a text in C declares, by name."""
    structs = {name: fields for fields, name in STRUCT.findall(text)}
    declared_kernels = {}
    for entries, name, declared in PROTOTYPE.findall(text):
        record = FIELD.fullmatch(declared)
        is_struct = record is not None and record[2] in structs
        parts = _fields(structs[record[2]]) if record and is_struct else declared.split(",")
        ranges = dict(_entries(entries))
        arguments = tuple(_argument(part.strip(), ranges) for part in parts)
        sizes = {argument.name for argument in arguments}
        free: dict[str, tuple[str, int]] = {}
        for argument in arguments:
            for axis, size in enumerate(argument.shape or ()):
                if size.isidentifier() and size not in sizes:
                    free.setdefault(size, (argument.name, axis))
        declared_kernels[name] = Prototype(name, arguments, is_struct, free)
    return declared_kernels


def _fields(text: str) -> Iterator[str]:
    """The fields of a struct, each with its type."""
    for line in filter(str.strip, text.split(";")):
        kind, names = re.fullmatch(r"\s*((?:const )?\w+) (.*)", line).groups()  # type: ignore[union-attr]
        yield from (f"{kind} {name.strip()}" for name in names.split(","))


def _entries(text: str) -> Iterator[tuple[str, tuple[tuple[str, ...] | None, str | None, str | None]]]:
    """Shape and range of each argument that a comment names."""
    for entry in filter(None, (" ".join(part.split()) for part in text.replace("\n *", " ").split(";"))):
        match = ENTRY.fullmatch(entry)
        assert match, entry
        names, shape, low, limit = match.groups()
        sizes = None if shape is None else tuple(size.strip() for size in shape.split(","))
        yield from ((name.strip(), (sizes, low, limit)) for name in names.split(","))


def _argument(text: str, ranges: dict[str, tuple[tuple[str, ...] | None, str | None, str | None]]) -> Argument:
    match = FIELD.fullmatch(text)
    assert match, text
    constant, kind, pointer, name = match.groups()
    shape, low, limit = ranges.get(name, (None, None, None))
    assert (shape is not None) == bool(pointer), f"{name}: an array needs its shape in the comment, a number has none"
    return Argument(name, kind, bool(pointer) and not constant, shape, low, limit)


class Kernels:
    """The kernels of one library, as attributes; each function is made when it is first used."""

    def __init__(self, file: Path, text: str) -> None:
        self._library, self._prototypes = ctypes.CDLL(str(file)), prototypes(text)
        self._inside: Function = self._library.inside
        self._library.inside.argtypes = [ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]

    def __getattr__(self, name: str) -> Function:
        if name.startswith("_") or name not in self._prototypes:
            raise AttributeError(name)
        prototype, function = self._prototypes[name], getattr(self._library, name)
        kinds = [ctypes.c_void_p if of.shape else SCALARS[of.kind] for of in prototype.arguments]
        function.argtypes, function.restype = [ctypes.c_void_p] if prototype.is_struct else kinds, ctypes.c_int64
        checked = _made(prototype, function, self._inside if any(map(_is_index, prototype.arguments)) else None)
        setattr(self, name, checked)
        return checked

    @property
    def names(self) -> list[str]:
        """The names of all kernels."""
        return list(self._prototypes)

    def prototype(self, name: str) -> Prototype:
        """How the C text declares a kernel."""
        return self._prototypes[name]


def _is_index(argument: Argument) -> bool:
    """Whether an array has a range."""
    return argument.shape is not None and argument.limit is not None


def _made(prototype: Prototype, function: Any, inside: Function | None) -> Function:
    """The checked function of a kernel: what is right passes by a few comparisons, and `_checked` finds what is wrong."""
    arguments = prototype.arguments
    arrays = [argument for argument in arguments if argument.shape is not None]
    checks = [
        f"{of.low or 0} <= {of.name}{f' < {of.limit}' if of.limit else ''}"
        for of in arguments
        if of.kind == "int64_t" and not of.shape
    ]
    fits = {kind: "in" if len(dtypes) > 1 else "==" for kind, dtypes in DTYPES.items()}
    checks += [
        f"{of.name}.dtype {fits[of.kind]} {of.kind} and {of.name}.shape == ({', '.join(of.shape or ())},)" for of in arrays
    ]
    ranges = [f"inside({of.name}.size, at_{of.name}, {of.low or 0}, {of.limit})" for of in arrays if _is_index(of)]
    passed = ", ".join(f"at_{of.name}" if of.shape else of.name for of in arguments)
    names = ", ".join(of.name for of in arguments)
    lines = [
        f"def {prototype.name}({names}):",
        "    try:",
        *(f"        {size} = {array}.shape[{axis}]" for size, (array, axis) in prototype.free.items()),
        f"        if not ({' and '.join(checks)}): raise ValueError",
        *(f"        at_{of.name} = address(memory({of.name})) if {of.name}.size else 0" for of in arrays),
        f"        if not ({' and '.join(ranges) or True}): raise ValueError",
        "    except (AttributeError, ArithmeticError, IndexError, TypeError, ValueError):",
        f"        {passed}, = checked(prototype, ({names},), inside)",
        "    try:",
        f"        code = function({f'pack({passed})' if prototype.is_struct else passed})",
        "    except (Misfit, Unpacked) as error:",
        "        raise ValueError(f'{prototype.name}: {error}') from None",
        "    return code if code >= 0 else stopped(prototype.name, code)",
    ]
    letters = "".join("P" if of.shape else {"int64_t": "q", "double": "d"}.get(of.kind, "P") for of in arguments)
    scope = {
        **{kind: dtypes if len(dtypes) > 1 else dtypes[0] for kind, dtypes in DTYPES.items()}, "address": ctypes.addressof,
        "checked": _checked, "function": function, "inside": inside, "memory": _memory, "Misfit": ctypes.ArgumentError,
        "Unpacked": struct.error, "pack": struct.Struct(f"@{letters}").pack, "prototype": prototype, "stopped": _stopped,
    }  # fmt: skip
    exec("\n".join(lines), scope)
    checked: Function = scope[prototype.name]
    return checked


def _checked(prototype: Prototype, values: tuple[Any, ...], inside: Function | None) -> list[Any]:
    """Numbers and addresses of arrays that are right: also of those that are empty or may not be written. Raises ValueError."""

    def refuse(argument: Argument, why: str) -> NoReturn:
        raise ValueError(f"{prototype.name}: {argument.name} {why}")

    sizes: dict[str, Any] = {}
    for argument, value in zip(prototype.arguments, values, strict=True):
        if argument.shape is None:
            try:
                sizes[argument.name] = operator.index(value) if argument.kind == "int64_t" else value
            except TypeError:
                refuse(argument, f"is {value!r}: it takes a whole number")
        elif not isinstance(value, np.ndarray) or value.dtype not in DTYPES[argument.kind]:
            expected = " or ".join(str(dtype) for dtype in DTYPES[argument.kind])
            refuse(
                argument,
                f"is {f'of {value.dtype}' if isinstance(value, np.ndarray) else type(value)}: it takes an array of {expected}",
            )
        elif value.ndim != len(argument.shape):
            refuse(argument, f"has shape {value.shape}: it takes ({', '.join(argument.shape)})")
        sizes.update({size: value.shape[axis] for size, (array, axis) in prototype.free.items() if array == argument.name})
    passed = []
    for argument, value in zip(prototype.arguments, values, strict=True):
        low, limit = (int(eval(bound, {}, sizes)) if bound else None for bound in (argument.low, argument.limit))
        if argument.shape is None:
            passed.append(sizes[argument.name])
            if argument.kind == "int64_t" and not (low or 0) <= passed[-1] < (2**62 if limit is None else limit):
                refuse(argument, f"is {value}: it must be at least {low or 0}{f' and less than {limit}' if limit else ''}")
            continue
        shape = tuple(eval(size, {}, sizes) for size in argument.shape)
        if value.shape != shape:
            refuse(argument, f"has shape {value.shape}: it takes {shape} = ({', '.join(argument.shape)})")
        if not value.flags.c_contiguous:
            refuse(argument, f"has strides {value.strides}: it takes a C-contiguous array")
        if argument.is_written and not value.flags.writeable:
            refuse(argument, "may not be written")
        passed.append(int(value.ctypes.data))
        if inside and limit is not None and not inside(value.size, passed[-1], low or 0, limit):
            refuse(argument, f"has an index that is not from {low or 0} to {limit - 1}")
    return passed


def _stopped(name: str, code: int) -> NoReturn:
    """Raises what a kernel stopped for."""
    raise (
        MemoryError(f"{name}: no memory")
        if code == NO_MEMORY
        else ValueError(f"{name}: a number is not finite, or out of range")
    )


def library_file() -> Path | None:
    """Where the library lies that was built from these sources, or None."""
    files = (FOLDER / f"{NAME}{suffix}" for suffix in EXTENSION_SUFFIXES)
    return next((file for file in files if file.is_file() and _sources_of(file) == _digest()), None)


def _sources() -> list[Path]:
    return sorted([*FOLDER.glob("*.c"), *FOLDER.glob("*.h")], key=lambda file: file.name)


def _digest() -> int:
    """The digest of the sources, as build_backend.py has it."""
    return int(hashlib.sha256(b"".join(file.read_bytes() for file in _sources())).hexdigest()[:15], 16)


def _sources_of(file: Path) -> int | None:
    """The digest of the sources that a library was built from; None for one of another kind, or of another machine."""
    try:
        sources = ctypes.CDLL(str(file)).sources
    except (OSError, AttributeError):
        return None
    sources.restype = ctypes.c_int64
    return int(sources())


def _loaded() -> Kernels:
    if (file := library_file()) is None:
        raise ImportError(ABSENT, name=f"{__package__}.{NAME}")
    return Kernels(file, "\n".join(source.read_text(encoding="utf-8") for source in _sources()))


KERNELS = _loaded()
