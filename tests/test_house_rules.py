"""Rules of the house besides those of imports, which `lint-imports` checks: names of the field, short files, nobody reaches into
another's private attributes, and tests that mirror the tree; no address of a package registry."""

import ast
import re
import subprocess
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from statistics import median

import pytest

ROOT = Path(__file__).parents[1]
parsed = cache(ast.parse)  # several rules look at each file
SOURCES = [*sorted((ROOT / "radar_service").rglob("*.py")), *sorted((ROOT / "clients" / "ppi").rglob("*.py"))]
TESTS = sorted((ROOT / "tests").rglob("*.py"))
MIN_LINES, MAX_LINES = 40, 600  # of a file
SHORT = {  # files below MIN_LINES that are right so: what several need and nobody owns, or what a rule gives a file of its own
    "clients/ppi": "address errors",
    "radar_service": "public_names pytest_plugin strict_json",
    "radar_service/commands": "believed chart check plan schema stability",
    "radar_service/display": "last_scan",
    "radar_service/numerics": "constants gamma_law kaiser_bessel ragged types",
    "radar_service/ports/ais": "ais_port",
    "radar_service/plots": "picture",
    "radar_service/processes": "stop_signals",
    "radar_service/recording": "error mcap_library",
    "radar_service/records": "plan_item",
    "radar_service/scattering": "models",
    "radar_service/service": "settings token_bucket",
    "radar_service/sources": "numbers",
    "radar_service/terminal": "extras html_pages",
    "radar_service/world": "error",
}
FOR_USERS = ("scans", "plots", "bench", "recording")  # rooms whose `__all__` documents name
MAX_MEDIAN = 8  # lines of a function, its docstring not counted
EMPTY_NAMES = ("util", "utils", "helper", "helpers", "manager", "managers", "base", "common", "misc")
REGISTRIES = re.compile(
    r"(registry\.npmjs|npmjs\.(org|com)|(registry\.)?yarnpkg\.|pypi\.(org|python)|pythonhosted\.|conda\.anaconda|anaconda\.org"
    r"|crates\.io|proxy\.golang|rubygems\.org|unpkg\.com|jsdelivr\.net|cdnjs\.|esm\.sh|skypack\.dev|deb\.debian\.org)"
)
PUBLIC_UNDERSCORE = ("_exit", "_replace", "_asdict", "_fields", "_repr_png_", "_make")  # of os, named tuples and notebooks

# Retired identifiers, by folder. Scene keys, wire keys, options and prose are not concerned.
RETIRED = {
    "": """
        Course smooth_course exact_course SweptEchoes Glance glance Moment Instants Ensemble ensemble_of Reflections
        Reflectors Reflection Fleet Stand Stands stand_at stands_before hides_own Landscape landscape Held TurnRows
        KnownRows BeamRows under_beam swept_by_interval BeamPassing Tubes hollow Pieces lay laid lay_swept Blanking
        blanking fewest fineness swept_together TruthTeller CorrectedChain DocumentedChain knobs ledger Ledger
        leaving_out left_out idle_effects nearest_approach Ahead bearable Outlet Guard Door SceneShelf Yes twin FEW
        FINER said wanted told asked found heard hears ours doubts odd_places sight quick_gain echo_multiplier
        pace_to_keep WITNESSES witnesses mirrored shelf glances its made one whole EngineWorker EngineSupervisor EngineFault
        WorldSource WorldMaker WorldEngine StationWorld WorldClock SceneOrder OrderedSource SpokeLayout BlockCache
    """,
    "radar_service/receive": "drawn deaf",
    **dict.fromkeys(("radar_service/service", "radar_service/ports"), "say again coming follow_with shaped journal mailbox"),
    "radar_service/study": "surface_twin anchors sheet still",
    "radar_service/propagation": "way _mirror",
}


@cache
def nodes_of(source: str) -> tuple[ast.AST, ...]:
    """All nodes of a module."""
    return tuple(ast.walk(parsed(source)))


def name_of(file: Path) -> str:
    """The file's path below the project's folder."""
    return file.relative_to(ROOT).as_posix()


def identifiers(source: str) -> Iterator[str]:
    """All names that a module defines or uses, but for those inside strings."""
    for node in nodes_of(source):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name) | ast.alias(name=name):
                yield from name.split(".")
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield name


