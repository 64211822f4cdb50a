"""The specification of a sweep: a TOML file with scenes, values to vary, seeds, and what is kept; and its runs by number.

Radars change fastest, then seeds, then the values of the last key. Radars of one scene, set of values and seed see one world.
"""

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError, WithJsonSchema, field_validator, model_validator

from radar_service.bench.scenario import FrozenTable, PlotSettings
from radar_service.numerics import SWEEP_DRAW, SWEEP_LIST, SWEEP_SEED, generator, name_key
from radar_service.records import PRESETS
from radar_service.terminal import UsageError

MAX_VALUES = 100_000  # of one key
MAX_RUNS = 1_000_000  # each is a chunk of each array, and file systems have folders of so many files
Number = Annotated[float, Field(strict=True)]
Bounds = tuple[Number, Number]
Kept = Literal["video", "power", "field", "labels", "own_ship", "truth", "plots"]
SHAPES = ("range", "uniform", "log_uniform", "normal", "integers", "choice")  # of Values


class SweepError(UsageError):
    """A sweep that cannot run. The text names the key, the value and the remedy."""


class KeyValues(FrozenTable):
    """Values of a key, in place of a list of them: one of the first six keys.

    range: from and to; `count` values, evenly, both ends among them.
    uniform: from and to; drawn evenly. log_uniform: the same of the logarithm.
    normal: mean and standard deviation.
    integers: from and to; whole numbers, both ends among them.
    choice: values to draw from.
    count: of values that are drawn once, and crossed as a list is; without it each run draws its own.
    """

    range: Bounds | None = None
    uniform: Bounds | None = None
    log_uniform: Bounds | None = None
    normal: Bounds | None = None
    integers: tuple[int, int] | None = None
    choice: Annotated[tuple[Any, ...], Field(min_length=1, max_length=MAX_VALUES)] | None = None
    count: Annotated[int, Field(strict=True, ge=1, le=MAX_VALUES)] | None = None

    @property
    def shape(self) -> str:
        """Which of the first six keys it has."""
        return next(name for name in SHAPES if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _check(self) -> Self:
        given = [name for name in SHAPES if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"give one of {', '.join(SHAPES)}; there are {len(given)}")
        first, second = getattr(self, given[0])[:2] if given[0] != "choice" else (0.0, 1.0)
        if self.shape == "range" and (self.count is None or self.count < 2):
            raise ValueError("range: it needs a count of 2 or more; add count = 5")
        if self.shape == "normal" and second <= 0.0:
            raise ValueError(f"normal: a standard deviation of {second:g} is not allowed; give one above 0")
        if self.shape in ("range", "uniform", "log_uniform", "integers") and not first < second:
            raise ValueError(f"{self.shape}: {first:g} is not below {second:g}; give the lower bound first")
        if self.shape == "log_uniform" and first <= 0.0:
            raise ValueError(f"log_uniform: {first:g} is not allowed; give bounds above 0")
        return self


Listed = tuple[Any, ...]
AnyValues = Annotated[
    Annotated[KeyValues, Tag("table")] | Annotated[Listed, Tag("list")],
    Discriminator(lambda values: "table" if isinstance(values, Mapping | KeyValues) else "list"),
]


ONE_OR_MORE = {
    "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": 1000}]
}


