"""The documents are true: links resolve, files exist, tables are those of the code, examples run, the code cites what exists."""

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import radar_service as rs
from radar_service.commands.command_line import parser
from radar_service.scene_file.load import load_scene
from tests.prose import DOCSTRING, Names, code, code_files
from tests.prose import prose as prose_of
from tests.reference.docs_tables import TABLES, renewed

ROOT = Path(__file__).parents[1]
HISTORY = ["CHANGELOG.md", *(f"docs/changes/{file.name}" for file in (ROOT / "docs" / "changes").glob("[0-9]*.md"))]
FRAGMENTS = [f"docs/changes/{file.name}" for file in sorted((ROOT / "docs" / "changes").glob("[!0-9]*.md"))]
FOUND = [file.relative_to(ROOT).as_posix() for file in sorted((ROOT / "docs").rglob("*.md"))]
NAMES = ["README.md", "CONTRIBUTING.md", *(name for name in FOUND if name not in HISTORY + FRAGMENTS)]
DOCUMENTS = [ROOT / name for name in NAMES]
CODE = [
    file
    for pattern in ("*.py", "*.js", "*.toml")
    for folder in ("radar_service", "clients", "scenes", "tests")
    for file in sorted((ROOT / folder).rglob(pattern))
]
LINK = re.compile(r"\]\(([^)\s]+)\)")
CITATION = re.compile(r"docs/[\w/-]+\.md(?:#[\w-]+)?")
NUMBERED = re.compile(r"docs/specification\.md,? (eqs?\.|errata rows?) (\d+(?:(?:, | and | to )\d+)*)")
OUTSIDE = re.compile(
    r"\bDESIGN\b|(?:\(|# )issue\b|\b[Ss]eed('s| eqs?\.| algorithm| fig(?:ure|\.)| \d+\.\d)"
    r"|(?<![\w/.-])(?!docs/|README|CONTRIBUTING|CHANGELOG)[\w./-]+\.md\b"
)
MAY_CITE = re.compile(r"DESIGN|issue|eed|\.md")  # three files in four have none of these
EQUATIONS, ROWS = range(1, 23), range(1, 14)


def text(name: str) -> str:
    """A file of the repository."""
    return (ROOT / name).read_text(encoding="utf-8")


