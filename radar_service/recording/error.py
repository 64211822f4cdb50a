"""The error of a recording."""


class RecordingError(ValueError):
    """A file that is no recording, or does not hold what is requested. The text names the file and says why."""