class SweepSpec(FrozenTable):
    """One sweep.

    scene: one or several: packaged scenes by name, or files beside this one.
    vary: keys of scenes with dots, as "radar.rpm" or "body.ferry.speed_kn", each with a list of values, or with Values.
    zip: whether lists of `vary` go together, value by value, in place of each with each.
    seeds: runs of each set of values; each has a seed of its own.
    seed: of the sweep, from which those of the runs and all draws come.
    scans: of each run.
    radars: ids; by default the first radar of each scene.
    fidelity: of the simulation.
    keep: what of each run.
    bins: range bins of each spoke, in which the strongest cell counts; by default all cells.
    scans_per_chunk: by default all of a run, up to 64 MiB of an array.
    max_crossings: of bodies in a scan; by default twice the number of bodies.
    plots: how plots are extracted.
    """

    scene: Annotated[tuple[str, ...], Field(min_length=1, max_length=1000), WithJsonSchema(ONE_OR_MORE)]
    vary: Mapping[str, AnyValues] = {}
    zip: bool = False
    seeds: Annotated[int, Field(strict=True, ge=1, le=MAX_RUNS)] = 1
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = 0
    scans: Annotated[int, Field(strict=True, ge=1, le=100_000)] = 1
    radars: Annotated[tuple[str, ...], Field(max_length=100)] = ()
    fidelity: str = "auto"
    keep: Annotated[tuple[Kept, ...], Field(min_length=1)] = ("video",)
    bins: Annotated[int, Field(strict=True, ge=1, le=100_000)] | None = None
    scans_per_chunk: Annotated[int, Field(strict=True, ge=1)] | None = None
    max_crossings: Annotated[int, Field(strict=True, ge=1, le=100_000)] | None = None
    plots: PlotSettings = PlotSettings()

    @field_validator("scene", mode="before")
    @classmethod
    def _one_scene(cls, scene: Any) -> Any:
        return (scene,) if isinstance(scene, str) else scene

    @field_validator("vary", mode="before")
    @classmethod
    def _with_dots(cls, vary: Any) -> Any:
        return _flat(vary) if isinstance(vary, Mapping) else vary

    @field_validator("fidelity")
    @classmethod
    def _known(cls, fidelity: str) -> str:
        if fidelity not in ("auto", *PRESETS):
            raise ValueError(f"{fidelity!r} is none; give auto, {', '.join(PRESETS)}")
        return fidelity

    @field_validator("vary")
    @classmethod
    def _check_values(cls, vary: Mapping[str, KeyValues | Listed]) -> Mapping[str, KeyValues | Listed]:
        for key, values in vary.items():
            listed = (values.choice or ()) if isinstance(values, KeyValues) else values
            if not isinstance(values, KeyValues) and not 1 <= len(values) <= MAX_VALUES:
                raise ValueError(f"{key!r} has {len(values)} values; give 1 to {MAX_VALUES}")
            if not all(map(_is_plain, listed)):
                raise ValueError(
                    f"{key!r} has a value that is no finite number, text, truth value, or list or table of these"
                )
        return vary

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("scene", "radars", "keep"):
            if len(set(getattr(self, name))) < len(getattr(self, name)):
                raise ValueError(f"{name}: one of them occurs twice; give each once")
        if self.fidelity == "documented" and "labels" in self.keep:
            raise ValueError("keep: the fidelity documented has no labels; choose another fidelity, or leave labels out")
        return self


def _flat(vary: Mapping[str, Any]) -> dict[str, Any]:
    """Keys with dots, also where TOML has made tables of them because they have no quotes."""
    result: dict[str, Any] = {}
    for key, values in vary.items():
        if isinstance(values, Mapping) and not values.keys() & {*SHAPES, "count"}:
            result |= {f"{key}.{below}": value for below, value in _flat(values).items()}
        else:
            result[key] = values
    return result


def _is_plain(value: Any) -> bool:
    """Whether a value is plain data of a scene file, and finite."""
    if isinstance(value, Mapping):
        return all(map(_is_plain, value.values()))
    if isinstance(value, list | tuple):
        return all(map(_is_plain, value))
    return isinstance(value, str | bool | int) or (isinstance(value, float) and math.isfinite(value))


