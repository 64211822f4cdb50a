"""Ladders of the test bench: a scenario, keys of it, and a value of each key for each rung. Files are TOML."""

import tomllib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from radar_service.bench.scenario import SUFFIX, Scenario, ScenarioError, Table, file_errors, load_scenario
from radar_service.scene_file.document import packaged_folder

EVERY = "*"  # each table of a list


class Ladder(Table):
    """One ladder.

    name: of its file. question, expected, source: in sentences. base: a scenario, packaged or a file beside this one.
    difficulty: what grows, with its unit. values: of it, one a rung, the easiest first.
    metric: what is compared, smaller is better; no value, or one above `worst`, counts as `worst`.
    set: keys of the scenario, with dots, and values for all rungs; of a list of tables, such as bodies, a name, or "*" for each.
    vary: the same, with a list that has a value for each rung.
    folder: of its base, where this is a file.
    """

    name: str = Field(min_length=1)
    question: str = Field(min_length=1)
    expected: str = Field(min_length=1)
    source: str = Field(min_length=1)
    base: str = Field(min_length=1)
    difficulty: str = Field(min_length=1)
    values: Annotated[tuple[float | str, ...], Field(min_length=2, max_length=50)]
    metric: str = "ospa_m"
    worst: Annotated[float, Field(gt=0)] = 200.0
    set: Mapping[str, Any] = {}
    vary: Annotated[Mapping[str, tuple[Any, ...]], Field(min_length=1)]
    folder: Annotated[Path | None, Field(exclude=True)] = None

    @model_validator(mode="after")
    def _one_value_a_rung(self) -> "Ladder":
        for key, values in self.vary.items():
            if len(values) != len(self.values):
                raise ValueError(f"vary: {key!r} has {len(values)} values for {len(self.values)} rungs")
        return self

    @cached_property
    def rungs(self) -> tuple[Scenario, ...]:
        """The scenario of each rung. Raises ScenarioError."""
        beside = self.folder is not None and self.base.endswith(SUFFIX)
        base = load_scenario(str(self.folder / self.base) if beside and self.folder else self.base)
        return tuple(self._rung(base, number) for number in range(len(self.values)))

    def _rung(self, base: Scenario, number: int) -> Scenario:
        name = f"{self.name}-{number + 1}"
        content = base.model_dump() | {"name": name, "folder": base.folder}
        for key, value in (*self.set.items(), *((key, values[number]) for key, values in self.vary.items())):
            _put(content, key, value, f"{self.name}: {key!r}")
        with file_errors(Path(self.name)):
            return Scenario(**content)


def ladders() -> dict[str, Path]:
    """Returns the packaged ladders by name."""
    return {path.stem: path for path in sorted((packaged_folder("scenes") / "ladders").glob(f"*{SUFFIX}"))}


def load_ladder(name: str) -> Ladder:
    """Returns a packaged ladder by name, or that of a file. Raises ScenarioError."""
    packaged = ladders()
    path = Path(name) if name.endswith(SUFFIX) else packaged.get(name)
    if path is None:
        raise ScenarioError(f"{name}: there is no such ladder; there are {', '.join(packaged)}, or give a {SUFFIX} file")
    with file_errors(path):
        return Ladder(**{"name": path.stem, **tomllib.loads(path.read_text(encoding="utf-8")), "folder": path.parent})


def _put(content: dict[str, Any], key: str, value: Any, location: str) -> None:
    """Puts a value where a key with dots says. location: that an error begins with. Raises ScenarioError."""
    *path, last = key.split(".")
    tables: list[Any] = [content]
    for step in path:
        tables = [below for table in tables for below in _below(table, step, location)]
    for table in tables:
        if not isinstance(table, dict):
            raise ScenarioError(
                f"{location}: {last!r} is a key of each table of a list; write the name of one, or {EVERY}, before it"
            )
        table[last] = value


def _below(table: Any, step: str, location: str) -> list[Any]:
    """What a step of a key leads to: of a list the tables of this name; of a table its key, which is made where it is absent."""
    if isinstance(table, list):
        named = [each for each in table if step in (EVERY, each.get("name"))]
        if not named:
            there = ", ".join(str(each.get("name")) for each in table)
            raise ScenarioError(f"{location}: there is no {step!r}; there are {there}, or write {EVERY} for each")
        return named
    if table.get(step) is None:
        table[step] = {}
    if not isinstance(table[step], dict | list):
        raise ScenarioError(f"{location}: {step!r} is no table; correct the key")
    return [table[step]]
