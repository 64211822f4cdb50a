"""A recording that tests share."""

from pathlib import Path

import pytest

from tests.recording.scenes import recorded


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scans of the small scene, with their truth."""
    return recorded(tmp_path_factory.mktemp("recording") / "three.mcap")
