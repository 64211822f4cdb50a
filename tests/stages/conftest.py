"""The fixture `installed`."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.stages.installed import Installed, forget


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Installed]:
    """Installs effects of other packages for a test."""
    yield Installed(tmp_path, monkeypatch)
    monkeypatch.undo()
    forget()
