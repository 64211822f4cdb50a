"""Records of echoes: parts of azimuths, and joined parts."""

import numpy as np
import pytest

from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes, Echoes, concatenated


def weighted(count: int, start: float) -> BeamWeightedEchoes:
    """Echoes over four azimuths."""
    value = start + np.arange(count * 4).reshape(count, 4)
    return BeamWeightedEchoes(
        start + np.arange(count),
        value.astype(np.float32),
        value.astype(np.complex64),
        start + np.arange(count, dtype=np.int64),
    )


def test_a_part_keeps_number_boresight_and_time_together() -> None:
    azimuths = AzimuthTimes(np.arange(7), np.arange(7) * 0.1, np.arange(7) * 0.01)
    part = azimuths.part(2, 5)
    assert part.number.tolist() == [2, 3, 4]
    np.testing.assert_allclose(part.boresight / part.time, 10.0)
    assert (azimuths.middle, part.middle, azimuths.part(0, 1).middle) == (0.03, 0.03, 0.0)
    assert azimuths.part(0, 4).middle == 0.02  # the later of two


@pytest.mark.parametrize("counts", [(), (3,), (0, 2), (2, 0, 3)])
def test_joined_parts_hold_all_echoes_in_order(counts: tuple[int, ...]) -> None:
    parts = [weighted(count, 100.0 * k) for k, count in enumerate(counts)]
    whole = concatenated(parts, 4)
    assert whole.range.shape == (sum(counts),) and whole.amplitude.shape == whole.range_migration.shape == (sum(counts), 4)
    assert (whole.range_migration.dtype, whole.amplitude.dtype) == (np.float32, np.complex64)
    expected = [value for part in parts for value in part.range]
    assert whole.body.tolist() == expected
    if sum(counts) == 5:
        assert [column[0].tolist() for column in whole.chosen(np.array([3]))] == [column[3].tolist() for column in whole]
    assert whole.range.tolist() == expected and whole.amplitude[:, 0].real.tolist() == expected[:0] + [
        float(row[0].real) for part in parts for row in part.amplitude
    ]


def test_echoes_of_unlike_lengths_are_refused() -> None:
    with pytest.raises(AssertionError):
        Echoes(np.zeros(2), np.zeros(2), np.zeros(3, dtype=np.complex128))