def prose(name: str) -> str:
    """A document without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", text(name), flags=re.M | re.S)


def anchors(name: str) -> set[str]:
    """What links into a document may point to: its headings, as GitHub turns them into anchors, and explicit ids."""
    headings = re.findall(r"^#+ (.+)$", prose(name), flags=re.M)
    slugs = [
        re.sub(r"[^\w\- ]", "", re.sub(r"\[(.*?)\]\(.*?\)", r"\1", h).lower()).strip().replace(" ", "-") for h in headings
    ]
    return {*slugs, *re.findall(r'<a id="([\w-]+)">', text(name))}


def blocks(language: str) -> list[tuple[str, str]]:
    """The fenced blocks of exactly that language tag in docs/, each with its document."""
    result = re.compile(rf"^```{re.escape(language)}\n(.*?)^```$", flags=re.M | re.S)
    return [(name, block) for name in NAMES if name.startswith("docs/") for block in result.findall(text(name))]


def broken(source: str, target: str) -> str | None:
    """Why a link of the document `source` does not resolve, None where it does or leaves the repository."""
    if re.match(r"[a-z]+:", target):
        return None
    path, _, anchor = target.partition("#")
    file = (ROOT / source).parent / path if path else ROOT / source
    if not file.exists():
        return f"{source}: {target}: there is no such file"
    name = file.resolve().relative_to(ROOT.resolve()).as_posix()
    return None if not anchor or anchor in anchors(name) else f"{source}: {target}: {name} has no such section"


@pytest.mark.parametrize("name", [*NAMES, *HISTORY, ".github/SECURITY.md"])
def test_links_resolve(name: str) -> None:
    faults = [fault for target in LINK.findall(prose(name)) if (fault := broken(name, target))]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize(
    ("target", "why"),
    [
        ("nowhere.md", "no such file"),
        ("specification.md#nothing", "no such section"),
        ("#nothing", "no such section"),
        ("specification.md#eq-12", None),
        ("../README.md", None),
        ("https://example.org/nothing", None),
    ],
)
def test_a_broken_link_is_found(target: str, why: str | None) -> None:
    fault = broken("docs/engine.md", target)
    assert (fault is None) if why is None else (fault is not None and why in fault)


def test_the_index_lists_every_document() -> None:
    linked = {f"docs/{target.partition('#')[0]}" for target in LINK.findall(text("docs/README.md"))}
    decisions = {f"docs/decisions/{target}" for target in LINK.findall(text("docs/decisions/README.md"))}
    expected = {name for name in NAMES if name.startswith("docs/") and name != "docs/README.md"}
    assert linked | decisions == expected, (linked | decisions) ^ expected
    index = re.findall(r"^- \[([\w-]+\.md)\]", text("docs/README.md"), flags=re.M)
    assert len(index) == len(set(index))


@pytest.mark.parametrize("name", [name for name in NAMES if name.startswith("docs/")])
def test_tables_are_those_of_the_code(name: str) -> None:
    assert renewed(text(name)) == text(name), f"{name}: write its tables anew by python -m tests.reference.docs_tables"


def test_every_table_of_the_code_is_shown_once() -> None:
    shown = [table for name in NAMES for table in re.findall(r"<!-- table: ([a-z-]+) -->", text(name))]
    assert sorted(shown) == sorted(TABLES)


EXAMPLES = blocks("python")
COARSE = {"azimuths": 180, "beamwidth_deg": 8.0, "bandwidth_hz": 2.5e6, "sample_rate_hz": 3.75e6}


def coarse_scene(source: Any, **options: Any) -> rs.Scene:
    """A scene as loaded, but the open sea with a sixteenth of its cells."""
    if source != "open-sea":
        return load_scene(source, **options)
    table = tomllib.loads((ROOT / "scenes" / "open-sea.toml").read_text())
    return load_scene(table | {"radar": table["radar"] | COARSE}, **options)


def test_the_documents_have_python_examples() -> None:
    assert EXAMPLES


@pytest.mark.parametrize("cells", ["fewer", pytest.param("as printed", marks=pytest.mark.study)])
@pytest.mark.parametrize(("name", "example"), EXAMPLES, ids=[f"{k} {name}" for k, (name, _) in enumerate(EXAMPLES)])
def test_python_examples_run(name: str, example: str, cells: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if cells == "fewer":
        monkeypatch.setattr(rs, "load_scene", coarse_scene)
    exec(compile(example, name, "exec"), {})


def test_scene_examples_load_without_a_warning() -> None:
    for name, example in blocks("toml"):
        assert not rs.load_scene(tomllib.loads(example)).warnings, name


def test_the_glossary_has_a_line_for_each_word_in_order() -> None:
    words = re.findall(r"^- \*\*(.+?)\*\*: ", text("docs/glossary.md"), flags=re.M)
    lines = [line for line in text("docs/glossary.md").splitlines() if line.startswith("- ")]
    assert len(words) == len(lines) == len(set(words)) and words == sorted(words, key=str.casefold)


def test_the_specification_has_every_equation_and_every_row_of_the_errata() -> None:
    assert {f"eq-{n}" for n in EQUATIONS} | {f"row-{n}" for n in ROWS} <= anchors("docs/specification.md")


GENERATED = re.compile(r"<!-- (?:table|measured): [a-z-]+ -->\n.*?<!-- end -->", flags=re.S)
WORDS = {"hand-written": 40_000, "generated": 15_000, "of a docstring": 22.0}  # at most


def words(text: str) -> int:
    """Words of a text: what has a letter or a digit, cells of tables too; not of fenced blocks, which are programs."""
    return sum(bool(re.search(r"[^\W_]", word)) for word in re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S).split())


def counted() -> dict[str, float]:
    """Words of README and docs/ without changes, by hand and generated, and the mean of a docstring of the package."""
    whole = {name: text(name) for name in NAMES if name != "CONTRIBUTING.md"}
    by_hand = sum(words(GENERATED.sub("", source)) for name, source in whole.items() if name != "docs/believed.md")
    sources = (file.read_text(encoding="utf-8") for file in (ROOT / "radar_service").rglob("*.py"))
    of_each = [words(docstring[2]) for source in sources for docstring in DOCSTRING.finditer(source)]
    return {
        "hand-written": by_hand,
        "generated": sum(map(words, whole.values())) - by_hand,
        "of a docstring": sum(of_each) / len(of_each),
    }


def test_documents_and_docstrings_keep_their_words() -> None:
    now = counted()
    print(now)
    assert not {kind: (now[kind], most) for kind, most in WORDS.items() if now[kind] > most}


def broken_citations(source: str) -> list[str]:
    """What a source cites of the documents that they do not have."""
    joined = unwrapped(source)
    faults = [fault for cited in CITATION.findall(joined) if (fault := broken("README.md", cited))]
    for kind, numbers in NUMBERED.findall(joined):
        known = EQUATIONS if kind.startswith("eq") else ROWS
        faults += [f"{kind} {n}" for n in re.findall(r"\d+", numbers) if int(n) not in known]
    return faults


def test_citations_in_code_exist() -> None:
    faults = [
        f"{file.relative_to(ROOT)}: {fault}"
        for file in CODE
        if file != Path(__file__)
        for fault in broken_citations(file.read_text(encoding="utf-8"))
    ]
    assert not faults, "\n".join(faults)


def test_broken_citations_are_found() -> None:
    assert broken_citations("# docs/specification.md eqs. 7 and\n# 23; docs/specification.md, errata row 14") == [
        "eqs. 23",
        "errata row 14",
    ]
    (fault,) = broken_citations("docs/nowhere.md and docs/engine.md")
    assert "docs/nowhere.md: there is no such file" in fault


def test_what_documents_docstrings_and_comments_name_exists() -> None:
    """Paths, modules, members of classes and modules, and identifiers, in the whole tree."""
    files = [*code_files(), *(file for file in DOCUMENTS if file.name != "believed.md")]  # it cites files of others
    sources = {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}
    names = Names(sources.items())
    faults = [
        f"{name}: {missing}"
        for name, source in sources.items()
        for missing in names.missing(prose_of(source, Path(name).suffix), Path(name).suffix)
    ]
    assert len(sources) > 1000 and not faults, "\n".join([*faults, "no such path, name or member"])


TREE = {
    "radar_service/echo/moving.py": '"""Its docstring."""\n\nLIMIT = 3\n\n\nclass Base:\n    step: int\n\n\nclass Echoes(Base):\n'
    '    def cut(self) -> None:\n        """`lost_name` in prose is no name."""\n        self.kept = field.depth\n',
}  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        "`echo/moving.py`, tests/test_docs.py and `radar_service/echo`", "echo.moving.LIMIT, `echo.moving.Echoes.cut`",
        "`Echoes.step` of its base, `Echoes.kept`", "`field.depth` as in code", "numpy.fft, `np`, `json.dumps`", "`cut(of)`",
        "word.md e.g. 3.5",
    ],
)  # fmt: skip
def test_names_that_exist_are_found(text: str) -> None:
    assert list(Names(TREE.items()).missing(text, ".md")) == []


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("`pytest -s tests/gone`", "tests/gone"), ("see `echo/gone.py`", "echo/gone.py"), ("# echo.gone has it", "echo.gone"),
        ("gone.http.websocket counts", "gone.http.websocket"), ("as of `Echoes.gone`", "Echoes.gone"),
        ("`lost_name` is told", "lost_name"), ("`gone()`", "gone"), ("a `GoneClass`", "GoneClass"),
    ],
)  # fmt: skip
def test_names_that_are_gone_are_told(text: str, missing: str) -> None:
    assert list(Names(TREE.items()).missing(text, ".md")) == [missing]


def test_prose_and_code_are_told_apart() -> None:
    source = (
        '"""Of the file."""\nX = """text"""  # why\n\n\ndef f():  # fmt: skip\n    """What it does."""\n    return "# no"\n'
    )
    assert prose_of(source, ".py").split("\n") == ["Of the file.", "What it does.", "# why", "# fmt: skip"]
    assert code(source, ".py") == '\nX = """text"""  \n\n\ndef f():  \n\n    return "# no"\n'
    assert prose_of("a = 1; // why\n/* of\nall */ b('//x')", ".js").split("\n") == ["// why", "/* of", "all */"]


def unwrapped(source: str) -> str:
    """Source with its lines joined, so that a citation that goes over a line's end is whole."""
    return re.sub(r"\s*\n\s*(?:# )?", " ", source)


