"""The command line refuses wrong usage before it connects."""

from pathlib import Path

import pytest

from clients.ppi.__main__ import main


@pytest.mark.parametrize(
    "wrong",
    [["--scans", "0"], ["--size", "20"], ["--encoding", "u9"], ["--range", "-1"], ["--range", "nan"], ["--range", "inf"],
     ["--bins", "x"],
     ["--out", "/dev/null/a.png"], ["--npz", "/"], ["--out", "a.jpg"], ["--fps", "26"], ["--live", "--out", "a.png"],
     ["--live", "--scans", "2"], ["--npz", "a.txt"]],
)  # fmt: skip
def test_command_refuses_wrong_usage_before_it_connects(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["ws://127.0.0.1:1", *wrong])
    assert ended.value.code == 2
    assert wrong[0] in capsys.readouterr().err


@pytest.mark.parametrize(("option", "name"), [("--out", "a.png"), ("--npz", "a.npz")])
def test_command_writes_over_no_file_unasked(
    option: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (path := tmp_path / name).write_text("mine")
    with pytest.raises(SystemExit) as ended:
        main(["ws://127.0.0.1:1", option, str(path)])
    assert (
        ended.value.code == 2 and f"{path}: it exists already; give --overwrite, or another name" in capsys.readouterr().err
    )
    assert main(["ws://127.0.0.1:1", option, str(path), "--overwrite", "--no-reconnect"]) == 1  # there is no such feed
    assert path.read_text() == "mine"
