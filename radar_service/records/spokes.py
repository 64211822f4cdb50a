"""The records that leave the engine: spokes, alone and in blocks."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from radar_service.numerics import Floats, Profiles, Singles
from radar_service.records.cell_sources import Labels, Powers, joined_powers, part_of
from radar_service.records.reports import Readings


@dataclass(frozen=True)
class Spoke:
    """One azimuth's output. All SI and radians; azimuth is the boresight, clockwise from true north, at `time`.

    With errors on purpose azimuth and own ship are as reported, and `true` has the truth; otherwise that is None.
    """

    number: int  # since the start of the simulation; number = scan x azimuths + index
    scan: int
    index: int  # within the scan, 0 points north
    time: float
    azimuth: float
    heading: float  # of own ship
    position: tuple[float, float]  # of own ship, east, north
    course: float
    speed: float
    range: Floats  # (N,) where the samples stand
    field: Profiles  # (N,) sqrt(W), compressed, before detection
    power: Singles  # (N,) W
    true: Readings | None = None
    labels: Labels | None = None  # (N,) number of the strongest source, where labels are requested
    powers: Powers | None = None  # (N,) of each source, where powers are requested


@dataclass(frozen=True)
class SpokeBlock:
    """K consecutive spokes of one scan as arrays, K >= 1: the engine yields them and the stream divides them.

    With errors on purpose azimuth and own ship are as reported, and `true` has the truth; otherwise that is None.
    """

    first: int  # number of the first spoke
    scan: int
    index: int  # index of the first spoke within its scan
    time: Floats  # (K,)
    azimuth: Floats  # (K,)
    heading: Floats  # (K,)
    position: Floats  # (K, 2)
    course: Floats  # (K,)
    speed: Floats  # (K,)
    range: Floats  # (N,)
    range_step: float
    field: Profiles  # (K, N)
    power: Singles  # (K, N)
    commands: int = 0  # that had come when it was computed
    true: Readings | None = None  # (K,) each
    labels: Labels | None = None  # (K, N)
    powers: Powers | None = None  # (K, N) each
    requests: int = 0  # for labels and powers that had come when it was computed

    def __post_init__(self) -> None:
        k, n = self.field.shape
        assert self.labels is None or self.labels.shape == (k, n)
        assert self.power.shape == (k, n) and self.range.shape == (n,) and self.position.shape == (k, 2)
        assert all(a.shape == (k,) for a in (self.time, self.azimuth, self.heading, self.course, self.speed))

    def __len__(self) -> int:
        return len(self.time)

    @property
    def nbytes(self) -> int:
        """Bytes of its cells."""
        arrays = (self.field, self.power, self.labels, *(self.powers or {}).values())
        return sum(array.nbytes for array in arrays if array is not None)

    @property
    def readings(self) -> Readings:
        """Azimuth and own ship as reported."""
        return Readings(self.azimuth, self.heading, self.position, self.course, self.speed)

    def part(self, start: int, stop: int) -> "SpokeBlock":
        """Spokes start to stop (exclusive) of this block, sharing its memory."""
        cut = slice(start, stop)
        return SpokeBlock(
            self.first + start, self.scan, self.index + start, self.time[cut], self.azimuth[cut], self.heading[cut],
            self.position[cut], self.course[cut], self.speed[cut], self.range, self.range_step, self.field[cut],
            self.power[cut], self.commands, None if self.true is None else self.true.part(cut),
            None if self.labels is None else self.labels[cut], part_of(self.powers, cut), self.requests,
        )  # fmt: skip

    def spokes(self) -> Iterator[Spoke]:
        """The spokes one by one."""
        for k in range(len(self)):
            yield Spoke(
                self.first + k, self.scan, self.index + k, float(self.time[k]), float(self.azimuth[k]),
                float(self.heading[k]), (float(self.position[k, 0]), float(self.position[k, 1])),
                float(self.course[k]), float(self.speed[k]), self.range, self.field[k], self.power[k],
                None if self.true is None else self.true.part(k),
                None if self.labels is None else self.labels[k], part_of(self.powers, k),
            )  # fmt: skip


def square_law(field: Profiles) -> Singles:
    """Power [W] of profiles [sqrt(W)] of any shape, in single precision."""
    return np.asarray(field.real**2 + field.imag**2)


def regrouped(blocks: Iterable[SpokeBlock], size: int) -> Iterator[SpokeBlock]:
    """The spokes of one scan in blocks of `size`, the last one maybe shorter. Raises ValueError for a size below 1."""
    if size < 1:
        raise ValueError(f"size: {size} is not allowed; at least 1 spoke per block")
    waiting: list[SpokeBlock] = []
    for block in blocks:
        waiting.append(block)
        while sum(map(len, waiting)) >= size:
            block_of_all = joined(waiting)
            yield block_of_all.part(0, size)
            waiting = [block_of_all.part(size, len(block_of_all))] if len(block_of_all) > size else []
    if waiting:
        yield joined(waiting)


def joined(blocks: list[SpokeBlock]) -> SpokeBlock:
    """Consecutive blocks of one scan as one; labels where all have them."""
    if len(blocks) == 1:
        return blocks[0]

    def array(name: str) -> Any:
        return np.concatenate([getattr(block, name) for block in blocks])

    has_errors = any(block.true is not None for block in blocks)
    powers = [(block.powers or {}, (len(block), len(block.range))) for block in blocks]
    truths = [block.readings if block.true is None else block.true for block in blocks] if has_errors else []
    return replace(
        blocks[0], time=array("time"), azimuth=array("azimuth"), heading=array("heading"), position=array("position"),
        course=array("course"), speed=array("speed"), field=array("field"), power=array("power"),
        true=Readings(*map(np.concatenate, zip(*truths, strict=True))) if truths else None,
        labels=None if any(block.labels is None for block in blocks) else array("labels"),
        powers=None if blocks[0].powers is None else joined_powers(powers),
    )  # fmt: skip