def load_spec(path: Path) -> SweepSpec:
    """Returns the specification in a TOML file. Raises SweepError."""
    try:
        return SweepSpec(**tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise SweepError(f"{path}: {error.strerror}; give the TOML file of a sweep") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SweepError(f"{path}: {error}; correct the file") from None
    except ValidationError as error:
        lines = dict.fromkeys(
            f"{path}: {_location(e['loc'])}{e['msg'].removeprefix('Value error, ')}; correct the key" for e in error.errors()
        )
        raise SweepError("\n".join(lines)) from None
    except TypeError as error:  # a key that is no name of Python
        raise SweepError(f"{path}: {error}; correct the key") from None


def _location(steps: tuple[int | str, ...]) -> str:
    """A key of the file, without the name of the form that values have."""
    named = steps[:2] + steps[3:] if steps[:1] == ("vary",) else steps
    return f"{'.'.join(map(str, named))}: " if named else ""


def json_schema() -> dict[str, Any]:
    """Returns the JSON Schema (draft 2020-12) of the specification of a sweep."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **SweepSpec.model_json_schema()}


@dataclass(frozen=True)
class SweepRun:
    """One run.

    number: from 0.
    scene: number of its scene in the specification.
    values: by key.
    seed: of the simulation.
    radar: id; None for the first radar of the scene.
    """

    number: int
    scene: int
    values: Mapping[str, Any]
    seed: int
    radar: str | None


class Runs(Sequence[SweepRun]):
    """All runs of a specification, each made when it is asked for."""

    def __init__(self, spec: SweepSpec) -> None:
        """Raises SweepError for more than MAX_RUNS, and for lists of different lengths that go together."""
        self.spec = spec
        self._radars: tuple[str | None, ...] = spec.radars or (None,)
        self._lists = {key: _listed(spec, key, values) for key, values in spec.vary.items()}
        lengths = {key: len(values) for key, values in self._lists.items() if values is not None}
        if spec.zip and len(set(lengths.values())) > 1:
            raise SweepError(f"zip: lists that go together are equally long; here {lengths}: make them so, or remove zip")
        crossed = {"vary": next(iter(lengths.values()), 1)} if spec.zip else lengths
        self.shape = (len(spec.scene), *crossed.values(), spec.seeds, len(self._radars))
        if len(self) > MAX_RUNS:
            sizes = {"scene": len(spec.scene), **crossed, "seeds": spec.seeds, "radars": len(self._radars)}
            factors = " x ".join(f"{count} of {name}" for name, count in sizes.items() if count > 1)
            raise SweepError(f"{math.prod(self.shape)} runs ({factors}) are not allowed; {MAX_RUNS} at most: vary less")

    def __len__(self) -> int:
        return min(math.prod(self.shape), 2**62)  # of what is refused len() takes no more

    def __getitem__(self, number: Any) -> Any:
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(len(self)))]
        if not -len(self) <= number < len(self):
            raise IndexError(f"run {number} of {len(self)}")
        number = int(number) % len(self)
        scene, *positions, _, radar = (int(k) for k in np.unravel_index(number, self.shape))
        group = number // len(self._radars)
        seed = int(generator(self.spec.seed, SWEEP_SEED, group).integers(2**63))
        return SweepRun(number, scene, self._values(positions, group), seed, self._radars[radar])

    @cached_property
    def drawn(self) -> tuple[str, ...]:
        """The keys of which each run draws its own value."""
        return tuple(key for key, values in self._lists.items() if values is None)

    def corners(self) -> list[SweepRun]:
        """Returns runs that have, between them, each scene, each radar, each listed value, and the first draws."""
        firsts = [0] * len(self.shape)
        numbers = {0, len(self) - 1}
        for axis, count in enumerate(self.shape):
            numbers |= {
                int(np.ravel_multi_index((*firsts[:axis], k, *firsts[axis + 1 :]), self.shape))
                for k in range(min(count, 1000))
            }
        return [self[number] for number in sorted(numbers)]

    def _values(self, positions: Sequence[int], group: int) -> dict[str, Any]:
        """The values of a run, of lists those at these positions."""
        listed = [key for key in self._lists if self._lists[key] is not None]
        at = dict(zip(listed, list(positions) * len(listed) if self.spec.zip else positions, strict=False))
        return {
            key: _draw(self.spec, key, SWEEP_DRAW, group)[0] if values is None else values[at[key]]
            for key, values in self._lists.items()
        }


def _listed(spec: SweepSpec, key: str, values: KeyValues | tuple[Any, ...]) -> Sequence[Any] | None:
    """The values that are crossed; None where each run draws its own."""
    if not isinstance(values, KeyValues):
        return values
    if values.range is not None:
        numbers: list[float] = np.linspace(*values.range, values.count or 2).tolist()
        return numbers
    return None if values.count is None else _draw(spec, key, SWEEP_LIST, 0, values.count)


def _draw(spec: SweepSpec, key: str, purpose: int, group: int, count: int = 1) -> list[Any]:
    """Values drawn for a key, which depend on the seed of the sweep, the key, and what they are for."""
    values, rng = spec.vary[key], generator(spec.seed, purpose, group, name_key(key))
    assert isinstance(values, KeyValues)
    if values.choice is not None:
        return [values.choice[k] for k in rng.integers(len(values.choice), size=count)]
    if values.integers is not None:
        return [int(k) for k in rng.integers(values.integers[0], values.integers[1], size=count, endpoint=True)]
    if values.normal is not None:
        return [float(x) for x in rng.normal(*values.normal, size=count)]
    if values.log_uniform is not None:
        return [
            math.exp(x) for x in rng.uniform(math.log(values.log_uniform[0]), math.log(values.log_uniform[1]), size=count)
        ]
    return [float(x) for x in rng.uniform(*(values.uniform or (0.0, 1.0)), size=count)]
