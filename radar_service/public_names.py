"""Public names of packages, imported at first use."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazily(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Returns `__getattr__` and `__dir__` of a package (PEP 562), for the names that its file imports `if TYPE_CHECKING`."""
    code = ast.parse(Path(sys.modules[package].__file__ or "").read_text(encoding="utf-8"))
    imports = [line for block in code.body if isinstance(block, ast.If) for line in block.body]
    homes = {name.name: line.module for line in imports if isinstance(line, ast.ImportFrom) for name in line.names}

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(homes[name] or package), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted({*vars(sys.modules[package]), *homes})
