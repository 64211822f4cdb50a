"""The commands that a source of spokes has been given: another source of the same scene goes on from them."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from radar_service.scene.commands import MAX_COMMANDS, Command, CommandError, Steerable


class CommandLog:
    """All commands to a world in the order of their arrival. One thread writes; others may read."""

    def __init__(self, steerable: Steerable, commands: Iterable[Command] = ()) -> None:
        """steerable: what may be steered; commands: those of another source, which are known to be right."""
        self._steerable = steerable
        self._commands = list(commands)
        self._latest = {command.body: command for command in self._commands}

    def __len__(self) -> int:
        return len(self._commands)

    def __iter__(self) -> Iterator[Command]:
        return iter(self._commands)

    def add(self, spoke: int, body: str | None, values: Mapping[str, Any]) -> Command:
        """Adds a command and returns it. Raises CommandError."""
        if len(self._commands) >= MAX_COMMANDS:
            raise CommandError(f"a world takes {MAX_COMMANDS} commands, and has had as many; start the scene anew")
        command = self._steerable.command(spoke, body, values)
        self._commands.append(command)
        self._latest[body] = command
        return command

    def latest(self, body: str | None) -> Command | None:
        """Returns the command to a body that came last; None for own ship."""
        return self._latest.get(body)
