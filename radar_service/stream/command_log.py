"""The commands that a source of spokes has been given: another source of the same scene goes on from them."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from radar_service.scene.commands import MAX_COMMANDS, Command, CommandError, Steerable


class CommandLog:
    """All commands to a world in the order of their arrival. One thread writes; others may read."""

    def __init__(self, steerable: Steerable, commands: Iterable[Command] = ()) -> None:
        """steerable: what may be steered; commands: those of another source, which are known to be right."""
        self._steerable = steerable
        self._commands = list(commands)
        self._latest = {self._name(command.body): command for command in self._commands}

    def __len__(self) -> int:
        return len(self._commands)

    def __iter__(self) -> Iterator[Command]:
        return iter(self._commands)

    def since(self, count: int) -> Sequence[Command]:
        """Returns the commands that came after the first `count`."""
        return self._commands[count:]

    def first_unknown(self, count: int) -> float:
        """Returns the first spoke that the commands after the first `count` change; inf where there are none."""
        return min((command.spoke for command in self._commands[count:]), default=math.inf)

    def acting_at(self, spoke: int) -> int:
        """Returns how many commands act at a spoke, where they came in the order of their spokes."""
        later = 0
        while later < len(self._commands) and self._commands[-1 - later].spoke > spoke:
            later += 1
        return len(self._commands) - later

    def made(self, spoke: int | None, body: str | None, values: Mapping[str, Any], time: float | None = None) -> Command:
        """Returns a command from a spoke on, or at a time [s], for `add`. Here it is checked, and nowhere later.

        Raises CommandError.
        """
        if len(self._commands) >= MAX_COMMANDS:
            raise CommandError(f"a world takes {MAX_COMMANDS} commands, and has had as many; start the scene anew")
        return self._steerable.command(spoke, body, values, time)

    def add(self, command: Command) -> None:
        """Adds a command that was made for this world."""
        self._commands.append(command)
        self._latest[self._name(command.body)] = command

    def latest(self, body: str | None) -> Command | None:
        """Returns the command to a body that came last; None for own ship."""
        return self._latest.get(self._name(body))

    def latest_after(self, count: int) -> list[Command]:
        """Returns the last command to each body, of those that came after the first `count`. With 0 it looks at no other ones."""
        latest = self._latest if count == 0 else {self._name(command.body): command for command in self._commands[count:]}
        return list(latest.values())

    def _name(self, body: str | None) -> str | None:
        return self._steerable.own_ship if body is None else body