def test_no_code_cites_a_document_outside_the_repository() -> None:
    outside = [
        f"{file.relative_to(ROOT)}: {result[0]}"
        for file in CODE
        if file != Path(__file__) and MAY_CITE.search(source := file.read_text(encoding="utf-8"))
        for result in OUTSIDE.finditer(unwrapped(source))
    ]
    assert not outside, "\n".join(outside)


def test_the_readme_is_short() -> None:
    readme = text("README.md")
    assert len(readme.splitlines()) <= 200 and len(readme.split()) <= 1800


def test_changes_are_told_in_short() -> None:
    newest_release = text("CHANGELOG.md").split("\n## ")[1]
    for told, most in ((newest_release, 40), *((text(name), 2) for name in FRAGMENTS)):
        lines = told.rstrip().splitlines()
        assert len(lines) <= most and max(map(len, lines)) <= 240, told


def test_the_newest_release_is_the_one_that_is_cited() -> None:
    cited = dict(re.findall(r"^(version|date-released): (.+)$", text("CITATION.cff"), flags=re.M))
    assert text("CHANGELOG.md").split("\n## ")[1].startswith(f"{cited['version']}, {cited['date-released']}\n")


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="systemd-analyze is absent")
def test_the_unit_of_systemd_is_valid_and_its_command_exists(tmp_path: Path) -> None:
    unit = text("docs/deploy/radar.service")
    program, *command = shlex.split(re.search("^ExecStart=(.*)$", unit, flags=re.M)[1])  # type: ignore[index]
    assert parser().parse_args(command).command == "serve"
    (tmp_path / "radar.service").write_text(unit.replace(program, sys.executable))
    told = subprocess.run(["systemd-analyze", "verify", tmp_path / "radar.service"], capture_output=True, text=True)
    assert told.returncode == 0 and "radar.service" not in told.stderr, told.stderr
