"""Shared by the tests of the scene stage."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.scene_file.scene_sources import EXAMPLE, TETRAHEDRON


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the example of docs/scenes.md and its files."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "ferry.obj").write_text(TETRAHEDRON)
    Image.fromarray(np.full((5, 5), 230, dtype=np.uint8)).save(home / "catalina.png")
    (home / "scene.toml").write_text(EXAMPLE)
    return home


@pytest.fixture
def real_folder() -> Path:
    """Real meshes and maps, which stand beside the repository on some machines only."""
    path = Path(__file__).resolve().parents[3] / "shared" / "real"
    if not path.is_dir():
        pytest.skip(f"{path} is absent: real meshes and maps are no part of the repository")
    return path
