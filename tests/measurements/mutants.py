"""Breaks modules in small ways and tells which of these mutants the tests kill.

    python -m tests.measurements.mutants [MODULE ...] [--count 100] [--seed 0] [--also TEST ...] [--against TREE]
    python -m tests.measurements.mutants --list [FILE] [--only VERDICT ...]

MODULE is a file or a folder, radar_service by default. In a mutant one operator of comparison, arithmetic or logic is another
one, or one constant is larger by 1. It lives in a copy of this tree, where the tests that run its line are called: first those of
the file that mirrors the module, then, where it survives, others, with those of --also. Which run it says `.coverage`, which
`pytest --cov --cov-context=test` writes; without it, and for lines that run at import, they are those of the module's folder.
With --against, the mutants that the tests of that tree kill are what the tests of this one must kill. --list runs those of a
file, tests/measurements/mutants.txt by default, and writes each verdict there; `--only new` goes on after an end before time.
`equal` ones alter nothing that is promised, for the reason beside them, and are not run. Exits with 1 where one that was killed
survives. Equal modules and seeds give equal mutants.
"""

import argparse
import ast
import copy
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from coverage import CoverageData

from tests.test_house_rules import mirrored

ROOT = Path(__file__).parents[2]
LISTED = Path(__file__).with_suffix(".txt")
MOST = 80  # tests of a mutant: a line that nearly all tests run is checked by the nearest of them
LIMIT_S, LIMIT_CPU_S = 300, 60  # for the tests of a mutant, which may wait or compute for ever; it is killed then
PASSED = (0, 5)  # exit codes of pytest; 5: all tests are studies
FAILURE = re.compile(r"^(?:FAILED|ERROR) ([^\s\[]+(?:\[.*?\])?)(?: - |$)", re.MULTILINE)  # in the summary of pytest
SWAPS: dict[type[ast.AST], Any] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.USub: ast.UAdd,
}  # fmt: skip


def change(node: ast.AST) -> bool:
    """Changes a node in place; whether there is a change for it."""
    match node:
        case ast.Compare(ops=[op, *_]) if type(op) in SWAPS:
            node.ops[0] = SWAPS[type(op)]()
        case ast.BinOp(op=op) | ast.BoolOp(op=op) | ast.UnaryOp(op=op) | ast.AugAssign(op=op) if type(op) in SWAPS:
            node.op = SWAPS[type(op)]()
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            node.value = value + 1
        case _:
            return False
    return True


def changes(source: str) -> Iterator[tuple[int, int, str]]:
    """Yields of each node that has a change its number, in the order of `ast.walk`, its line, and the change in words."""
    for number, node in enumerate(ast.walk(ast.parse(source))):
        other = copy.deepcopy(node)
        if change(other):
            yield number, getattr(node, "lineno", 0), f"{ast.unparse(node)} -> {ast.unparse(other)}"


def mutant(source: str, number: int) -> str:
    """Returns the source with the change of one node."""
    tree = ast.parse(source)
    change(list(ast.walk(tree))[number])
    return ast.unparse(tree)


class Mutant(NamedTuple):
    """A module, the number of the node that is changed there, its line, and the change in words."""

    module: Path
    number: int
    line: int
    words: str


def mutants_of(module: Path) -> list[Mutant]:
    """Returns all mutants of a module."""
    return [Mutant(module, *rest) for rest in changes(module.read_text(encoding="utf-8"))]


def listed(text: str) -> Iterator[tuple[str, Mutant | None, str]]:
    """Yields the verdict of each line of a list, its mutant, nearest to the line where it was, and the line without the verdict.

    There is no mutant where the code has changed."""
    every = cache(mutants_of)
    for row in text.splitlines():
        verdict, _, what = row.partition(" ")
        name, line, words = what.strip().partition("  # ")[0].split(":", 2)
        same = [found for found in every(ROOT / name) if found.words == words.strip()] if (ROOT / name).is_file() else []
        yield verdict, min(same, key=lambda found: abs(found.line - int(line)), default=None), what.strip()


def nearest(tests: Iterable[str], module: Path) -> tuple[list[str], list[str]]:
    """Returns MOST of some tests: those of the files that mirror a module, and others, those of its folder first."""
    files = [path.relative_to(ROOT).as_posix() for path in mirrored(module)]
    folder = files[0].rpartition("/")[0]
    ordered = sorted(tests, key=lambda test: (test.split("::")[0] not in files, not test.startswith(folder), test))[:MOST]
    count = sum(test.split("::")[0] in files for test in ordered)
    return ordered[:count], ordered[count:]


