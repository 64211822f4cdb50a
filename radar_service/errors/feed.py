"""What happens to spokes between radar and client: dropped, repeated, late, out of order, stuck.

Whether a spoke is dropped, repeated or late depends on the seed and its number alone. A late spoke is sent after the spoke that
is `late` seconds newer, a swapped one after its successor. Old echoes are those of the first scan with that error.
"""

import heapq
import itertools
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radar_service.errors.sensors import draws, is_lost
from radar_service.numerics import FEED, Flags, Floats, Indices
from radar_service.radar import Radar, in_sector
from radar_service.records import UNKNOWN, FeedErrorCounts, Powers, SpokeBlock, joined
from radar_service.world import FeedErrors

MAX_LATE = 4096  # spokes; where more are late, the first ones come sooner
DROP, BURST, REPEAT, LATE, SWAP = range(5)  # columns of the random numbers of a spoke


class Decisions(NamedTuple):
    """What happens to K spokes: flags (K,), and by how many spokes each is late (K,)."""

    dropped: Flags
    repeated: Flags
    late: Flags
    swapped: Flags
    in_stuck_sector: Flags
    delay: Indices


class FeedLaw:
    """Decides by the number of a spoke. seed, radar_key: of the random numbers, one key for each radar."""

    def __init__(self, errors: FeedErrors, radar: Radar, seed: int, radar_key: int = 0) -> None:
        self.errors, self._radar, self._seed, self._key = errors, radar, seed, radar_key
        self._late_spokes = max(1, round(errors.late / radar.spoke_period))

    def decisions(self, first: int, count: int) -> Decisions:
        """Returns what happens to `count` spokes from number `first` on."""
        errors, number = self.errors, first + np.arange(count)
        chance = self._chances(number)
        dropped = (chance[:, DROP] < errors.drop_rate) | self._in_burst(first, count)
        repeated, late, swapped = (
            ~dropped & (chance[:, column] < rate)
            for column, rate in ((REPEAT, errors.repeat_rate), (LATE, errors.late_rate), (SWAP, errors.swap_rate))
        )
        swapped &= ~late
        delay = late * self._late_spokes + swapped.astype(np.int64)
        stuck = np.zeros(count, dtype=np.bool_)
        if errors.stuck_sector is not None:
            stuck = in_sector(self._radar.schedule(number)[0], *errors.stuck_sector)
        return Decisions(dropped, repeated, late, swapped, stuck, delay)

    def counts(self, first: int, count: int, stuck_from: int) -> FeedErrorCounts:
        """Returns what happens to `count` spokes from number `first` on. stuck_from: first spoke with this stuck sector."""
        decisions, number = self.decisions(first, count), first + np.arange(count)
        stuck = decisions.in_stuck_sector & (number >= stuck_from + self._radar.azimuths)
        lost = is_lost(self._radar.schedule(number)[1], self.errors.heading_lost)
        return FeedErrorCounts(
            dropped=int(decisions.dropped.sum()), repeated=int(decisions.repeated.sum()), late=int(decisions.late.sum()),
            out_of_order=int(decisions.swapped.sum()), stuck=int((stuck & ~decisions.dropped).sum()),
            heading_lost=int((lost & ~decisions.dropped).sum()),
        )  # fmt: skip

    def _chances(self, number: Indices) -> Floats:
        """Random numbers (K, 5) of spokes."""
        return draws(number, 5, self._seed, FEED, self._key)

    def _in_burst(self, first: int, count: int) -> Flags:
        """Whether spokes lie in a burst: one begins at them or at one of the spokes before."""
        errors = self.errors
        if not errors.burst_rate:
            return np.zeros(count, dtype=np.bool_)
        begin = max(0, first - errors.burst_spokes + 1)
        begins = self._chances(np.arange(begin, first + count))[:, BURST] < errors.burst_rate
        total = np.concatenate([np.zeros(errors.burst_spokes, dtype=np.int64), np.cumsum(begins)])
        within = total[errors.burst_spokes :] - total[: -errors.burst_spokes]
        return np.asarray(within[first - begin :] > 0)


