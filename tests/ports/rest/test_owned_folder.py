"""Temporary folders: those of living owners stay, those of dead ones go."""

import errno
import fcntl
import gc
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from radar_service.ports.rest.scene_store import OwnedFolder, SceneStore

PREFIX = "owned-"
OWNER = f"""
import sys
from radar_service.ports.rest.scene_store import OwnedFolder
folder = OwnedFolder({PREFIX!r})
(folder.path / "upload").write_text("some")
print(folder.path, flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for temporary ones of its own."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def test_what_a_killed_process_has_left_goes_at_the_next_start(temporary: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", OWNER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as owner:
        assert owner.stdout
        left = Path(owner.stdout.readline().strip())
        assert OwnedFolder(PREFIX).path != left and (left / "upload").is_file()  # its owner lives
        owner.kill()
        owner.wait()
        assert left.is_dir()
        folder = OwnedFolder(PREFIX)
        assert list(temporary.iterdir()) == [folder.path]


def test_the_store_of_scenes_removes_what_is_left(temporary: Path) -> None:
    (temporary / "radar-scenes-dead" / "upload").mkdir(parents=True)
    stores = [SceneStore([]) for _ in range(3)]
    assert {*temporary.iterdir()} == {store.home for store in stores}
    stores[1].close()
    assert {*temporary.iterdir()} == {stores[0].home, stores[2].home}


def test_folders_of_others_and_what_is_no_folder_stay(temporary: Path) -> None:
    target = temporary / "target"
    target.mkdir()
    (target / "kept").touch()
    (temporary / f"{PREFIX}link").symlink_to(target)
    (temporary / f"{PREFIX}file").touch()
    folder = OwnedFolder(PREFIX)
    assert (target / "kept").is_file() and len(list(temporary.iterdir())) == 4
    folder.close()
    folder.close()
    assert not folder.path.exists()


def test_a_folder_that_nobody_closes_goes_with_its_object(temporary: Path) -> None:
    folder = OwnedFolder(PREFIX)
    del folder
    gc.collect()
    assert not list(temporary.iterdir())


def test_a_folder_that_another_process_removes_before_it_is_locked_is_made_again(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, made = tempfile.mkdtemp, []

    def removed_once(**options: str) -> str:
        made.append(make(**options))
        if len(made) == 1:
            Path(made[0]).rmdir()
        return made[-1]

    monkeypatch.setattr(tempfile, "mkdtemp", removed_once)
    assert str(OwnedFolder(PREFIX).path) == made[1] and len(made) == 2


def test_a_system_without_locks_removes_nothing(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(fcntl, "flock", refuse)
    folders = [OwnedFolder(PREFIX), OwnedFolder(PREFIX)]
    assert {*temporary.iterdir()} == {folder.path for folder in folders}
