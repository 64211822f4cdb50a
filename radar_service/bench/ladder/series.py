"""Ladders of the test bench: a scenario, keys of it, and a value of each key for each rung. Files are TOML."""

import tomllib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from radar_service.bench.scenario import SUFFIX, FrozenTable, Scenario, ScenarioError, file_errors, file_of, load_scenario
from radar_service.scene_file import packaged_folder, put
from radar_service.world import SceneError


class Ladder(FrozenTable):
    """One ladder.

    name: of its file. question, expected, source: in sentences. base: a scenario, packaged or a file beside this one.
    difficulty: what grows, with its unit. values: of it, one a rung, the easiest first.
    metric: what is compared, smaller is better; no value, or one above `worst`, counts as `worst`.
    set: keys of the scenario, with dots, and values for all rungs; of a list of tables, such as bodies, a name, or "*" for each.
    vary: the same, with a list that has a value for each rung.
    folder: of its base, where this is a file. file: its own; None of a packaged one.
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
    file: Annotated[Path | None, Field(exclude=True)] = None

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
        content = base.model_dump() | {"name": name, "folder": base.folder, "file": base.file}
        for key, value in (*self.set.items(), *((key, values[number]) for key, values in self.vary.items())):
            try:
                put(content, key, value, f"{self.name}: {key!r}")
            except SceneError as error:
                raise ScenarioError(str(error)) from None
        with file_errors(Path(self.name)):
            return Scenario(**content)


def ladders() -> dict[str, Path]:
    """Returns the packaged ladders by name."""
    return {path.stem: path for path in sorted((packaged_folder("scenes") / "ladders").glob(f"*{SUFFIX}"))}


def load_ladder(name: str) -> Ladder:
    """Returns a packaged ladder by name, or that of a file. Raises ScenarioError."""
    path = file_of(name, ladders(), "ladder")
    with file_errors(path):
        content = {"name": path.stem, **tomllib.loads(path.read_text(encoding="utf-8")), "folder": path.parent}
        return Ladder(**{**content, "file": path if name.endswith(SUFFIX) else None})