class Copy:
    """A copy of this tree with the tests of a tree. covered: which test runs which line, of an earlier run."""

    def __init__(self, folder: Path, tests: Path, also: list[str], covered: CoverageData | None = None) -> None:
        unneeded = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "tests", "dist", "build")
        shutil.copytree(ROOT, folder, ignore=unneeded)
        shutil.copytree(tests / "tests", folder / "tests", ignore=shutil.ignore_patterns("__pycache__"))
        self.folder, self.also, self.covered = folder, also, covered
        self.passes = cache(lambda tests: not self.failing(tests))

    def tests_of(self, module: Path, line: int) -> Iterator[tuple[str, ...]]:
        """Yields those of the file that mirrors a module that run its line, and others that do, with those of --also."""
        lines = self.covered.contexts_by_lineno(str(module)) if self.covered else {}
        running = {context.rpartition("|")[0] for context in lines.get(line, [])} - {""}
        files = {
            path.relative_to(ROOT).as_posix() for path in [*mirrored(module), *mirrored(module)[0].parent.glob("test_*.py")]
        }
        there = [test for test in running or files if (self.folder / test.split("::")[0]).exists()]
        near, others = nearest(there, module)
        yield tuple(near)
        yield (*others, *self.also)

    def failing(self, tests: tuple[str, ...]) -> tuple[str, ...]:
        """The first of some tests that fails; all of them where pytest names none and does not pass, or does not end."""
        limits = ["prlimit", f"--cpu={LIMIT_CPU_S}", "timeout", "-s", "KILL", str(LIMIT_S)]
        options = ["-q", "-x", "-rfE", "-n", "0", "-p", "no:cacheprovider"]
        with tempfile.TemporaryFile("w+") as said:
            command = [*limits, sys.executable, "-m", "pytest", *options, *tests]
            code = subprocess.run(command, cwd=self.folder, stdout=said).returncode
            said.seek(0)
            return () if code in PASSED else tuple(re.findall(FAILURE, said.read())) or tests

    def verdict(self, made: Mutant) -> str:
        """`killed` or `survives`; `unclear` where no test is near, or what fails does so without the mutant too."""
        file, verdict = self.folder / made.module.relative_to(ROOT), "unclear"
        kept = file.read_text(encoding="utf-8")
        for tests in filter(None, self.tests_of(made.module, made.line)):
            file.write_text(mutant(kept, made.number), encoding="utf-8")
            try:
                failing = self.failing(tests)
            finally:
                file.write_text(kept, encoding="utf-8")
            if failing:
                return "killed" if self.passes(failing) else "unclear"
            verdict = "survives"
        return verdict


def modules(positions: list[Path]) -> list[Path]:
    """The modules that files and folders name."""
    found = {file for position in positions for file in (position.rglob("*.py") if position.is_dir() else [position])}
    return sorted(found)


def compared(now: str, before: str) -> str:
    """Returns the verdict on a mutant of which another tree, or an earlier run, says `before`."""
    return "lost" if (now, before) == ("survives", "killed") else now


def main() -> int:
    """Prints a line for each mutant, then how many there are and how many are killed; 1 where one is lost."""
    parser = argparse.ArgumentParser(description="Tells which small faults the tests notice.")
    parser.add_argument("modules", nargs="*", type=Path, default=[ROOT / "radar_service"])
    parser.add_argument("--count", type=int, default=100, help="mutants (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the choice (default: %(default)s)")
    parser.add_argument("--also", nargs="*", default=[], metavar="TEST", help="tests besides those that run a line")
    parser.add_argument("--against", type=Path, metavar="TREE", help="whose tests say what these must kill")
    parser.add_argument("--only", nargs="+", metavar="VERDICT", help="those of the list that have one of these")
    parser.add_argument("--list", nargs="?", type=Path, const=LISTED, metavar="FILE", help="of mutants and their verdicts")
    options = parser.parse_args()
    covered = CoverageData(str(ROOT / ".coverage")) if (ROOT / ".coverage").exists() else None
    if covered:
        covered.read()
    if options.list and options.list.exists():
        rows = list(listed(options.list.read_text(encoding="utf-8")))
    else:
        every = [made for file in modules([path.resolve() for path in options.modules]) for made in mutants_of(file)]
        chosen = sorted(random.Random(options.seed).sample(every, min(options.count, len(every))))
        rows = [("new", made, f"{made.module.relative_to(ROOT)}:{made.line}: {made.words}") for made in chosen]
    told, tallies = [f"{before:8} {text}" for before, _, text in rows], Counter[str]()
    with tempfile.TemporaryDirectory() as scratch:
        here = Copy(Path(scratch) / "here", ROOT, options.also, covered)
        there = Copy(Path(scratch) / "there", options.against, options.also) if options.against else None
        for number, (before, made, text) in enumerate(rows):
            if before not in options.only if options.only else before == "equal":
                tallies[before] += 1
                continue
            now = here.verdict(made) if made else "gone"
            verdict = compared(now, there.verdict(made) if there and made else before)
            tallies[verdict] += 1
            told[number] = f"{verdict if verdict == 'lost' else now:8} {text}"
            print(told[number], flush=True)
            if options.list:
                options.list.write_text("\n".join(told) + "\n", encoding="utf-8")
    print(f"{len(rows)} mutants:", ", ".join(f"{count} {verdict}" for verdict, count in tallies.items()))
    return 1 if tallies["lost"] else 0


if __name__ == "__main__":
    sys.exit(main())
