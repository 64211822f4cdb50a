"""What happens, a line each, on standard error: words for people, or JSON for machines. Secrets are never passed here."""

import json
import logging
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Literal

Style = Literal["quiet", "text", "json"]
QUIET_SECONDS = 1.0  # between two lines about the same kind of refusal: a flood of them must not become a flood of lines

_LOGGER = logging.getLogger("radar_service")


def note(event: str, level: int = logging.INFO, **fields: Any) -> None:
    """Say that something happened."""
    _LOGGER.log(level, event, extra={"fields": fields})


class JsonLines(logging.Formatter):
    """A JSON object a line: time (UTC), level, event, and the fields of the event."""

    def format(self, record: logging.LogRecord) -> str:
        """The line of a record, ours or a library's."""
        at = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        line = {"time": at, "level": record.levelname.lower(), "event": record.getMessage()}
        if record.exc_info:
            line["fault"] = self.formatException(record.exc_info)
        return json.dumps(line | getattr(record, "fields", {}), default=str)


class Words(logging.Formatter):
    """A readable line: level, event, and the fields as name=value."""

    def format(self, record: logging.LogRecord) -> str:
        """The line of a record, ours or a library's."""
        fields = " ".join(f"{key}={value}" for key, value in getattr(record, "fields", {}).items())
        return f"{record.levelname.lower()}: {super().format(record)}{' ' if fields else ''}{fields}"


def write(style: Style) -> None:
    """From here on write to standard error in this style; quiet: warnings alone, in words."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines() if style == "json" else Words())
    root = logging.getLogger()
    root.handlers[:] = [handler]
    _LOGGER.setLevel(logging.WARNING if style == "quiet" else logging.INFO)


class Refusals:
    """Counts what was refused by its reason, and notes it, at most a line a second for each reason."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.counts: dict[str, int] = {}
        self._clock = clock
        self._noted: dict[str, tuple[float, int]] = {}

    def __call__(self, reason: str) -> None:
        count = self.counts[reason] = self.counts.get(reason, 0) + 1
        now, (last, before) = self._clock(), self._noted.get(reason, (-QUIET_SECONDS, 0))
        if now - last >= QUIET_SECONDS:
            self._noted[reason] = now, count
            note("refused", reason=reason, times=count - before)
