"""The runs of a sweep by number: scene, values, seed and radar of each. A run depends on the specification and its number alone.

Radars change fastest, then seeds, then the values of the last key. Radars of one scene, set of values and seed have the same
seed and draws: they see one world.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from radar_service.numerics.random import SWEEP_DRAW, SWEEP_LIST, SWEEP_SEED, generator, name_key
from radar_service.sweep.spec import MAX_RUNS, KeyValues, SweepError, SweepSpec


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
