"""The changes of state that a port has not been told yet: of each radar and kind one, however many there were."""

import threading
from collections.abc import Callable

from radar_service.stream.ports.port_thread import PortThread
from radar_service.stream.ports.state_changes import Kind, StateChange


class ToldChanges:
    """Tells a port of changes, by its thread. None is lost: those that wait become one change of their kind."""

    def __init__(self, changed: Callable[[StateChange], None], thread: PortThread) -> None:
        """changed: takes a change."""
        self._changed, self._thread = changed, thread
        self._waiting: dict[tuple[str, Kind], StateChange] = {}
        self._lock = threading.Lock()

    def put(self, change: StateChange) -> None:
        """Notes a change that is to be told."""
        key = change.radar, change.kind
        with self._lock:
            earlier = self._waiting.pop(key, None)
            self._waiting[key] = change if earlier is None else change.after(earlier)
        self._thread.put(self._tell, key=self)

    def _tell(self) -> None:
        while change := self._taken():
            self._changed(change)

    def _taken(self) -> StateChange | None:
        with self._lock:
            return self._waiting.pop(next(iter(self._waiting))) if self._waiting else None
