"""The short modules of records, each under its name."""

import dataclasses
from dataclasses import FrozenInstanceError, replace
from typing import Any

import numpy as np
import pytest

from radar_service.records.cell_sources import (
    MAX_POWERS,
    SourceList,
    SourceRequest,
    joined_powers,
    part_of,
    powers_from_text,
    source_request,
    text_of,
)
from radar_service.records.fidelity import PRESETS, PURPOSE, Fidelity, fidelity_from_name
from radar_service.records.plan_item import PlanItem
from radar_service.records.reports import FeedErrorCounts, Readings
from radar_service.records.spokes import SpokeBlock, joined, regrouped


# plan_item: error and cost of a plan's line as text.
@pytest.mark.parametrize(
    ("known", "text"),
    [
        ({}, ""),
        ({"power_db": 0.468}, "0.47 dB"),
        ({"power_db": 0.0}, "0 dB"),
        ({"field_db": -61.46}, "field -61 dB"),
        ({"microseconds": 5.5612}, "5.56 us"),
        ({"microseconds": 0.0}, "0 us"),
        ({"power_db": 0.2, "field_db": -40.0, "microseconds": 1234.5}, "0.2 dB, field -40 dB, 1.23e+03 us"),
    ],
)
def test_the_price_has_what_is_known(known: dict[str, float], text: str) -> None:
    assert PlanItem("beam", True, "full circle", **known).price() == text


# reports: readings of several spokes, and sums of what happened to them.
COLUMN = np.arange(4.0)
READINGS = Readings(COLUMN, COLUMN + 10, np.stack([COLUMN, COLUMN + 20], axis=1), COLUMN + 30, COLUMN + 40)


def test_a_part_has_the_rows_of_each_column() -> None:
    part = READINGS.part(slice(1, 3))
    assert [column.tolist() for column in part] == [[1, 2], [11, 12], [[1, 21], [2, 22]], [31, 32], [41, 42]]
    assert READINGS.part(2).position.tolist() == [2, 22] and READINGS.part(2).speed == 42


def test_counts_add_up() -> None:
    one = FeedErrorCounts(dropped=1, repeated=2, late=3, out_of_order=4, stuck=5, heading_lost=6)
    assert one.plus(None) is one
    assert vars(one.plus(one)) == {name: 2 * count for name, count in vars(one).items()}


# truth: the records of the ground truth as plain data.


# fidelity: the presets by name and in order.
def test_presets_of_the_engine_grow_finer_in_order() -> None:
    fast, balanced, reference = (PRESETS[name] for name in ("fast", "balanced", "reference"))
    for name in (
        "scatterers_per_cell",
        "kernel_width",
        "beam_extent",
        "bounces",
        "beam_kernel_width",
        "beam_table_oversampling",
    ):
        values = [getattr(preset, name) for preset in (fast, balanced, reference)]
        assert values == sorted(values), name
    assert fast.visibility_step > balanced.visibility_step > reference.visibility_step
    assert np.isinf(reference.beam_extent) and reference.azimuths_per_block == 1
    assert all(PRESETS[name].name == name for name in PRESETS)


def test_balanced_is_the_default() -> None:
    assert fidelity_from_name("balanced") == Fidelity("balanced")


def test_the_documented_preset_alone_is_of_the_printed_engine() -> None:
    assert [name for name, preset in PRESETS.items() if preset.engine == "documented"] == ["documented"]
    assert set(PURPOSE) == set(PRESETS)


@pytest.mark.parametrize("name", ["", "Balanced", "auto", "best"])
def test_an_unknown_name_is_refused_with_the_presets(name: str) -> None:
    with pytest.raises(ValueError, match=f'"{name}" is not one of auto, documented, fast, balanced, reference'):
        fidelity_from_name(name)


def test_a_fidelity_is_changed_by_a_copy_alone() -> None:
    preset = PRESETS["fast"]
    with pytest.raises(FrozenInstanceError):
        preset.bounces = 5  # type: ignore[misc]
    assert replace(preset, bounces=5) != preset and hash(replace(preset)) == hash(preset)


