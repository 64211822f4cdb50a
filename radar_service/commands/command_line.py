"""The parser of the command line. Its commands are the entry points `radar_service.commands`, each a module.

A module has `add_arguments`, and `run`, which returns the exit status. It is imported when its command is chosen. What its
docstring says after a colon, "The command `fly`: flies.", is its line in the list of commands.
"""

import argparse
import re
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol, cast

from radar_service import __version__, plug_ins


class CommandModule(Protocol):
    """What the module of a command has."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Adds its arguments to its part of the command line."""

    def run(self, options: argparse.Namespace) -> int:
        """Runs the command; returns the exit status. Raises UsageError, SceneError and OSError."""


def module_of(command: str) -> CommandModule:
    """Returns the module of a command, by its name on the command line. Raises PlugInError."""
    return cast(CommandModule, plug_ins.load("commands", command))


def parser(command: str | None = None) -> argparse.ArgumentParser:
    """Returns the parser of the command line, with the arguments of one command; None: of all. Raises PlugInError."""
    top = argparse.ArgumentParser("radar-service", description="A simulated marine radar.")
    top.add_argument("--version", action="version", version=f"radar-service {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in plug_ins.names("commands"):
        of_command = commands.add_parser(name, help=_summary(name))
        if command in (None, name):
            with plug_ins.guarded(plug_ins.entry("commands", name)):
                module_of(name).add_arguments(of_command)
    return top


def _summary(command: str) -> str:
    """The first line of the docstring of a command's module, from its colon on, without an import of the module; "" for none."""
    try:
        spec = find_spec(plug_ins.entry("commands", command).module)
        text = Path(spec.origin).read_text(encoding="utf-8") if spec and spec.origin else ""
    except Exception:  # of a package that is broken; whoever chooses the command is told
        return ""
    line = re.match(r'"""[^:\n]*: ([^\n]*?)\.?("""|\n)', text)
    return line[1].replace("%", "%%") if line else ""
