"""Mutants differ from a module in one operator or constant each; modules of a folder, mutants of a list and tests are found."""

import ast
from pathlib import Path

import pytest

from tests.measurements.mutants import LISTED, MOST, ROOT, changes, compared, listed, modules, mutant, mutants_of, nearest


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
    made = list(changes(source))
    assert sorted(mutant(source, number) for number, _, _ in made) == sorted(changed)
    assert all(line == 1 and " -> " in words for _, line, words in made)


def test_a_mutant_is_a_module_that_differs_from_it() -> None:
    source = Path(__file__).read_text(encoding="utf-8")
    texts = [mutant(source, number) for number, _, _ in changes(source)]
    assert texts and ast.unparse(ast.parse(source)) not in texts


def test_files_and_those_of_folders_are_taken_once(tmp_path: Path) -> None:
    for name in ("a.py", "inner/b.py", "notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert modules([tmp_path, tmp_path / "a.py"]) == [tmp_path / "a.py", tmp_path / "inner" / "b.py"]


def test_a_list_names_a_hundred_mutants_and_finds_those_whose_lines_have_moved() -> None:
    rows = LISTED.read_text(encoding="utf-8").splitlines()
    assert len(rows) == len({*rows}) == 100
    module = ROOT / "radar_service" / "numerics" / "gamma_law.py"
    every = mutants_of(module)
    words = [made.words for made in every]
    only = next(made for made in every if words.count(made.words) == 1)
    name = module.relative_to(ROOT)
    moved, gone, other = listed(f"killed {name}:{only.line + 7}: {only.words}\nkilled {name}:1: a -> b\nnew no.py:1: a -> b")
    assert moved[:2] == ("killed", only) and gone[1] is other[1] is None


def test_the_tests_nearest_to_a_module_run_first_and_are_not_too_many() -> None:
    module = ROOT / "radar_service" / "echo" / "moving.py"
    far = [f"tests/wire/test_format.py::test_{number}" for number in range(MOST)]
    own, beside = "tests/echo/test_moving.py::test_z", "tests/echo/test_echoes.py::test_a"
    near, others = nearest([*far, beside, own], module)
    assert near == [own] and others[0] == beside and len(others) == MOST - 1


def test_only_what_was_killed_can_be_lost() -> None:
    verdicts = [(now, before) for now in ("killed", "survives") for before in ("killed", "survives", "new")]
    assert [pair for pair in verdicts if compared(*pair) == "lost"] == [("survives", "killed")]