def retired_in(name: str, source: str) -> set[str]:
    """Retired identifiers in a file, by its name below the project's folder; it is parsed where one of the words stands in it."""
    retired = {word for folder, words in RETIRED.items() if name.startswith(folder) for word in words.split()}
    in_name = retired & {*Path(name).with_suffix("").parts}
    suspected = retired & {*re.findall(r"\w+", source)}
    return in_name | (suspected & {*identifiers(source)} if suspected else set())


def test_no_retired_identifier_returns() -> None:
    faults = [
        f"{name_of(file)} uses as a name: {', '.join(map(repr, sorted(used)))}"
        for file in SOURCES
        if (used := retired_in(name_of(file), file.read_text(encoding="utf-8")))
    ]
    assert not faults, "\n".join([*faults, "these are retired (RETIRED, above); docs/glossary.md has the words in use"])


def test_retired_identifiers_are_found() -> None:
    source = 'def f(deaf):\n    """A word of prose is free: drawn."""\n    return twin.deaf'
    assert retired_in("radar_service/receive/mirrored.py", source) == {"deaf", "twin", "mirrored"}
    assert retired_in("radar_service/echo/beam.py", source) == {"twin"}


def docstrings(source: str) -> Iterator[tuple[int, str]]:
    """The docstrings of a module, its classes and functions, each with the line of what has it."""
    for node in nodes_of(source):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and (
            text := ast.get_docstring(node)
        ):
            yield getattr(node, "lineno", 1), text


def names_another(source: str) -> list[int]:
    """Lines of docstrings that begin with the name of something else that has one: "As Port.sinks."."""
    return [line for line, text in docstrings(source) if re.match(r"As (that|those|`|[A-Za-z_]*[A-Z_.])", text)]


def test_no_docstring_names_another_one_instead_of_saying_what_there_is() -> None:
    faults = [f"{name_of(file)}:{line}" for file in SOURCES for line in names_another(file.read_text(encoding="utf-8"))]
    assert not faults, f"write a sentence, or mark what implements an interface with @override: {', '.join(faults)}"


@pytest.mark.parametrize(
    ("text", "faulty"),
    [("As Port.sinks.", True), ("As `tiles`, each with its labels.", True), ("As that of others.", True), ("As PORTS.", True),
     ("Assigns numbers.", False), ("As fine as needed.", False)],
)  # fmt: skip
def test_docstrings_that_name_another_one_are_found(text: str, faulty: bool) -> None:
    assert names_another(f'class A:\n    def f(self):\n        """{text}"""') == [2] * faulty


def test_names_say_what_a_thing_is() -> None:
    empty = [name_of(file) for file in SOURCES if {*Path(name_of(file)).with_suffix("").parts} & {*EMPTY_NAMES}]
    assert not empty, f"these say nothing about the radar, name them for what they do: {', '.join(empty)}"


def test_no_address_of_a_package_registry_stands_in_a_tracked_file() -> None:
    """Clients such as pip and npm get packages by name; which registry they use is the machine's business."""
    if not (ROOT / ".git").exists():
        pytest.skip("this is no checkout of git, so tracked files are not known")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    texts = {
        name: (ROOT / name).read_bytes().decode(errors="replace") for name in listed.split("\0") if (ROOT / name).is_file()
    }
    faults = [f"{name}: {match[0]}" for name, text in texts.items() if (match := REGISTRIES.search(text))]
    assert ".ci/run" in texts and not faults, f"name the package and leave the registry to its client: {', '.join(faults)}"


def test_addresses_of_registries_are_found() -> None:
    hosts = [".".join(parts) for parts in (("registry", "npmjs", "org"), ("files", "pythonhosted", "org"), ("pypi", "org"))]
    assert all(REGISTRIES.search(f"curl https://{host}/x") for host in hosts)


def imported(file: Path) -> list[tuple[str, str, str]]:
    """The room, the module and the name of all that a file imports from the package's rooms."""
    nodes = [node for node in nodes_of(file.read_text(encoding="utf-8")) if isinstance(node, ast.ImportFrom)]
    modules = [(node.module or "", node.names) for node in nodes if (node.module or "").startswith("radar_service.")]
    return [(module.split(".")[1], module, name.name) for module, names in modules for name in names]