# cell_sources: what is requested of the sources of cells, and what can be told.
NAMES = {0: "noise", 1: "sea", 256: "ferry"}


def test_requests_add_up() -> None:
    one, other = SourceRequest(powers=(256, 1)), SourceRequest(labels=True, powers=(0, 1))
    assert one | other == SourceRequest(True, (0, 1, 256)) and one | SourceRequest(powers="all") == SourceRequest(
        False, "all"
    )
    assert not SourceRequest() and SourceRequest(labels=True) and SourceRequest(powers=(0,))


def test_only_what_can_be_told_and_is_not_told_anyway_is_requested() -> None:
    wanted = SourceRequest(True, (1, 999))
    assert SourceList(NAMES).to_request(wanted) == SourceRequest(True, (1,))
    assert SourceList(NAMES, no_labels="no").to_request(wanted) == SourceRequest(False, (1,))
    assert SourceList(NAMES, no_powers="no").to_request(SourceRequest(True, "all")) == SourceRequest(True)
    assert SourceList(NAMES, on_request=False).to_request(wanted) == SourceRequest()
    assert SourceList(NAMES).as_list()[2] == {"number": 256, "name": "ferry"}


@pytest.mark.parametrize(
    ("sources", "request_", "words"),
    [
        (SourceList(NAMES, no_labels="it is old"), SourceRequest(labels=True), "labels: it is old, or leave labels out"),
        (SourceList(NAMES, no_powers="it is old"), SourceRequest(powers="all"), "powers: it is old, or leave powers out"),
        (SourceList(NAMES), SourceRequest(powers=(1, 7)),
         "powers: 7 is no source of this scene; it has 0 noise, 1 sea, 256 ferry"),
    ],
)  # fmt: skip
def test_what_cannot_be_told_is_refused(sources: SourceList, request_: SourceRequest, words: str) -> None:
    sources.check(SourceRequest())
    with pytest.raises(ValueError, match=words):
        sources.check(request_)


@pytest.mark.parametrize(("text", "powers"), [("", ()), ("all", "all"), ("257,1,257", (1, 257)), ("0", (0,))])
def test_powers_are_read_from_a_text(text: str, powers: Any) -> None:
    assert powers_from_text(text) == powers and powers_from_text(text_of(powers)) == powers


@pytest.mark.parametrize(
    "text", ["ALL", "1,", ",", "-1", "1.5", "one", "1 2", "99999999999", ",".join(["1"] * (MAX_POWERS + 1))]
)
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"^powers: .* is not all, nor 1 to 64 numbers"):
        powers_from_text(text)


@pytest.mark.parametrize("powers", [True, 1.5, -1, [1, "a"], [True], None, "some"])
def test_powers_in_process_are_all_or_numbers(powers: Any) -> None:
    assert source_request(True, [257, 1]) == SourceRequest(True, (1, 257)) and source_request(False, 5).powers == (5,)
    with pytest.raises(ValueError, match=r"^powers: .* is not allowed"):
        source_request(False, powers)


def test_powers_of_blocks_are_cut_and_joined() -> None:
    first, second = np.ones((2, 3), dtype=np.float32), np.full((1, 3), 2, dtype=np.float32)
    whole = joined_powers([({5: first}, (2, 3)), ({4: second, 5: second}, (1, 3))])
    assert list(whole) == [4, 5] and whole[5][:, 0].tolist() == [1, 1, 2] and whole[4][:, 0].tolist() == [0, 0, 2]
    assert part_of(None, 0) is None and part_of(whole, 2)[4].tolist() == [2, 2, 2]  # type: ignore[index]


# spokes: spokes in blocks: cut, joined and regrouped without loss.
def block(first: int, count: int) -> SpokeBlock:
    """Spokes of scan 2, of 40 azimuths and 3 cells; each number tells its spoke and its field."""
    number = np.arange(first, first + count, dtype=np.float64)
    field = (number[:, None] + 1j * np.arange(3)).astype(np.complex64)
    position = np.stack([number + 0.1, number + 0.2], axis=1)
    return SpokeBlock(
        first, 2, first - 80, number, number + 0.3, number + 0.4, position, number + 0.5, number + 0.6,
        np.array([1.0, 2.0, 3.0]), 1.0, field, (np.abs(field) ** 2).astype(np.float32),
    )  # fmt: skip


