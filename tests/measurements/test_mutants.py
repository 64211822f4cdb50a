"""Mutants differ from a module in one operator or constant each, and the modules of a folder are found."""

import ast
from pathlib import Path

import pytest

from tests.measurements.mutants import modules, mutable, mutant


@pytest.mark.parametrize(
    ("source", "changed"),
    [
        ("a < b", ["a <= b"]),
        ("a is None and b", ["a is None or b", "a is not None and b"]),
        ("-a * 2.5", ["-a / 2.5", "+a * 2.5", "-a * 3.5"]),
        ("a += 1", ["a -= 1", "a += 2"]),
        ("f(True, 'text')", []),
    ],
)
def test_each_operator_and_number_has_one_mutant(source: str, changed: list[str]) -> None:
    made = [mutant(source, number) for number in mutable(source)]
    assert sorted(text for text, _ in made) == sorted(changed)
    assert all(words.startswith("1: ") and " -> " in words for _, words in made)


def test_a_mutant_is_a_module_that_differs_from_it() -> None:
    source = Path(__file__).read_text(encoding="utf-8")
    texts = [mutant(source, number)[0] for number in mutable(source)]
    assert texts and ast.unparse(ast.parse(source)) not in texts


def test_files_and_those_of_folders_are_taken_once(tmp_path: Path) -> None:
    for name in ("a.py", "inner/b.py", "notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert modules([tmp_path, tmp_path / "a.py"]) == [tmp_path / "a.py", tmp_path / "inner" / "b.py"]
