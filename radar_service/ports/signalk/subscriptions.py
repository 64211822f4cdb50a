"""What a client of the Signal K stream has subscribed to, and when which path is due for it. No I/O.

Of a path that changes again before it was sent the newest value is sent, so that a client that does not read costs no memory.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

SELF = "vessels.self"
POLICIES = ("instant", "ideal", "fixed")
MAX_SUBSCRIPTIONS = 100  # of one client
MAX_PERIOD = 86_400.0  # s
PERIOD = 1000.0  # ms, of `fixed` and `ideal`, as Signal K has it
MIN_FIXED = 0.1  # s: own ship is not told more often either


class SubscriptionError(ValueError):
    """A subscription that cannot be. The text names the key, the value and what is allowed."""


@dataclass(frozen=True)
class Subscription:
    """Paths of a context with `*` for any part. period: the shortest time between two values of a path [s].

    repeats: whether values are sent again that have not changed.
    """

    context: str
    path: str
    period: float = 0.0
    repeats: bool = False

    @classmethod
    def of(cls, context: Any, row: Any) -> "Subscription":
        """Returns the subscription of a row of a `subscribe` message. Raises SubscriptionError."""
        if not isinstance(row, Mapping) or not isinstance(row.get("path"), str) or not isinstance(context, str):
            raise SubscriptionError('subscribe: each row is an object with a text under "path"; send {"path": "radars.*"}')
        policy = row.get("policy", "ideal" if "period" in row else "instant")
        if policy not in POLICIES:
            raise SubscriptionError(f"policy: {str(policy)[:20]!r} is not one of {', '.join(POLICIES)}; send one of them")
        key = "minPeriod" if policy == "instant" else "period"
        milliseconds = row.get(key, 0.0 if policy == "instant" else PERIOD)
        if isinstance(milliseconds, bool) or not isinstance(milliseconds, int | float):
            raise SubscriptionError(f"{key}: {str(milliseconds)[:20]!r} is not a number of milliseconds; send one")
        if not 0.0 <= milliseconds <= 1000.0 * MAX_PERIOD:
            raise SubscriptionError(
                f"{key}: {milliseconds:g} ms is not from 0 to {1000.0 * MAX_PERIOD:g}; send one of these"
            )
        path = row["path"][:200]
        if path.startswith(("vessels.", "atons.")):  # of other ships and aids: context and path in one
            context, path = ".".join(path.split(".", 2)[:2]), ".".join(path.split(".", 2)[2:]) or "*"
        context = SELF if context == "self" else context
        period = max(milliseconds / 1000.0, MIN_FIXED if policy == "fixed" else 0.0)
        return cls(context[:200], path, period, policy == "fixed")

    def takes(self, context: str, path: str) -> bool:
        """Returns whether a path of a context belongs to it."""
        return matches(self.context, context) and matches(self.path, path)


def matches(pattern: str, text: str) -> bool:
    """Returns whether a pattern, in which `*` stands for any characters, is that of a text.

    The first place of each part is the best one, so nothing is tried twice: a regular expression would go back for each `*`.
    """
    first, *middle = pattern.split("*")
    if not middle:
        return pattern == text
    last = middle.pop()
    at, end = len(first), len(text) - len(last)
    if at > end or not text.startswith(first) or not text.endswith(last):
        return False
    for part in middle:
        at = text.find(part, at, end)
        if at < 0:
            return False
        at += len(part)
    return True


Path = tuple[str, str]  # context, and path in it


class Subscriber:
    """The subscriptions of one client, and which paths are due for it. Times are those of one clock [s]."""

    def __init__(self, *subscriptions: Subscription) -> None:
        self._subscriptions = [*subscriptions]
        self._taking: dict[Path, Subscription | None] = {}  # which one sends a path, for paths that were looked up
        self._due: dict[Path, float] = {}
        self._sent: dict[Path, float] = {}

    def subscribe(self, subscriptions: Sequence[Subscription], known: Sequence[Path], now: float) -> None:
        """Adds subscriptions; what they take of the known paths is due. Raises SubscriptionError where they are too many."""
        added = [each for each in subscriptions if each not in self._subscriptions]
        if len(self._subscriptions) + len(added) > MAX_SUBSCRIPTIONS:
            raise SubscriptionError(f"subscribe: a client has at most {MAX_SUBSCRIPTIONS} subscriptions; unsubscribe some")
        self._subscriptions += added
        self._taking.clear()
        for path in known:
            if any(each.takes(*path) for each in subscriptions):
                self._due[path] = now

    def unsubscribe(self, context: str, path: str) -> None:
        """Removes the subscriptions that a pattern takes."""
        self._subscriptions = [
            each
            for each in self._subscriptions
            if not (matches(context, each.context) and (matches(path, each.path) or path == each.path))
        ]
        self._taking.clear()
        self._due = {each: due for each, due in self._due.items() if self._subscription(each)}

    def note(self, path: Path, now: float) -> None:
        """Notes that the value of a path is another one now."""
        subscription = self._subscription(path)
        if subscription:
            self._due.setdefault(path, max(now, self._sent.get(path, -MAX_PERIOD) + subscription.period))

    def take(self, now: float) -> list[Path]:
        """Returns the paths that are due, and counts them as sent."""
        due = [path for path, time in self._due.items() if time <= now]
        for path in due:
            del self._due[path]
            self._sent[path] = now
            subscription = self._subscription(path)
            if subscription and subscription.repeats:
                self._due[path] = now + subscription.period
        return due

    @property
    def next_due(self) -> float | None:
        """When the next path is due; None: none is."""
        return min(self._due.values(), default=None)

    def _subscription(self, path: Path) -> Subscription | None:
        """The subscription that sends a path, of several the one with the shortest period."""
        if path not in self._taking:
            taking = [each for each in self._subscriptions if each.takes(*path)]
            self._taking[path] = min(taking, key=lambda each: each.period, default=None)
        return self._taking[path]
