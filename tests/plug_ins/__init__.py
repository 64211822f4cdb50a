"""Parts of other packages: tiny ones in `packages`, installed as anybody's; here, how a test adds a part in its own process."""

from functools import cache
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from radar_service import plug_ins

PARTS: dict[str, Any] = {}


def __getattr__(name: str) -> Any:
    """What an entry point of `join` names."""
    try:
        return PARTS[name]
    except KeyError:
        raise AttributeError(name) from None


def join(monkeypatch: pytest.MonkeyPatch, group: str, name: str, part: Any) -> None:
    """Adds a part to a group, or takes the place of one, until the test ends. part: or the module that is one, by name."""
    monkeypatch.setitem(PARTS, f"{group}_{name}", part)
    value = part if isinstance(part, str) else f"{__name__}:{group}_{name}"
    known, key = plug_ins.groups(), f"radar_service.{group}"
    mine = dict(sorted({**known.get(key, {}), name: [EntryPoint(name, value, key)]}.items()))
    monkeypatch.setattr(plug_ins, "groups", lambda: {**known, key: mine})
    for name in ("part_or_error", "working"):
        monkeypatch.setattr(plug_ins, name, cache(getattr(plug_ins, name).__wrapped__))