def same(one: SpokeBlock, other: SpokeBlock) -> bool:
    return all(np.array_equal(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(SpokeBlock))


def test_a_part_is_the_block_of_its_spokes() -> None:
    assert same(block(80, 10).part(3, 7), block(83, 4))


def test_powers_are_cut_and_joined_with_the_spokes() -> None:
    first, second = (
        dataclasses.replace(block(k, 2), powers={256 + k: np.full((2, 3), k, np.float32)}, requests=k) for k in (80, 82)
    )
    assert first.part(1, 2).powers[336].shape == (1, 3) and second.part(0, 1).requests == 82  # type: ignore[index]
    whole = joined([first, second])
    assert whole.powers is not None and list(whole.powers) == [336, 338]
    assert whole.powers[338].tolist() == [[0] * 3, [0] * 3, [82] * 3, [82] * 3]
    assert [spoke.powers[338].tolist() for spoke in second.spokes()] == [[82] * 3] * 2  # type: ignore[index]
    assert second.nbytes == 2 * 3 * (8 + 4 + 4)


@pytest.mark.parametrize("size", [1, 3, 7, 40, 100])
@pytest.mark.parametrize("parts", [(40,), (5, 35), (1, 1, 17, 21)])
def test_regrouping_loses_nothing(parts: tuple[int, ...], size: int) -> None:
    starts = 80 + np.cumsum([0, *parts[:-1]])
    result = list(regrouped((block(int(a), n) for a, n in zip(starts, parts, strict=True)), size))
    assert [len(one) for one in result] == [size] * (40 // size) + ([40 % size] if 40 % size else [])
    assert same(joined(result), block(80, 40))


def test_the_truth_goes_with_its_spokes() -> None:
    plain = block(80, 10)
    wrong = dataclasses.replace(plain, heading=plain.heading + 1.0, true=plain.readings)
    mixed = joined([plain.part(0, 4), wrong.part(4, 7), wrong.part(7, 10)])
    assert mixed.true is not None and plain.true is None
    assert [spoke.heading for spoke in mixed.spokes()] == [80.4 + k + (k >= 4) for k in range(10)]
    for k, spoke in enumerate(wrong.spokes()):
        assert spoke.true is not None and spoke.true.heading == 80.4 + k == mixed.true.heading[k]
    assert next(plain.spokes()).true is None


def test_blocks_are_yielded_as_soon_as_they_are_full() -> None:
    """Two of 5 spokes are there for a block of 8 before a third is taken."""
    taken: list[int] = []

    def blocks() -> object:
        for k in range(3):
            taken.append(k)
            yield block(80 + 5 * k, 5)

    assert len(next(regrouped(blocks(), 8))) == 8 and taken == [0, 1]  # type: ignore[arg-type]


def test_a_block_of_no_spokes_is_refused() -> None:
    with pytest.raises(ValueError, match="size: 0 is not allowed"):
        next(regrouped([block(80, 4)], 0))


def test_spokes_hold_their_rows() -> None:
    whole = block(80, 4)
    for k, spoke in enumerate(whole.spokes()):
        assert (spoke.number, spoke.scan, spoke.index, spoke.time) == (80 + k, 2, k, 80.0 + k)
        assert (spoke.azimuth, spoke.heading, spoke.course, spoke.speed) == (80.3 + k, 80.4 + k, 80.5 + k, 80.6 + k)
        assert spoke.position == (80.1 + k, 80.2 + k)
        assert np.array_equal(spoke.field, whole.field[k]) and np.array_equal(spoke.power, whole.power[k])


def test_shapes_that_do_not_fit_are_refused() -> None:
    whole = block(80, 4)
    for name in ("time", "position", "range", "power"):
        with pytest.raises(AssertionError):
            dataclasses.replace(whole, **{name: getattr(whole, name)[:-1]})