def test_rooms_with_a_front_door_are_entered_there() -> None:
    """What the `__init__` of a room lists is what other rooms import, and they import it from there. A name that is also a file's
    cannot be listed."""
    listing = [file for file in SOURCES if "lazily(__name__)" in file.read_text(encoding="utf-8")]
    inits = [file for file in listing if file.match("radar_service/*/__init__.py")]
    doors = {file.parent.name: {name for room, _, name in imported(file) if room == file.parent.name} for file in inits}
    entered: dict[str, set[str]] = {room: set() for room in doors}
    for file in {*(ROOT / "radar_service").rglob("*.py")} - {*listing}:
        own = file.relative_to(ROOT / "radar_service").parts[0]
        for room, module, name in imported(file):
            if room in doors and room != own:
                assert module.count(".") == 1 or name not in doors[room], (
                    f"{name_of(file)}: import {name} from the room {room}"
                )
                entered[room].add(name)
    unused = {
        room: names - entered[room] for room, names in doors.items() if room not in FOR_USERS and names - entered[room]
    }
    assert not unused, f"no other room imports these, take them off the `__init__`: {unused}"


def test_files_are_short() -> None:
    lines = {name_of(file): len(file.read_text(encoding="utf-8").splitlines()) for file in SOURCES}
    long = {name: count for name, count in lines.items() if count > MAX_LINES}
    assert not long, f"more than {MAX_LINES} lines, split them by responsibility: {long}"


def test_files_are_long_enough_to_be_a_door() -> None:
    lines = {name_of(file): len(file.read_text(encoding="utf-8").splitlines()) for file in SOURCES}
    short = {name for name, count in lines.items() if count < MIN_LINES and not name.endswith("/__init__.py")}
    listed = {f"{folder}/{stem}.py" for folder, stems in SHORT.items() for stem in stems.split()}
    assert not short - listed, f"less than {MIN_LINES} lines, let them be part of what uses them: {sorted(short - listed)}"
    assert not listed - short, f"no longer short, take them off the list: {sorted(listed - short)}"


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function's body without its docstring."""
    body = function.body
    if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant) and isinstance(body[0].value.value, str):
        body = body[1:]
    return sum((node.end_lineno or node.lineno) - node.lineno + 1 for node in body)


