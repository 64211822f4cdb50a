"""Results in files: used where they were made of the same, and whole."""

from pathlib import Path

import pytest

from radar_service.batch.jobs import Job
from radar_service.batch.result_folder import ResultFolder

RESULT = {"seed": 3, "program": "a", "value": 0.1}


def test_a_result_is_used_where_it_was_made_of_the_same(tmp_path: Path) -> None:
    folder = ResultFolder(tmp_path / "runs")
    folder.write(Job("one", ()), RESULT)
    for made_of, used in (({}, True), ({"seed": 3, "program": "a"}, True), ({"seed": 4}, False), ({"other": 1}, False)):
        assert (folder.read(Job("one", (), made_of)) == RESULT) is used
    assert folder.read(Job("two", ())) is None


@pytest.mark.parametrize("content", ["", '{"seed": 3', "[]", "7", "null"])
def test_a_file_that_is_cut_or_something_else_is_made_anew(content: str, tmp_path: Path) -> None:
    folder, job = ResultFolder(tmp_path), Job("one", (), {"seed": 3})
    folder.path("one").write_text(content)
    assert folder.read(job) is None
    folder.write(job, RESULT)
    assert folder.read(job) == RESULT and [file.suffix for file in tmp_path.iterdir()] == [".json"]


def test_names_of_any_length_and_letters_have_files_of_their_own(tmp_path: Path) -> None:
    """File systems take 255 bytes."""
    folder = ResultFolder(tmp_path)
    names = ["x" * 300, "x" * 301, "a/b", "a:b", "日本 語" * 40]
    for k, name in enumerate(names):
        folder.write(Job(name, ()), {"k": k})
    assert [folder.read(Job(name, ())) for name in names] == [{"k": k} for k in range(len(names))]
