"""When bodies are in the scene: changes at given times or by commands while the radar runs, and fading that repeats."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import ClassVar, Protocol, Self

import numpy as np
from typing_extensions import override

from radar_service.numerics import Flags, Floats, Indices

ROUNDING = 1e-9  # s: a spoke counts as at an instant that it misses by rounding; spokes are some 1e-4 s apart
MAX_CHANGES = 1024  # remembered, of each body


@dataclass(frozen=True)
class Fading:
    """A schedule that repeats for ever, before `start` too.

    pattern: (P,) whether the body is present in each unit of the schedule.
    unit: length of a unit [s].
    start: of the first unit [s].
    """

    pattern: Flags
    unit: float
    start: float = 0.0

    def __post_init__(self) -> None:
        assert self.pattern.ndim == 1 and self.pattern.size > 0 and self.unit > 0.0

    def at(self, time: Floats) -> Flags:
        """Returns whether the body is present at each time (K,) [s]."""
        unit = np.floor((time - self.start + ROUNDING) / self.unit).astype(np.int64)
        return np.asarray(self.pattern[unit % len(self.pattern)])


@dataclass(frozen=True)
class Presence:
    """When a body is present: from time[n] on as present[n] says, before time[0] as present[0], and only if `fading` agrees.

    An absent body neither echoes nor occludes.

    time: (N,) of the changes [s], rising, at least one.
    present: (N,) from each of them on.
    fading: a schedule besides, or None.
    """

    time: Floats
    present: Flags
    fading: Fading | None = None
    always: ClassVar["Presence"]

    def __post_init__(self) -> None:
        assert self.time.ndim == 1 and self.time.size > 0 and self.time.shape == self.present.shape

    @property
    def text(self) -> str:
        """What `check` says of it, with a comma before each item."""
        changes = zip(self.time[1:], self.present[1:], strict=True)
        text = "".join(f", {'appears' if present else 'goes'} after {time:g} s" for time, present in changes)
        if self.fading is None:
            return text
        pattern = self.fading.pattern
        return f"{text}, there in {np.count_nonzero(pattern)} of {len(pattern)} times {self.fading.unit:g} s"

    @property
    def constant(self) -> bool:
        """Whether it never changes."""
        fades = self.fading is not None and bool(self.fading.pattern.any() and not self.fading.pattern.all())
        return not fades and bool((self.present == self.present[0]).all())

    def at(self, time: Floats) -> Flags:
        """Returns whether the body is present at each time (K,) [s]."""
        latest = np.searchsorted(self.time, time + ROUNDING, side="right") - 1
        present = self.present[np.maximum(latest, 0)]
        return np.asarray(present if self.fading is None else present & self.fading.at(time))

    def changed(self, time: float, present: bool) -> "Presence":
        """Returns the same until `time` [s], and `present` from then on; fading goes on."""
        kept = self.time < time
        before = self.present[kept] if kept.any() else self.present[:1]
        since = self.time[kept] if kept.any() else np.array([time - 1.0])
        return replace(self, time=np.append(since, time), present=np.append(before, present))


Presence.always = Presence(np.zeros(1), np.ones(1, dtype=np.bool_))


class HasPresence(Protocol):
    """Anything that may come and go."""

    @property
    def presence(self) -> Presence: ...


class Presences:
    """The presence of bodies (B,). changing: (C,) indices of those whose presence changes."""

    def __init__(self, bodies: Sequence[HasPresence]) -> None:
        self._each = [body.presence for body in bodies]
        self.changing: Indices = np.array(
            [b for b, presence in enumerate(self._each) if not presence.constant], dtype=np.int64
        )
        self._present_first = np.array([bool(presence.at(np.zeros(1))[0]) for presence in self._each], dtype=np.bool_)

    def at(self, time: float) -> Flags:
        """Returns which bodies (B,) are present at `time` [s]."""
        if not len(self.changing):
            return self._present_first
        present = self._present_first.copy()
        for b in self.changing.tolist():
            present[b] = self._each[b].at(np.array([time]))[0]
        return present

    def state(self, time: float) -> bytes:
        """Returns a key of which bodies are present at `time` [s]; the same for all times where no presence changes."""
        return self.at(time)[self.changing].tobytes() if len(self.changing) else b""

    def spans(self, time: Floats) -> Iterator[tuple[int, int]]:
        """First and end of the runs of times (K,) [s] over which no presence changes."""
        states = np.array([self._each[b].at(time) for b in self.changing.tolist()], dtype=np.bool_)
        edges = np.flatnonzero((states[:, 1:] != states[:, :-1]).any(axis=0)) + 1 if len(states) else np.zeros(0, np.int64)
        yield from zip([0, *edges.tolist()], [*edges.tolist(), len(time)], strict=True)


class _PresenceTrack:
    """What commands have made of a presence. current: what `at` follows; taken: with all commands."""

    def __init__(self, first: Presence) -> None:
        self.first = self.current = self.taken = first


@dataclass(frozen=True)
class SteeredPresence(Presence):
    """A presence under command. Its fields are those before the first command; `at` follows what `follow` has chosen last."""

    @classmethod
    def under(cls, presence: Presence) -> Self:
        """Returns a presence that begins as `presence`, and that no command has changed yet."""
        return cls(*(getattr(presence, field.name) for field in fields(Presence)))

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
    def _track(self) -> _PresenceTrack:
        return _PresenceTrack(Presence(*(getattr(self, field.name) for field in fields(Presence))))


@dataclass(frozen=True, kw_only=True)
class PastPresence(Presence):
    """A presence under command, with all changes that were taken."""

    steered: SteeredPresence

    @property
    @override
    def constant(self) -> bool:
        """Always False: commands may change the presence."""
        return False

    def at(self, time: Floats) -> Flags:
        """Returns whether the body is present at each time (K,) [s]."""
        return self.steered.taken_at(time)
