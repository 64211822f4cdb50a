"""Recordings: MCAP files with the feed of radars, their scenes, their truth and pictures. `read` opens one in process.

The package `mcap` is an extra: where it is absent, the first use of `read` or `Recording` raises MissingExtra.
"""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.recording.error import RecordingError
    from radar_service.recording.recording import Recording, read

__all__ = ["Recording", "RecordingError", "read"]

__getattr__, __dir__ = lazily(__name__)