def test_functions_are_short() -> None:
    functions = [
        node
        for file in SOURCES
        for node in nodes_of(file.read_text(encoding="utf-8"))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    assert median(map(body_lines, functions)) < MAX_MEDIAN


MAY_REACH = re.compile(r"(?<!\bself)(?<!\bcls)\._[^\W_]|\bimport\b[^\n]*[ ,(]_[^\W_]|^\s+_\w+,?$", flags=re.M)


def private_reaches(source: str) -> Iterator[str]:
    """Private attributes of other objects, and private names of other modules, that a module uses; it is parsed where it may."""
    if not MAY_REACH.search(source):
        return
    own = {node.name for node in nodes_of(source) if isinstance(node, ast.ClassDef)}
    for node in nodes_of(source):
        match node:
            case ast.Attribute(value=value, attr=attr) if attr.startswith("_") and not attr.startswith("__"):
                owner = ast.unparse(value)
                if attr not in PUBLIC_UNDERSCORE and owner not in ("self", "cls", "other", "super()", *own):
                    yield f"{owner}.{attr} (line {node.lineno})"
            case ast.ImportFrom(module=module, names=names) if module and module.split(".")[0] in (
                "radar_service",
                "clients",
            ):
                yield from (f"{module}.{a.name}" for a in names if a.name.startswith("_") and not a.name.startswith("__"))


def test_nobody_reaches_into_private_attributes() -> None:
    faults = [
        f"{name_of(file)} reaches into {', '.join(reaches)}"
        for file in [*SOURCES, *TESTS]
        if (reaches := list(private_reaches(file.read_text(encoding="utf-8"))))
    ]
    assert not faults, "\n".join([*faults, "give what they need a public name"])


def test_reaches_are_found() -> None:
    source = (
        "from radar_service.plan.plan import _head\nclass A:\n    def f(self, b): return self._x, A._y, b._z, b._replace()\n"
    )
    assert list(private_reaches(source)) == ["radar_service.plan.plan._head", "b._z (line 3)"]


RIDDLES = re.compile(
    r"(?:They|It|That|Those|These|Its|Her|Has|Is|Does|Something|Who|Whoever)\b|[A-Z][a-z]+(?:[A-Z][a-z]+)+ (?!is |are |has )[a-z]"
)


def test_docstrings_begin_with_what_they_are_about() -> None:
    """With a verb or a noun of the field: no pronoun, and no class that a renaming has put in place of a word."""
    faults = [
        f"{name_of(file)}: {text.splitlines()[0]}"
        for file in SOURCES
        for _, text in docstrings(file.read_text(encoding="utf-8"))
        if RIDDLES.match(text)
    ]
    assert not faults, "\n".join([*faults, "begin with a verb or a noun"])


@pytest.mark.parametrize(
    "text", ["They at some instants (N,).", "RunControl that many spokes more.", "Those of echoes `which`."]
)
def test_docstrings_that_are_riddles_are_found(text: str) -> None:
    assert RIDDLES.match(text) and not RIDDLES.match("Returns it. A RunControl is kept. PyVista draws. Island of points.")


EXPLAINED = re.compile(r"(?:^|(?<=[.;] ))([a-z_]\w*(?:, [a-z_]\w*)*): ")
Scope = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
VALUES = {"nan", "inf", "none", "auto", "arguments"}  # which a docstring may explain beside arguments and fields


def unknown_arguments(scopes: tuple[Scope, ...], members: Mapping[str, set[str]]) -> Iterator[str]:
    """What the docstrings in the first scope explain, as `name: ...`, that neither it nor a scope around it has."""
    for node in scopes[0].body:
        if isinstance(node, Scope):
            text = re.sub(r"\s+", " ", ast.get_docstring(node) or "")
            explained = {name for found in EXPLAINED.finditer(text) for name in found[1].split(", ")} - VALUES
            for scope in (node, *scopes[:-1]):
                explained -= names_in(scope, members) if explained else set()
            yield from (f"{node.name}: {name}" for name in sorted(explained))
            yield from unknown_arguments((node, *scopes), members)


def names_in(node: ast.AST, members: Mapping[str, set[str]] = {}) -> set[str]:
    """Arguments, variables, attributes, keys and functions in a piece of code; members: of the bases of a class too."""
    kinds = ("arg", "id", "attr", "value", "name")
    names = {getattr(each, kind, None) for each in ast.walk(node) for kind in kinds}
    bases = node.bases if isinstance(node, ast.ClassDef) else []
    inherited = {name for base in bases for each in names_in(base) for name in members.get(each, ())}
    return inherited | {name for name in names if isinstance(name, str) and name.isidentifier()}


def test_docstrings_explain_arguments_and_fields_that_exist() -> None:
    classes = [
        node for file in SOURCES for node in parsed(file.read_text(encoding="utf-8")).body if isinstance(node, ast.ClassDef)
    ]
    members = {node.name: names_in(node) for node in classes}
    faults = [
        f"{name_of(file)}: {fault}"
        for file in SOURCES
        for fault in unknown_arguments((parsed(file.read_text(encoding="utf-8")),), members)
    ]
    assert not faults, "\n".join([*faults, "no such argument or field"])


def test_arguments_that_do_not_exist_are_found() -> None:
    source = (
        'class A(B):\n    """A record. source: of it; size, of: its own.\n\n    base: of B. See: that."""\n    size: int\n'
        "    of: str\n"
        '    def f(self, x):\n        """Does it. y: gone; x, size: known; nan: none."""\n'
    )
    assert list(unknown_arguments((parsed(source),), {"B": {"base"}})) == ["A: source", "f: y"]


def mirrored(file: Path) -> list[Path]:
    """Where the tests of a module may stand: radar_service/echo/moving.py has tests/echo/test_moving.py; where few, as for
    radar_service/world/error.py, in that of the folder below `# error: ...`. A study may do without: one test runs all."""
    parts = list(file.relative_to(ROOT).with_suffix("").parts)
    parts = parts[1:] if parts[0] == "radar_service" else ["clients", *parts[2:]]
    stem = parts[-1].strip("_")
    folder = ROOT / "tests" / Path(*parts[:-1])
    of_folder = folder / f"test_{folder.name}.py"
    part = of_folder.is_file() and f"# {stem}: " in of_folder.read_text(encoding="utf-8")
    of_all = [folder.parent / "test_stability.py"] if folder.name == "studies" else []
    return [folder / f"test_{stem}.py", *[of_folder] * part, *of_all]


def test_each_module_has_a_test_that_mirrors_it() -> None:
    missing = [
        f"{name_of(file)} has no {name_of(mirrored(file)[0])}"
        for file in SOURCES
        if file.name != "__init__.py" and not any(position.is_file() for position in mirrored(file))
    ]
    assert not missing, "\n".join(missing)
