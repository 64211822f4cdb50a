"""Entry points, ours and those of others: ports, readers, effects, scattering, commands, trackers.

A part is a line of a `pyproject.toml`, below `[project.entry-points."radar_service.GROUP"]`. It is imported where it is needed.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from typing import Any

from radar_service.terminal import UsageError


class PlugInError(UsageError):
    """A part that cannot be used. The text names its package and the remedy."""


@cache
def groups() -> Mapping[str, Mapping[str, Sequence[metadata.EntryPoint]]]:
    """Returns the entry points of each group by name, sorted: more than one where packages claim the same name.

    Raises PlugInError where the installation is older than its source.
    """
    result: dict[str, dict[str, dict[str, metadata.EntryPoint]]] = {}
    for package in metadata.distributions():
        for each in package.entry_points if "[radar_service." in (package.read_text("entry_points.txt") or "") else ():
            result.setdefault(each.group, {}).setdefault(each.name, {}).setdefault(each.value, each)
    if "radar_service.rasters" not in result:  # the latest group
        raise PlugInError("radar-service: this installation is older than its source; install it again: pip install -e .")
    return {group: {name: [*parts[name].values()] for name in sorted(parts)} for group, parts in result.items()}


def names(group: str) -> list[str]:
    """Returns the names of the parts of a group, sorted. Raises PlugInError where the installation is older than its source."""
    return list(groups().get(f"radar_service.{group}", ()))


def entries(group: str) -> list[metadata.EntryPoint]:
    """Returns all entry points of a group, by name."""
    return [each for parts in groups().get(f"radar_service.{group}", {}).values() for each in parts]


def entry(group: str, name: str) -> metadata.EntryPoint:
    """Returns an entry point by one of the names. Raises PlugInError where two packages claim it."""
    first, *others = groups()[f"radar_service.{group}"][name]
    if others:
        packages = " and ".join(map(package_of, (first, *others)))
        raise PlugInError(f"radar_service.{group}: the packages {packages} both have {name}; uninstall one of them")
    return first


@cache
def part_or_error(group: str, name: str) -> Any:
    """Returns a part, or the PlugInError that says why there is none: in a sandbox a second import would fail otherwise."""
    try:
        return entry(group, name).load()
    except PlugInError as error:
        return error
    except (Exception, SystemExit) as error:  # a stranger's module raises anything
        is_deleted = isinstance(error, ModuleNotFoundError) and (error.name or "").startswith("radar_service.")
        if is_own(entry(group, name)) and not is_deleted:
            raise
        return broken(entry(group, name), error)


def load(group: str, name: str) -> Any:
    """Returns the part of one of the names. Raises PlugInError, and what our own modules raise."""
    part = part_or_error(group, name)
    if isinstance(part, PlugInError):
        raise part
    return part


@cache
def working(group: str) -> Mapping[str, Any]:
    """Returns the parts of a group by name; standard error tells of each that cannot be used, once."""
    parts = {name: part_or_error(group, name) for name in names(group)}
    for part in parts.values():
        if isinstance(part, PlugInError):
            print(part, file=sys.stderr)
    return {name: part for name, part in parts.items() if not isinstance(part, PlugInError)}


def broken(entry: metadata.EntryPoint, error: BaseException) -> PlugInError:
    """Returns the error for a part that has raised `error`."""
    text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
    package = package_of(entry)
    return PlugInError(f"{entry.name} of {entry.group}: the package {package} is broken ({text}); update or uninstall it")


@contextmanager
def guarded(entry: metadata.EntryPoint | None, *expected: type[Exception]) -> Iterator[None]:
    """Raises PlugInError for what a stranger's part raises in the `with` block, unless it is `expected`. None: a part of ours."""
    try:
        yield
    except Exception as error:
        if entry is None or is_own(entry) or isinstance(error, (PlugInError, *expected)):
            raise
        raise broken(entry, error) from error


def is_own(entry: metadata.EntryPoint) -> bool:
    """Whether an entry point is of this package. No file is read for that, as in a sandbox none may be."""
    return entry.module.startswith("radar_service.")


def package_of(entry: metadata.EntryPoint) -> str:
    """Returns the name and version of the package of an entry point."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.module
