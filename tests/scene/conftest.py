"""Shared by the tests of the scene stage."""

from pathlib import Path

import pytest


@pytest.fixture
def real_folder() -> Path:
    """Real meshes and maps, which stand beside the repository on some machines only."""
    folder = Path(__file__).resolve().parents[3] / "shared" / "real"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent: real meshes and maps are no part of the repository")
    return folder
