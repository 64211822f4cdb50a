"""The error of a recording is a ValueError, and reading is what the package exports."""

import radar_service.recording as recording
from radar_service.recording.error import RecordingError


def test_the_error_is_a_value_error() -> None:
    assert issubclass(RecordingError, ValueError) and recording.RecordingError is RecordingError
    assert recording.read is recording.Recording
