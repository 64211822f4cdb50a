"""What documents, docstrings and comments name of the code, and whether the tree has it: paths, modules, classes, members, words.

Sources are read by regular expressions, in a second.
"""

import importlib.util
import re
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("radar_service", "clients", "scenes", "tests", "docs", ".github", ".ci")
DOCSTRING = re.compile(r'(\A|:[ \t]*(?:#[^\n]*)?\n)\s*"""(.*?)"""', flags=re.S)  # after what opens a block
COMMENT = {
    ".py": re.compile(r"(?:^|(?<=\s))#[ !].*$", flags=re.M),
    ".toml": re.compile(r"(?:^|(?<=\s))#[ !].*$", flags=re.M),
    **dict.fromkeys((".js", ".c", ".h"), re.compile(r"/\*.*?\*/|(?<![:\"'`])//[^\n]*", flags=re.S)),
}
FENCED = re.compile(r"^```.*?^```$", flags=re.M | re.S)
FILE = (
    r"(?:py|js|mjs|c|h|so|md|toml|json|jsonl|txt|svg|png|jpg|gif|css|html|xml|ini|obj|stl|ply|glb|gltf|tif|npz|zarr|nc|csv|yml"
    r"|mcap|pcap|log|whl|conf|yaml)"
)
PATH = re.compile(rf"(?<![\w/.~*}}{{-])((?:{'|'.join(map(re.escape, FOLDERS))})/[\w./-]*\w)(?![\w{{*]|\.\*)")
SHORT = re.compile(r"`((?:[\w-]+/)*[\w-]+\.(?:py|js|c|h))`")
DOTTED = re.compile(rf"(?<![\w/.'\"@-])([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+)(?![\w/-]|\.{FILE}\b)")
WORD = re.compile(r"`([A-Za-z_]\w*)(\([^`]*\))?`")
TWO_PARTS = re.compile(r"(\w+)(?=\.(\w+))")
ENDING = re.compile(rf"\.{FILE}$")
OUTSIDE = {  # names of others, or of what a reader is to write
    "MyPort", "SimpleEstuary", "managedContainer", "rtcIntersect16", "cProfile", "sped_kn",
    "socket.create_server", "foxglove.CompressedImage", "Client.get_versions", "e.g", "i.e", "n.d", "dddmm.mmm", "ddmm.mmmmm",
    "report.flood", "feed.address", "body.ais", "radars.ID.targets.N", "RLIMIT_AS", "pause_reading", "requestId",
    "my-harbour/land.py", "my_tracker.py", "test_my_tracker.py", "n.E", "hhmmss.ss",
}  # fmt: skip


def code_files() -> list[Path]:
    """All sources: of the package, its clients, the tests and examples, and the files beside them that have comments."""
    found = [
        file
        for folder in ("radar_service", "clients", "tests", "scenes", "docs")
        for ending in COMMENT
        for file in sorted((ROOT / folder).rglob(f"*{ending}"))
        if "node_modules" not in file.parts
    ]
    return [*found, *sorted(ROOT.glob("*.toml")), *sorted(ROOT.glob("*.py"))]


def prose(source: str, ending: str) -> str:
    """The docstrings and comments of a source; a document is prose as a whole."""
    if ending == ".md":
        return source
    found = [match[2] for match in DOCSTRING.finditer(source)] if ending == ".py" else []
    return "\n".join([*found, *COMMENT[ending].findall(_without_docstrings(source, ending))])


def code(source: str, ending: str) -> str:
    """A source without docstrings and comments; of a document its fenced blocks."""
    if ending == ".md":
        return "\n".join(FENCED.findall(source))
    return COMMENT[ending].sub("", _without_docstrings(source, ending))


def _without_docstrings(source: str, ending: str) -> str:
    return DOCSTRING.sub(r"\1", source) if ending == ".py" else source


class Names:
    """What a tree has names for.

    paths: of files and folders, with a slash before each. words: identifiers. pairs: a name and one that follows it after a dot:
    in code, as a module in its folder, or as a member of a class or module.
    """

    def __init__(self, files: Iterable[tuple[str, str]]) -> None:
        """files: path and text of each."""
        self.paths: set[str] = set()
        self.words: set[str] = set()
        self.pairs: set[tuple[str, str]] = set()
        self._bases: dict[str, set[str]] = {}
        for name, source in files:
            parts, ending = name.split("/"), Path(name).suffix
            self.paths |= {"/" + "/".join(parts[: k + 1]) for k in range(len(parts))}
            text = code(source, ending)
            self.words |= set(re.findall(r"[A-Za-z_]\w*", text))
            self.pairs |= set(TWO_PARTS.findall(text))
            if ending == ".py":
                modules = [*parts[:-1], Path(name).stem]
                self.pairs |= set(zip(modules, modules[1:], strict=False))
                self.words |= set(modules)
                self._add_members(modules[-2] if modules[-1] == "__init__" else modules[-1], source)

    def _add_members(self, module: str, source: str) -> None:
        owner = module
        for line in source.splitlines():
            if found := re.match(r"class (\w+)(?:\((.*)\))?", line):
                owner = found[1]
                self._bases.setdefault(owner, set()).update(re.findall(r"\w+", found[2] or ""))
                self.pairs.add((module, owner))
            elif found := re.match(r"(?:async )?def (\w+)|(\w+)\s*[:=]", line):
                owner = module
                self.pairs.add((module, found[1] or found[2]))
            elif owner != module and (found := re.match(r"\s+(?:async )?def (\w+)|    (\w+)\s*[:=]", line)):
                self.pairs.add((owner, found[1] or found[2]))
            if owner != module:
                self.pairs |= {(owner, member) for member in re.findall(r"self\.(\w+)", line)}

    def has(self, name: str) -> bool:
        """Whether a dotted name is of this tree, or of an installed package."""
        parts = name.split(".")
        return all(self._has_pair(*pair) for pair in zip(parts, parts[1:], strict=False)) or _is_installed(parts[0])

    def _has_pair(self, owner: str, member: str) -> bool:
        bases = self._bases.get(owner, set()) - {owner}
        instance = owner.capitalize() if owner.islower() else owner  # `scan.plot` says what a Scan has
        return (
            (owner, member) in self.pairs
            or (instance, member) in self.pairs
            or any(self._has_pair(base, member) for base in bases)
        )

    def missing(self, text: str, ending: str) -> Iterator[str]:
        """What prose names that is not there."""
        for path in PATH.findall(text):
            if not (ROOT / path).exists():
                yield path
        plain = FENCED.sub("", text) if ending == ".md" else text
        for path in SHORT.findall(plain):
            if path not in OUTSIDE and not any(known.endswith("/" + path) for known in self.paths):
                yield path
        for name in DOTTED.findall(plain):
            if not ENDING.search(name) and name not in OUTSIDE and not self.has(name):
                yield name
        for word, call in WORD.findall(plain):
            is_name = "_" in word.strip("_") or call or re.search(r"[a-z][A-Z]", word)
            if is_name and word not in self.words and word not in OUTSIDE:
                yield word


@cache
def _is_installed(package: str) -> bool:
    return package not in FOLDERS and (package in sys.stdlib_module_names or importlib.util.find_spec(package) is not None)
