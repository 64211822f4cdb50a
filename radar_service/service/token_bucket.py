"""A token bucket: how many units may pass, on average and at once."""

from collections.abc import Callable


class TokenBucket:
    """Allows `rate` units a second on average, and `burst` at once. clock: seconds."""

    def __init__(self, rate: float, burst: float, clock: Callable[[], float]) -> None:
        self._rate, self._burst, self._clock = rate, burst, clock
        self._left, self._at = burst, clock()

    def take(self, units: float) -> bool:
        """Takes units out; returns False, and takes none, where there are too few."""
        now = self._clock()
        self._left = min(self._burst, self._left + self._rate * (now - self._at))
        self._at = now
        if units > self._left:
            return False
        self._left -= units
        return True
