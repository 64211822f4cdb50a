"""The error of a recording."""

from radar_service.terminal import UsageError


class RecordingError(UsageError, ValueError):
    """A file that is no recording, or does not hold what is requested. The text names the file and says why."""
