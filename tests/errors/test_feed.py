"""What happens to spokes between radar and client. Statistics: bounds of 4.4 standard errors, a level of 1e-5 each."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.errors import feed
from radar_service.errors.feed import FeedArranger, FeedLaw, runs
from radar_service.numerics.types import Flags
from radar_service.records.cell_sources import UNKNOWN
from radar_service.records.spokes import SpokeBlock
from tests.scenes import radar
from tests.spoke_blocks import block_of
from tests.world.test_world import settings

AZIMUTHS = 64
RADAR = radar(azimuths=AZIMUTHS, beamwidth_deg=8, range_max_m=256, rpm=60)
MANY = 40_000


def law(seed: int = 3, key: int = 0, **table: Any) -> FeedLaw:
    feed_errors = settings({"feed": table}).feed
    assert feed_errors is not None
    return FeedLaw(feed_errors, RADAR, seed, key)


def sent(
    rules: FeedLaw | None, scans: int = 4, size: int = 7, arranger: FeedArranger | None = None, first: int = 0
) -> list[int]:
    """Numbers of the spokes that are sent for some scans, in order."""
    arranger, numbers = arranger or FeedArranger(RADAR), list[int]()
    for block in blocks(scans, size, first):
        for part in arranger.arranged(block, rules):
            numbers += [spoke.number for spoke in part.spokes()]
    return numbers


def blocks(scans: int, size: int, first: int = 0) -> list[SpokeBlock]:
    starts = [(scan, index) for scan in range(first, first + scans) for index in range(0, AZIMUTHS, size)]
    return [block_of(scan * AZIMUTHS + index, min(size, AZIMUTHS - index), AZIMUTHS) for scan, index in starts]


@pytest.mark.parametrize(("rate", "flags"), [("drop_rate", "dropped"), ("repeat_rate", "repeated"), ("late_rate", "late"),
                                              ("swap_rate", "swapped")])  # fmt: skip
def test_spokes_are_hit_with_their_probability_and_independently(rate: str, flags: str) -> None:
    hit: Flags = getattr(law(**{rate: 0.2}).decisions(0, MANY), flags)
    error = 4.4 * np.sqrt(0.2 * 0.8 / MANY)
    assert abs(hit.mean() - 0.2) < error
    assert abs((hit[1:] & hit[:-1]).mean() - 0.04) < 4.4 * np.sqrt(0.04 * 1.4 / MANY)  # pairs share spokes: 1 + 2 x 0.2


def test_bursts_drop_as_many_spokes_as_they_last() -> None:
    dropped = law(burst_rate=0.002, burst_spokes=8).decisions(0, MANY).dropped
    edges = np.flatnonzero(np.diff(dropped.astype(int), prepend=0, append=0)).reshape(-1, 2)
    lengths = np.diff(edges, axis=1)[:, 0]
    assert (lengths >= 8).all() and np.count_nonzero(lengths == 8) > 0.9 * len(lengths)
    expected = 1.0 - 0.998**8  # that no burst begins at a spoke or at one of the seven before
    assert dropped.mean() == pytest.approx(expected, abs=4.4 * np.sqrt(8 * expected / MANY))  # eight spokes fall together
    np.testing.assert_array_equal(law(burst_rate=0.002, burst_spokes=8).decisions(777, 100).dropped, dropped[777:877])


def test_decisions_depend_on_seed_radar_and_number_alone() -> None:
    one = law(drop_rate=0.3, late_rate=0.2).decisions(0, 500)
    for value, expected in zip(law(drop_rate=0.3, late_rate=0.2).decisions(123, 100), one, strict=True):
        np.testing.assert_array_equal(value, expected[123:223])
    for other in (law(seed=4, drop_rate=0.3), law(key=9, drop_rate=0.3)):
        assert (other.decisions(0, 500).dropped != one.dropped).any()
    few = law(drop_rate=0.1).decisions(0, 500).dropped  # more errors hit the same spokes, and others
    assert one.dropped[few].all() and one.dropped.sum() > few.sum()


def test_dropped_spokes_are_not_sent_and_repeated_ones_twice_in_a_row() -> None:
    repeated = law(repeat_rate=0.2).decisions(0, 4 * AZIMUTHS).repeated
    assert sent(law(repeat_rate=0.2)) == [n for n in range(4 * AZIMUTHS) for _ in range(1 + int(repeated[n]))]
    rules = law(drop_rate=0.2)
    expected = np.flatnonzero(~rules.decisions(0, 4 * AZIMUTHS).dropped).tolist()
    assert sent(rules) == expected and len(expected) < 4 * AZIMUTHS
    assert sent(law(drop_rate=1)) == []


def test_a_swapped_spoke_follows_the_next_one() -> None:
    rules = law(swap_rate=0.1)
    order, swapped = sent(rules), rules.decisions(0, 4 * AZIMUTHS).swapped
    alone = [
        n
        for n in np.flatnonzero(swapped).tolist()
        if not swapped[max(0, n - 1)] and not swapped[min(n + 1, 255)] and n < 254
    ]
    assert alone and all(order.index(n) == order.index(n + 1) + 1 for n in alone)


def test_a_late_spoke_is_not_swapped_and_a_dropped_one_is_neither() -> None:
    made = law(drop_rate=0.5, late_rate=0.5, swap_rate=0.5, repeat_rate=0.5).decisions(0, 1000)
    assert not (made.late & made.swapped).any() and set(made.delay.tolist()) == {0, 1, 32}
    assert not (made.dropped & (made.late | made.swapped | made.repeated)).any()


def test_a_late_spoke_comes_behind_those_of_its_delay() -> None:
    rules = law(late_rate=0.05, late_s=0.25)  # 16 spokes
    order, late = sent(rules), rules.decisions(0, 4 * AZIMUTHS).late
    for n in np.flatnonzero(late).tolist():
        if n + 16 < 4 * AZIMUTHS and not late[n + 16]:
            assert order.index(n) > order.index(n + 16)
        if n + 16 < 4 * AZIMUTHS - 1 and not late[n + 17]:
            assert order.index(n) < order.index(n + 17)
    missing = set(range(4 * AZIMUTHS)) - set(order)
    assert missing == {n for n in np.flatnonzero(late).tolist() if n + 16 >= 4 * AZIMUTHS}  # they are still to come


@pytest.mark.parametrize("size", [1, 16, 64])
def test_blocks_of_any_size_are_arranged_alike(size: int) -> None:
    rules = law(drop_rate=0.1, burst_rate=0.01, burst_spokes=3, repeat_rate=0.1, late_rate=0.1, swap_rate=0.1)
    assert sent(rules, size=size) == sent(rules, size=7)


def test_late_spokes_come_also_when_the_errors_are_switched_off() -> None:
    rules, arranger = law(late_rate=1, late_s=0.25), FeedArranger(RADAR)
    before = sent(rules, scans=1, arranger=arranger)
    after = sent(None, scans=1, arranger=arranger, first=1)
    assert before == list(range(AZIMUTHS - 16)) and sorted(before + after) == list(range(2 * AZIMUTHS))
    assert sent(None, scans=1, arranger=arranger, first=2) == list(range(2 * AZIMUTHS, 3 * AZIMUTHS))


def test_a_bounded_number_of_spokes_is_late(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feed, "MAX_LATE", 10)
    arranger, rules, spokes = FeedArranger(RADAR), law(late_rate=1, late_s=10), list[SpokeBlock]()
    for block in blocks(3, 16):
        spokes += arranger.arranged(block, rules)
    assert [spoke.first + k for spoke in spokes for k in range(len(spoke))] == list(range(3 * AZIMUTHS - 10))


def test_a_late_spoke_keeps_no_other_spoke_in_memory() -> None:
    arranger, whole = FeedArranger(RADAR), blocks(1, AZIMUTHS)[0]
    arranger.arranged(whole, law(late_rate=1, late_s=1 / AZIMUTHS))  # the last spoke is still to come
    _, late = arranger.arranged(block_of(3 * AZIMUTHS, 1, AZIMUTHS), None)
    assert late.first == AZIMUTHS - 1 and late.power[0, 0] == AZIMUTHS - 1
    assert not np.shares_memory(late.power, whole.power) and not np.shares_memory(late.field, whole.field)


def test_a_stuck_sector_keeps_the_echoes_of_its_first_scan() -> None:
    rules, arranger = law(stuck_sector_deg=[80, 100]), FeedArranger(RADAR)
    stuck = rules.decisions(0, AZIMUTHS).in_stuck_sector
    assert stuck.sum() == 3  # 84.4, 90 and 95.6 degrees
    assert law(stuck_sector_deg=[350, 10]).decisions(0, AZIMUTHS).in_stuck_sector.nonzero()[0].tolist() == [0, 1, 63]
    for block in blocks(3, 16):
        for part in arranger.arranged(block, rules):
            index = part.index + np.arange(len(part))
            expected = np.where(stuck[index], index, part.first + np.arange(len(part)))  # the number of scan 0
            np.testing.assert_array_equal(part.power[:, 0], expected)
            np.testing.assert_array_equal(part.field[:, 0].real, expected)
            np.testing.assert_array_equal(part.time, part.first + np.arange(len(part)))
            assert block.power[0, 0] == block.first  # the engine's own arrays stay
    fresh = arranger.arranged(blocks(1, AZIMUTHS, 3)[0], None)[0]
    np.testing.assert_array_equal(fresh.power[:, 0], 3 * AZIMUTHS + np.arange(AZIMUTHS))
    again = arranger.arranged(blocks(1, AZIMUTHS, 4)[0], rules)[0]
    np.testing.assert_array_equal(again.power[:, 0], 4 * AZIMUTHS + np.arange(AZIMUTHS))


def test_counts_say_what_happened_to_the_spokes() -> None:
    rules = law(
        drop_rate=0.1, repeat_rate=0.1, late_rate=0.1, swap_rate=0.1, stuck_sector_deg=[80, 100], heading_lost_s=[[1, 1.5]]
    )
    made = rules.decisions(AZIMUTHS, AZIMUTHS)
    counts = rules.counts(AZIMUTHS, AZIMUTHS, stuck_from=0)
    assert (counts.dropped, counts.repeated, counts.late, counts.out_of_order) == (
        made.dropped.sum(), made.repeated.sum(), made.late.sum(), made.swapped.sum(),
    )  # fmt: skip
    sector = made.in_stuck_sector & ~made.dropped
    assert counts.stuck == sector.sum() > 0 and rules.counts(AZIMUTHS, AZIMUTHS, stuck_from=30).stuck == 0
    assert counts.heading_lost == (~made.dropped[:32]).sum() and not (made.dropped & (made.repeated | made.late)).any()


def told(block: SpokeBlock, labels: bool = True, powers: bool = True) -> SpokeBlock:
    """The block with labels, and with a source for each spoke, that are the number of the spoke."""
    number = block.first + np.arange(len(block))
    cells = np.repeat(number[:, None], 3, axis=1)
    return replace(
        block, labels=cells.astype(np.uint32) if labels else None,
        powers={256: cells.astype(np.float32), 300 + block.scan: cells.astype(np.float32)} if powers else None,
    )  # fmt: skip


def test_labels_and_powers_go_with_the_echoes_of_a_stuck_sector() -> None:
    """Those of old echoes are not known where nobody had asked for them then."""
    rules, arranger = law(stuck_sector_deg=[80, 100]), FeedArranger(RADAR)
    stuck = rules.decisions(0, AZIMUTHS).in_stuck_sector
    (first,) = arranger.arranged(told(blocks(1, AZIMUTHS)[0]), rules)
    whole = told(blocks(1, AZIMUTHS, 1)[0])
    (second,) = arranger.arranged(whole, rules)
    assert first.labels is not None and second.labels is not None and second.powers is not None and whole.powers is not None
    expected = np.where(stuck, np.arange(AZIMUTHS), AZIMUTHS + np.arange(AZIMUTHS))
    np.testing.assert_array_equal(second.labels[:, 0], expected)
    np.testing.assert_array_equal(second.powers[256][:, 2], expected)
    np.testing.assert_array_equal(second.powers[300][:, 0], np.where(stuck, expected, 0))  # a source of the first scan alone
    np.testing.assert_array_equal(second.powers[301][:, 0], np.where(stuck, 0, expected))
    assert whole.powers[256][16, 0] == AZIMUTHS + 16  # the engine's own arrays stay
    late = FeedArranger(RADAR)
    late.arranged(blocks(1, AZIMUTHS)[0], rules)
    (unknown,) = late.arranged(told(blocks(1, AZIMUTHS, 1)[0]), rules)
    assert unknown.labels is not None and unknown.powers is not None
    assert (unknown.labels[stuck] == UNKNOWN).all() and (unknown.labels[~stuck] != UNKNOWN).all()
    assert np.isnan(unknown.powers[256][stuck]).all() and not np.isnan(unknown.powers[256][~stuck]).any()


def test_late_spokes_keep_their_labels_and_join_no_others() -> None:
    arranger, rules = FeedArranger(RADAR), law(late_rate=1, late_s=1 / AZIMUTHS)
    arranger.arranged(blocks(1, 8)[0], rules)  # the last spoke is still to come, without labels
    parts = arranger.arranged(told(blocks(1, 8)[1]), rules)
    assert [(part.first, part.labels is None) for part in parts][:2] == [(7, True), (8, False)]
    assert parts[1].labels is not None and parts[1].labels[:, 0].tolist() == list(range(8, 8 + len(parts[1])))


def test_runs_join_what_is_consecutive() -> None:
    parts = [block_of(n, 1, AZIMUTHS) for n in (62, 63, 64, 65, 65, 67)]
    assert [(run.first, len(run)) for run in runs(parts)] == [(62, 2), (64, 2), (65, 1), (67, 1)]
