"""Recordings: MCAP files with the feed of radars, their scenes, their truth and pictures. `read` opens one in process.

Names are imported when they are first used: the package `mcap` is an extra, and the command line needs it for two commands.
"""

from typing import TYPE_CHECKING, Any

from radar_service.recording.error import RecordingError

if TYPE_CHECKING:
    from radar_service.recording.recording import Recording
    from radar_service.recording.recording import Recording as read

__all__ = ["Recording", "RecordingError", "read"]


def __getattr__(name: str) -> Any:
    """Returns a public name. Raises MissingExtra where the package is not installed."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from radar_service.recording.recording import Recording

    return Recording
