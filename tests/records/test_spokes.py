"""Spokes in blocks: cut, joined and regrouped without loss."""

import dataclasses

import numpy as np
import pytest

from radar_service.records.spokes import SpokeBlock, joined, regrouped


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
