"""Presence that commands change while the radar runs."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np
from typing_extensions import override

from radar_service.numerics.types import Flags, Floats
from radar_service.world.presence import Presence

MAX_CHANGES = 1024  # remembered, of each body


class _Track:
    """What commands have made of a presence. current: what `at` follows; taken: with all commands."""

    def __init__(self, first: Presence) -> None:
        self.first = self.current = self.taken = first


@dataclass(frozen=True)
class SteeredPresence(Presence):
    """A presence under command. Its fields are those before the first command; `at` follows what `follow` has chosen last."""

    @classmethod
    def under(cls, presence: Presence) -> Self:
        """Returns a presence that begins as `presence`, and that no command has changed yet."""
        return cls(*(getattr(presence, each.name) for each in fields(Presence)))

    @property
    def constant(self) -> bool:
        """Whether it never changes: commands may change it."""
        return False

    def at(self, time: Floats) -> Flags:
        """Returns whether the body is present at each time (K,) [s]."""
        return self._track.current.at(time)

    def steer(self, time: float, present: bool) -> None:
        """Takes a change at `time` [s]. `at` follows it after `follow`."""
        changed = self._track.taken.changed(time, present)
        self._track.taken = replace(changed, time=changed.time[-MAX_CHANGES:], present=changed.present[-MAX_CHANGES:])

    def follow(self) -> None:
        """Lets `at` follow all changes that were taken."""
        self._track.current = self._track.taken

    def forget(self) -> None:
        """Forgets all changes. `at` goes on as before until `follow`."""
        self._track.taken = self._track.first

    def taken_at(self, time: Floats) -> Flags:
        """Returns whether the body is present at each time (K,) [s], with all changes that were taken."""
        return self._track.taken.at(time)

    @property
    def past(self) -> "PastPresence":
        """The same presence with all changes that were taken, for the truth; it remembers MAX_CHANGES."""
        return PastPresence(np.zeros(1), np.ones(1, dtype=np.bool_), steered=self)

    @cached_property
    def _track(self) -> _Track:
        return _Track(Presence(*(getattr(self, each.name) for each in fields(Presence))))


@dataclass(frozen=True, kw_only=True)
class PastPresence(Presence):
    """A presence under command, with all changes that were taken."""

    steered: SteeredPresence

    @property
    @override
    def constant(self) -> bool:
        """It never is: commands may change it."""
        return False

    def at(self, time: Floats) -> Flags:
        """Returns whether the body is present at each time (K,) [s]."""
        return self.steered.taken_at(time)
