"""The one cache of the engine: results that many azimuths share, for any thread; and what makes them out of date."""

from collections.abc import Callable, Hashable
from threading import Lock
from typing import Any, Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class Revision:
    """The number of a state on which kept results depend besides their keys: the motions under command.

    Whoever changes the state says so by `change`; who keeps results compares the number.
    """

    def __init__(self) -> None:
        self.number = 0

    def change(self) -> None:
        """Notes that the state has changed. Nothing that depends on it may be computed meanwhile."""
        self.number += 1


STEADY = Revision()  # of what never changes


class ResultCache(Generic[Key, Value]):
    """Keeps the `size` results used last, by key.

    Rule: a result depends on its key and the revision alone, so it does not matter which thread computes it, nor when. Results
    are computed one at a time, whatever their keys, and other threads wait; `compute` must not use the same cache. Pickling
    leaves the results out: the other process computes its own.
    """

    def __init__(self, size: int, revision: Revision = STEADY) -> None:
        """size: results kept, 1 or more; revision: another number of it ends all of them."""
        self.size, self._revision, self._number = size, revision, revision.number
        self._results: dict[Key, Value] = {}  # the one used last is at the end
        self._lock = Lock()

    def get(self, key: Key, compute: Callable[[], Value]) -> Value:
        """The result for `key`, from compute() where it is not kept."""
        with self._lock:
            if self._number != self._revision.number:
                self._results.clear()
                self._number = self._revision.number
            result = self._results.pop(key) if key in self._results else compute()
            self._results[key] = result
            while len(self._results) > self.size:
                del self._results[next(iter(self._results))]
            return result

    def grow(self, size: int) -> None:
        """Keeps at least `size` results from now on."""
        with self._lock:
            self.size = max(self.size, size)

    def __len__(self) -> int:
        return len(self._results)

    def __getstate__(self) -> dict[str, Any]:
        return {"size": self.size, "revision": self._revision}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]
