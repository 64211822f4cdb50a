"""Trackers by name: an entry point, a callable in Python, a program, or a server. And what stands behind a name."""

import hashlib
import importlib.metadata
import importlib.util
import os
import shlex
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from radar_service import plug_ins
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.process_tracker import CallableTracker, ProcessTracker
from radar_service.bench.trackers.tracker import DataSheet, Tracker
from radar_service.bench.trackers.websocket_tracker import SCHEMES, WebsocketTracker


def tracker_for(name: str, header: Mapping[str, Any], sealed: Sequence[str] | None = None) -> Tracker:
    """Returns a new tracker by name: of an entry point, as "gnn"; "ws://..." or "wss://..."; "module:callable"; or a command.

    header: what it gets first, with `radar`, the data sheet. sealed: folders that a program cannot read; None for an open run.
    Raises TrackerError, PlugInError, and MissingExtra.
    """
    if is_built_in(name):
        return cast(Tracker, plug_ins.load("trackers", name)(DataSheet(**header["radar"])))
    if name.startswith(SCHEMES):
        return WebsocketTracker(name, header)
    if name in plug_ins.names("trackers"):
        entry = plug_ins.entry("trackers", name)
        try:
            return CallableTracker.ready(entry.value, header, sealed, program_digest(name))
        except TrackerError as error:
            raise type(error)(str(plug_ins.broken(entry, error))) from None
    return (CallableTracker if _is_callable(name) else ProcessTracker).ready(name, header, sealed, program_digest(name))


def program_digest(name: str) -> str:
    """Returns a hash of the files that a command names, of a Python module, or of the version of Stone Soup; not of what these
    import, and "" of a server. Raises OSError and PlugInError."""
    if is_built_in(name):
        return _installed("stonesoup")
    if name.startswith(SCHEMES):
        return ""
    if name in plug_ins.names("trackers"):
        name = plug_ins.entry("trackers", name).value
    files = [_file_of(name.partition(":")[0])] if _is_callable(name) else _files(name)
    return hashlib.blake2b(
        b"".join(hashlib.blake2b(file.read_bytes()).digest() for file in files if file), digest_size=8
    ).hexdigest()


def is_built_in(name: str) -> bool:
    """Whether it is the name of a tracker of this package, a function of the data sheet, which runs in this process."""
    return name in plug_ins.names("trackers") and plug_ins.is_own(plug_ins.entry("trackers", name))


def is_program(name: str) -> bool:
    """Whether it is a command or a server, and no tracker in Python, which takes plots."""
    return not (name in plug_ins.names("trackers") or _is_callable(name))


def _is_callable(name: str) -> bool:
    return name.count(":") == 1 and " " not in name and "/" not in name


def _installed(package: str) -> str:
    try:
        return f"{package} {importlib.metadata.version(package)}"
    except importlib.metadata.PackageNotFoundError:
        return ""


def _file_of(module: str) -> Path | None:
    """The file of a module; None where there is none, which `tracker_for` then says."""
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())  # modules are found there, as `python -m` finds them
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError, AttributeError):
        return None
    return Path(spec.origin) if spec and spec.origin and Path(spec.origin).is_file() else None


def _files(command: str) -> list[Path]:
    """The files that a command names: its program, scripts, settings."""
    try:
        program, *rest = shlex.split(command)
    except ValueError:
        return []
    its_file = shutil.which(program)
    named = [Path(word.partition("=")[2] or word) for word in rest]  # --settings=file names a file too
    return [*([Path(its_file)] if its_file else []), *(path for path in named if os.path.isfile(path))]
