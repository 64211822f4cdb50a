"""Breaks modules in small ways and tells which of these mutants the tests kill.

    python -m tests.measurements.mutants [MODULE ...] [--count 100] [--seed 0] [--also TEST ...] [--against TREE]

MODULE is a file or a folder, radar_service by default. In a mutant one operator of comparison, arithmetic or logic is another
one, or one constant is larger by 1. It lives in a copy of this tree, where the test file that mirrors its module runs, with those
of --also. With --against, the mutants that the tests of that tree kill are what the tests of this one must kill. Exits with 1
where one of these survives. Equal modules and seeds give equal mutants.
"""

import argparse
import ast
import random
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from tests.test_house_rules import mirrored

ROOT = Path(__file__).parents[2]
LIMIT_S = 300  # for the tests of a mutant, which may never end; it is killed then
PASSED, FAILED = 0, 1  # exit codes of pytest
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


def mutable(source: str) -> list[int]:
    """Returns the numbers, in the order of `ast.walk`, of the nodes that have a change."""
    return [number for number, node in enumerate(ast.walk(ast.parse(source))) if change(node)]


def mutant(source: str, number: int) -> tuple[str, str]:
    """Returns the source with the change of one node, and the change in words."""
    tree = ast.parse(source)
    node = list(ast.walk(tree))[number]
    before = ast.unparse(node)
    change(node)
    return ast.unparse(tree), f"{getattr(node, 'lineno', 0)}: {before} -> {ast.unparse(node)}"


class Copy:
    """A copy of this tree with the tests of a tree."""

    def __init__(self, folder: Path, tests: Path, also: list[str]) -> None:
        unneeded = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "tests", "dist", "build")
        shutil.copytree(ROOT, folder, ignore=unneeded)
        shutil.copytree(tests / "tests", folder / "tests", ignore=shutil.ignore_patterns("__pycache__"))
        self.folder, self.also = folder, also
        self.passes = cache(self._passes)

    def tests_of(self, module: Path) -> list[str]:
        """The test file that mirrors a module, and those of --also."""
        files = [path.relative_to(ROOT).as_posix() for path in mirrored(module)] + self.also
        return [file for file in files if (self.folder / file.split("::")[0]).exists()]

    def exit_code(self, module: Path) -> int:
        """That of pytest on the tests of a module."""
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *self.tests_of(module)]
        try:
            return subprocess.run(command, cwd=self.folder, stdout=subprocess.DEVNULL, timeout=LIMIT_S).returncode
        except subprocess.TimeoutExpired:
            return FAILED

    def _passes(self, module: Path) -> bool:
        return bool(self.tests_of(module)) and self.exit_code(module) == PASSED

    def kills(self, module: Path, source: str) -> bool:
        """Whether the tests of a module fail where its source is another one."""
        file = self.folder / module.relative_to(ROOT)
        kept = file.read_text(encoding="utf-8")
        file.write_text(source, encoding="utf-8")
        try:
            return self.exit_code(module) != PASSED
        finally:
            file.write_text(kept, encoding="utf-8")


def modules(positions: list[Path]) -> list[Path]:
    """The modules that files and folders name."""
    found = {file for position in positions for file in (position.rglob("*.py") if position.is_dir() else [position])}
    return sorted(found)


def main() -> int:
    """Prints a line for each mutant, then how many there are and how many are killed; 1 where one is lost."""
    parser = argparse.ArgumentParser(description="Tells which small faults the tests notice.")
    parser.add_argument("modules", nargs="*", type=Path, default=[ROOT / "radar_service"])
    parser.add_argument("--count", type=int, default=100, help="mutants (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the choice (default: %(default)s)")
    parser.add_argument("--also", nargs="*", default=[], metavar="TEST", help="tests besides the one that mirrors a module")
    parser.add_argument("--against", type=Path, metavar="TREE", help="whose tests say what these must kill")
    options = parser.parse_args()
    files = modules([path.resolve() for path in options.modules])
    sources = {file: file.read_text(encoding="utf-8") for file in files}
    places = [(file, number) for file, source in sources.items() for number in mutable(source)]
    chosen = sorted(random.Random(options.seed).sample(places, min(options.count, len(places))))
    tallies = {"killed": 0, "survives": 0, "lost": 0, "unclear": 0}
    with tempfile.TemporaryDirectory() as scratch:
        here = Copy(Path(scratch) / "here", ROOT, options.also)
        there = Copy(Path(scratch) / "there", options.against, options.also) if options.against else None
        for file, number in chosen:
            source, words = mutant(sources[file], number)
            if not here.passes(file):
                verdict = "unclear"  # tests that fail without a mutant say nothing
            elif there:
                expected = there.kills(file, source)
                verdict = ("killed" if here.kills(file, source) else "lost") if expected else "survives"
            else:
                verdict = "killed" if here.kills(file, source) else "survives"
            tallies[verdict] += 1
            print(f"{verdict:8} {file.relative_to(ROOT)}:{words}", flush=True)
    print(f"{len(chosen)} of {len(places)} mutants, seed {options.seed}:", ", ".join(f"{n} {k}" for k, n in tallies.items()))
    return 1 if tallies["lost"] else 0


if __name__ == "__main__":
    sys.exit(main())
