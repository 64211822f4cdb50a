"""The parser of the command line, and the list of its commands, each in the module of its name.

A module has `add_arguments`, and `run`, which returns the exit status. It is imported when its command is chosen.
"""

import argparse
from importlib import import_module
from typing import Protocol, cast

from radar_service import __version__

COMMANDS = {
    "serve": "run radars: feed, REST and page",
    "scan": "compute scans into a file",
    "record": "compute scans into a recording",
    "replay": "serve a recording: feed, REST and page",
    "check": "validate a scene and list what it contains",
    "plan": "show what is modelled of a scene, at what error and cost",
    "stability": "find where each method fails, and write a report",
    "chart": "measure speed and accuracy of every method on a scene",
    "bench-tracker": "test a tracker on scenarios, and write a report",
    "bench-ladder": "rank trackers by scenarios of growing difficulty",
    "plots": "extract plots, and tell by labels what each is of",
    "bench-detection": "compare detection by range with the radar equation",
    "sweep": "compute scenes, parameters and seeds into one Zarr store",
    "schema": "print the JSON Schema of a scene, or of a sweep",
}


class Command(Protocol):
    """What the module of a command has."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Adds its arguments to its part of the command line."""

    def run(self, options: argparse.Namespace) -> int:
        """Runs the command; returns the exit status. Raises UsageError, SceneError and OSError."""


def module_of(command: str) -> Command:
    """Returns the module of a command, by its name on the command line."""
    return cast(Command, import_module(f"radar_service.commands.{command.replace('-', '_')}"))


def parser(command: str | None = None) -> argparse.ArgumentParser:
    """Returns the parser of the command line, with the arguments of one command; None: of all."""
    top = argparse.ArgumentParser("radar-service", description="A simulated marine radar.")
    top.add_argument("--version", action="version", version=f"radar-service {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, text in COMMANDS.items():
        of_command = commands.add_parser(name, help=text)
        if command in (None, name):
            module_of(name).add_arguments(of_command)
    return top
