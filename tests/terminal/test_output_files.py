"""Files that commands write: folders are made, and nothing is overwritten unasked."""

from pathlib import Path

import pytest

from radar_service.__main__ import main
from radar_service.terminal.output_files import make_folder, prepare
from tests.scenes import ONE_TARGET


@pytest.fixture
def scene(tmp_path: Path) -> str:
    import json

    path = tmp_path / "one.json"
    path.write_text(json.dumps(ONE_TARGET))
    return str(path)


def test_folders_are_made_and_files_are_kept(tmp_path: Path) -> None:
    old, new = tmp_path / "old.png", tmp_path / "a" / "b" / "new.png"
    old.write_text("mine")
    with pytest.raises(FileExistsError, match="it exists already; give --overwrite, or another name"):
        prepare((new, None, old), overwrite=False)
    assert not new.parent.exists()
    prepare((new, None, old), overwrite=True)
    assert new.parent.is_dir() and old.read_text() == "mine"


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="a file is in the way of this folder; name another") as caught:
        make_folder(tmp_path / "file")
    assert caught.value.filename == str(tmp_path / "file")


@pytest.mark.parametrize(
    ("command", "option", "name"),
    [
        ("scan", "-o", "a.npz"), ("scan", "--png", "a.png"), ("scan", "--truth", "a.jsonl"), ("record", "-o", "a.mcap"),
        ("plots", "-o", "a.json"), ("plots", "--png", "a.png"), ("serve", "--record", "a.mcap"),
    ],
)  # fmt: skip
def test_no_command_overwrites_unasked(
    command: str, option: str, name: str, scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if name.endswith(".mcap"):
        pytest.importorskip("mcap", reason="the extra `record` is absent")
    (tmp_path / name).write_text("mine")
    needed = ["-o", str(tmp_path / "other.npz")] if command == "scan" and option != "-o" else []
    assert main([command, scene, option, str(tmp_path / name), *needed]) == 2
    assert capsys.readouterr().err == f"{tmp_path / name}: it exists already; give --overwrite, or another name\n"
    assert (tmp_path / name).read_text() == "mine" and not (tmp_path / "other.npz").exists()


def test_a_command_overwrites_where_it_may_and_makes_folders(scene: str, tmp_path: Path) -> None:
    out = tmp_path / "a" / "b" / "scan.npz"
    assert main(["scan", scene, "-o", str(out)]) == 0
    first = out.stat().st_mtime_ns
    assert main(["scan", scene, "-o", str(out), "--overwrite"]) == 0 and out.stat().st_mtime_ns > first
