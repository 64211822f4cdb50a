"""Which errors are in force at which spoke, where they change while the radar runs."""

from bisect import bisect_right
from collections.abc import Callable

from radar_service.scene.error_settings import ErrorSettings

MAX_CHANGES = 1000  # that are remembered: the errors of older spokes count as those of the oldest change


class ErrorTimeline:
    """Errors from each of some spokes on. May be read from any thread: the entries are immutable and replaced whole."""

    def __init__(self, errors: ErrorSettings | None = None) -> None:
        self._entries: tuple[tuple[int, ErrorSettings | None], ...] = ((0, errors),)

    @property
    def latest(self) -> ErrorSettings | None:
        """The errors of the spokes to come."""
        return self._entries[-1][1]

    @property
    def has_errors(self) -> bool:
        """Whether there are errors at some spoke."""
        return any(errors is not None for _, errors in self._entries)

    def set(self, errors: ErrorSettings | None, number: int) -> None:
        """Puts errors into force from the spoke of this number on, in place of all that was to be from there on."""
        kept = tuple(entry for entry in self._entries if entry[0] < number)
        if errors != (kept[-1][1] if kept else None) or not kept:
            kept = (*kept, (number if kept else 0, errors))
        self._entries = kept[-MAX_CHANGES:]

    def at(self, number: int) -> ErrorSettings | None:
        """Returns the errors in force at a spoke."""
        return self._entries[max(0, bisect_right(self._entries, number, key=lambda entry: entry[0]) - 1)][1]

    def since(self, number: int, part: Callable[[ErrorSettings | None], object]) -> int:
        """Returns the number of the spoke since which a part of the errors has been as it is at the spoke `number`."""
        begin = 0
        for first, errors in reversed(self._entries):
            if first <= number:
                if part(errors) != part(self.at(number)):
                    break
                begin = first
        return begin

    def changes(self, first: int, end: int) -> list[int]:
        """Returns the numbers above `first` and below `end` at which errors change."""
        return [number for number, _ in self._entries if first < number < end]
