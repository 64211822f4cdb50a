"""Logs one line for each event on standard error, as text or as JSON. Secrets are never logged.

Logging never waits: lines go through a bounded queue to a thread that writes them. Where nobody reads them, or where one kind
comes too often, lines are dropped and counted.
"""

import json
import logging
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from logging.handlers import QueueHandler, QueueListener
from os import write
from queue import Full, Queue
from typing import Any, Literal

from radar_service.service.token_bucket import TokenBucket

Style = Literal["quiet", "text", "json"]
QUIET_SECONDS = 1.0  # between two lines about one kind of refusal, so that many refusals do not fill the log
STANDARD_ERROR = 2  # file descriptor
MAX_LINES = 1000  # that wait for the thread
MAX_LINE = 8192  # characters; some lines repeat what a client has sent
FLUSH_SECONDS = 0.5  # that the end of the process waits for the thread
KINDS = {"radar_service": (20.0, 200.0)}  # lines of one kind a second and at once, by the logger's name
OTHERS = (1.0, 5.0)  # of libraries, whose warnings strangers can cause
MAX_KINDS = 1000

_LOGGER = logging.getLogger("radar_service")


def log_event(event: str, level: int = logging.INFO, **fields: Any) -> None:
    """Logs an event with its fields."""
    _LOGGER.log(level, event, extra={"fields": fields})


def printable(text: str) -> str:
    """Returns a text with its control characters escaped: line breaks and escape sequences would forge lines."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode() for c in text)


class JsonLines(logging.Formatter):
    """One JSON object a line: time (UTC), level, event, and the fields of the event."""

    def format(self, record: logging.LogRecord) -> str:
        """Returns the line of a record of this service or of a library."""
        at = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        line = {"time": at, "level": record.levelname.lower(), "event": record.getMessage()}
        if record.exc_info:
            line["fault"] = self.formatException(record.exc_info)
        return json.dumps(line | getattr(record, "fields", {}), default=str)


class Words(logging.Formatter):
    """One readable line: level, event, and the fields as name=value. The lines of a fault follow, indented."""

    def format(self, record: logging.LogRecord) -> str:
        """Returns the line of a record of this service or of a library."""
        fields = "".join(f" {key}={value}" for key, value in getattr(record, "fields", {}).items())
        line = printable(f"{record.levelname.lower()}: {record.getMessage()}{fields}")
        if not record.exc_info:
            return line
        return "\n    ".join((line, *map(printable, self.formatException(record.exc_info).split("\n"))))


class LineWriter(QueueListener):
    """Writes the messages of records as lines to a file descriptor, in a thread.

    No handler or stream does it: where nobody reads, the end of the process would wait for its lock.
    """

    def __init__(self, queue: Queue[logging.LogRecord], file: int) -> None:
        super().__init__(queue)
        self._file = file

    def handle(self, record: logging.LogRecord) -> None:
        """Waits until the line is written."""
        line = f"{record.msg}\n".encode(errors="backslashreplace")
        with suppress(OSError):  # nobody will ever read
            while line:
                line = line[write(self._file, line) :]


class LineQueue(QueueHandler):
    """Formats records, and has their lines written to a file descriptor in a thread.

    dropped: lines that were not written, by the reason: `queue` where nobody reads them, `repeated` where one kind came
    too often.
    """

    def __init__(self, file: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._lines: Queue[logging.LogRecord] = Queue(MAX_LINES)
        super().__init__(self._lines)
        self.dropped: Counter[str] = Counter()
        self._clock = clock
        self._kinds: dict[tuple[str, str], TokenBucket] = {}
        self.listener = LineWriter(self._lines, file)
        self.listener.start()

    def emit(self, record: logging.LogRecord) -> None:
        """Queues the line of a record, or drops it."""
        if self._is_allowed(record):
            super().emit(record)
        else:
            self.dropped["repeated"] += 1

    def prepare(self, record: logging.LogRecord) -> logging.LogRecord:
        """Returns a log record whose message is the formatted line, cut to MAX_LINE."""
        return logging.makeLogRecord({"msg": self.format(record)[:MAX_LINE]})

    def enqueue(self, record: logging.LogRecord) -> None:
        """Queues a line, or drops it where the queue is full."""
        try:
            self._lines.put_nowait(record)
        except Full:
            self.dropped["queue"] += 1

    def flush(self) -> None:
        """Waits until all lines are written, at most FLUSH_SECONDS."""
        with self._lines.all_tasks_done:
            self._lines.all_tasks_done.wait_for(lambda: not self._lines.unfinished_tasks, FLUSH_SECONDS)

    def close(self) -> None:
        """Ends the thread, once it has written what waits; where the queue is full, it goes on for as long as the process."""
        with suppress(Full):
            self.listener.enqueue_sentinel()
        super().close()

    def _is_allowed(self, record: logging.LogRecord) -> bool:
        kind = record.name, str(record.msg)
        if kind not in self._kinds:
            while len(self._kinds) >= MAX_KINDS:
                del self._kinds[next(iter(self._kinds))]
            self._kinds[kind] = TokenBucket(*KINDS.get(record.name, OTHERS), self._clock)
        return self._kinds[kind].take(1)


def configure(style: Style) -> LineQueue:
    """Logs to standard error in this style from now on; quiet logs warnings and errors only, in words."""
    handler = LineQueue(STANDARD_ERROR)
    handler.setFormatter(JsonLines() if style == "json" else Words())
    root = logging.getLogger()
    root.handlers[:] = [handler]
    _LOGGER.setLevel(logging.WARNING if style == "quiet" else logging.INFO)
    return handler


def dropped() -> Counter[str]:
    """Returns how many lines were dropped since the start, by the reason."""
    queues = [handler for handler in logging.getLogger().handlers if isinstance(handler, LineQueue)]
    counts = Counter({"queue": 0, "repeated": 0})
    for queue in queues:
        counts.update(queue.dropped)  # a sum of counters would leave out what is 0
    return counts


class Refusals:
    """Counts refusals by their reason, and logs at most one line a second for each reason."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.counts: dict[str, int] = {}
        self._clock = clock
        self._logged: dict[str, tuple[float, int]] = {}

    def __call__(self, reason: str, times: int = 1) -> None:
        count = self.counts[reason] = self.counts.get(reason, 0) + times
        now, (last, before) = self._clock(), self._logged.get(reason, (-QUIET_SECONDS, 0))
        if now - last >= QUIET_SECONDS:
            self._logged[reason] = now, count
            log_event("refused", reason=reason, times=count - before)
