"""What is worked out once for a stretch of time and used by many azimuths, from any thread."""

from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

T = TypeVar("T")

HELD = 4  # threads may be this many stretches apart before one is worked out again


class BlockCache(Generic[T]):
    """The results of a function of a whole number, the latest few of them."""

    def __init__(self, function: Callable[[int], T]) -> None:
        self._function, self._lock = function, Lock()
        self._results: dict[int, T] = {}

    def __call__(self, number: int) -> T:
        """The result for `number`; it depends on the number alone."""
        with self._lock:
            if number not in self._results:
                while len(self._results) >= HELD:
                    del self._results[next(iter(self._results))]
                self._results[number] = self._function(number)
            return self._results[number]