class FeedArranger:
    """Arranges the spokes of a radar as its clients receive them. Keeps late spokes and old echoes."""

    def __init__(self, radar: Radar) -> None:
        self._radar = radar
        self._sector: tuple[float, float] | None = None
        self._old: dict[int, SpokeBlock] = {}  # by index: spokes of the stuck sector
        self._held: list[tuple[int, int, SpokeBlock]] = []  # a heap: late spokes, each with the number that it follows
        self._count = itertools.count()  # of late spokes: those that follow the same spoke stay in order

    def arranged(self, block: SpokeBlock, law: FeedLaw | None) -> list[SpokeBlock]:
        """Returns what is sent when the spokes of a block are due: blocks of consecutive spokes, in order.

        law: of the errors in force; None for none. Spokes that are late still come.
        """
        sector = law.errors.stuck_sector if law else None
        if sector != self._sector:
            self._sector = sector
            self._old.clear()
        if law is None:
            return self._with_held(block, [True] * len(block)) if self._held else [block]
        decisions = law.decisions(block.first, len(block))
        block = self._with_old_echoes(block, decisions.in_stuck_sector)
        if not self._held and not (decisions.dropped | decisions.repeated | (decisions.delay > 0)).any():
            return [block]
        for k in np.flatnonzero(decisions.delay).tolist():
            for _ in range(1 + int(decisions.repeated[k])):
                late = _with_copied_echoes(block.part(k, k + 1))  # else the whole block would stay in memory
                heapq.heappush(self._held, (block.first + k + int(decisions.delay[k]), next(self._count), late))
        passes = ~decisions.dropped & (decisions.delay == 0)
        return self._with_held(block, passes.tolist(), decisions.repeated.tolist())

    def _with_held(self, block: SpokeBlock, passes: list[bool], repeated: list[bool] | None = None) -> list[SpokeBlock]:
        """The spokes of a block that pass now, and after each those that follow it."""
        sent: list[SpokeBlock] = []
        for k in range(len(block)):
            if passes[k]:
                sent += [block.part(k, k + 1)] * (2 if repeated and repeated[k] else 1)
            while self._held and (self._held[0][0] <= block.first + k or len(self._held) > MAX_LATE):
                sent.append(heapq.heappop(self._held)[2])
        return list(runs(sent))

    def _with_old_echoes(self, block: SpokeBlock, in_sector: Flags) -> SpokeBlock:
        """The block with old echoes in the stuck sector; the first echoes there are kept."""
        rows = np.flatnonzero(in_sector).tolist()
        if not rows:
            return block
        stuck = _with_copied_echoes(block)
        for k in rows:
            old = self._old.setdefault(block.index + k, _with_copied_echoes(block.part(k, k + 1)))
            stuck.field[k], stuck.power[k] = old.field[0], old.power[0]
            if stuck.labels is not None:
                stuck.labels[k] = UNKNOWN if old.labels is None else old.labels[0]
            if stuck.powers is not None:
                stuck = replace(stuck, powers=_with_old_powers(stuck.powers, old.powers, k, stuck.power.shape))
        return stuck


def _with_copied_echoes(block: SpokeBlock) -> SpokeBlock:
    """The block with echoes of its own, which may be changed."""
    labels = None if block.labels is None else block.labels.copy()
    powers = None if block.powers is None else {number: power.copy() for number, power in block.powers.items()}
    return replace(block, field=block.field.copy(), power=block.power.copy(), labels=labels, powers=powers)


def _with_old_powers(powers: Powers, old: Powers | None, k: int, shape: tuple[int, ...]) -> Powers:
    """Powers (K, N) of their own, with those of one old spoke (1, N) in row k; NaN where they are not known."""
    result = dict(powers)
    for number in (old or {}).keys() - result.keys():
        result[number] = np.zeros(shape, dtype=np.float32)
    for number, power in result.items():
        power[k] = np.nan if old is None else old[number][0] if number in old else 0.0
    return result


def runs(spokes: Iterable[SpokeBlock]) -> Iterator[SpokeBlock]:
    """Joins neighbouring blocks whose spokes are consecutive, of one scan, and tell the same of their sources."""
    waiting: list[SpokeBlock] = []
    for spoke in spokes:
        if waiting and not _continues(waiting[-1], spoke):
            yield joined(waiting)
            waiting = []
        waiting.append(spoke)
    if waiting:
        yield joined(waiting)


def _continues(block: SpokeBlock, other: SpokeBlock) -> bool:
    alike = (block.labels is None, block.powers is None) == (other.labels is None, other.powers is None)
    return alike and (other.scan, other.first) == (block.scan, block.first + len(block))
