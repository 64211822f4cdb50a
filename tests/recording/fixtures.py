"""A recording that tests share."""

from pathlib import Path

import pytest

from radar_service.records.cell_sources import SourceRequest
from tests.recording.scenes import recorded


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scans of the small scene, with their truth."""
    return recorded(tmp_path_factory.mktemp("recording") / "three.mcap")


@pytest.fixture(scope="session")
def documented_recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scans of the small scene as the specification computes them, without truth; powers are recorded beside fields."""
    return recorded(tmp_path_factory.mktemp("recording") / "documented.mcap", fidelity="documented", with_truth=False)


@pytest.fixture(scope="session")
def labelled_recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scans of the small scene, with labels and the power of both ships."""
    told = SourceRequest(True, (256, 257))
    return recorded(tmp_path_factory.mktemp("recording") / "labelled.mcap", with_truth=False, told=told)
