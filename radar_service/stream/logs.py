"""Logs one line for each event on standard error, as text or as JSON. Secrets are never logged."""

import json
import logging
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Literal

Style = Literal["quiet", "text", "json"]
QUIET_SECONDS = 1.0  # between two lines about one kind of refusal, so that many refusals do not fill the log

_LOGGER = logging.getLogger("radar_service")


def log_event(event: str, level: int = logging.INFO, **fields: Any) -> None:
    """Logs an event with its fields."""
    _LOGGER.log(level, event, extra={"fields": fields})


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
    """One readable line: level, event, and the fields as name=value."""

    def format(self, record: logging.LogRecord) -> str:
        """Returns the line of a record of this service or of a library."""
        fields = " ".join(f"{key}={value}" for key, value in getattr(record, "fields", {}).items())
        return f"{record.levelname.lower()}: {super().format(record)}{' ' if fields else ''}{fields}"


def configure(style: Style) -> None:
    """Logs to standard error in this style from now on; quiet logs warnings and errors only, in words."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines() if style == "json" else Words())
    root = logging.getLogger()
    root.handlers[:] = [handler]
    _LOGGER.setLevel(logging.WARNING if style == "quiet" else logging.INFO)


class Refusals:
    """Counts refusals by their reason, and logs at most one line a second for each reason."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.counts: dict[str, int] = {}
        self._clock = clock
        self._logged: dict[str, tuple[float, int]] = {}

    def __call__(self, reason: str) -> None:
        count = self.counts[reason] = self.counts.get(reason, 0) + 1
        now, (last, before) = self._clock(), self._logged.get(reason, (-QUIET_SECONDS, 0))
        if now - last >= QUIET_SECONDS:
            self._logged[reason] = now, count
            log_event("refused", reason=reason, times=count - before)
