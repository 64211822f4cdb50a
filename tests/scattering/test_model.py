"""The records that models exchange: sectors against every bearing, and echoes whose shapes fit."""

import numpy as np
import pytest

from radar_service.scattering.model import ALL_PATHS, BearingWedge, BodyEchoes

ANTENNA = np.array([100.0, -50.0, 15.0])


@pytest.mark.parametrize("middle", [0.0, 1.0, np.pi, 4.0, 6.2])
@pytest.mark.parametrize("half", [0.05, 1.0, 2.0, 3.1, np.pi])
def test_a_sector_holds_the_bearings_within_it_and_all_that_is_near(middle: float, half: float) -> None:
    rng = np.random.default_rng(1)
    position = ANTENNA + np.stack([*rng.uniform(-500, 500, (2, 3000)), np.zeros(3000)], axis=1)
    east, north, _ = (position - ANTENNA).T
    off = np.abs((np.arctan2(east, north) - middle + np.pi) % (2 * np.pi) - np.pi)
    expected = (off <= half) | (np.hypot(east, north) <= 60)
    np.testing.assert_array_equal(BearingWedge(ANTENNA, middle, half, 60.0).contains(position), expected)


@pytest.mark.parametrize("half", [0.05, 1.0, 2.5])
def test_a_circle_counts_where_a_part_of_it_lies_in_the_sector(half: float) -> None:
    """Against 360 points on each circle's edge, of 1 to 80 m; those that touch by less than a point's spacing are left out."""
    rng = np.random.default_rng(2)
    middle, sector = rng.uniform(-500, 500, (300, 2)), BearingWedge(ANTENNA, 1.0, half, 60.0)
    size, turn = rng.uniform(1, 80, 300), np.linspace(0, 2 * np.pi, 360, endpoint=False)
    position = ANTENNA + np.column_stack([middle, np.zeros(300)])
    counted = sector.contains(position, size)

    def any_part(radius: np.ndarray) -> np.ndarray:
        edge = position[:, None, :2] + radius[:, None, None] * np.stack([np.sin(turn), np.cos(turn)], axis=1)
        flat = np.column_stack([edge.reshape(-1, 2), np.zeros(edge.shape[0] * 360)])
        return np.asarray(sector.contains(flat).reshape(300, 360).any(axis=1) | sector.contains(position))

    assert counted[any_part(size)].all()
    assert not counted[~any_part(size * 1.001)].any()
    assert 10 < counted.sum() < 290 or half > 2


def test_echoes_whose_shapes_do_not_fit_are_refused() -> None:
    good = np.zeros((2, 3)), np.zeros(2, dtype=complex), *np.zeros((2, 2), dtype=np.int64), np.zeros(2)
    assert len(BodyEchoes(*good)) == 2
    for wrong in range(len(good)):
        parts = list(good)
        parts[wrong] = parts[wrong][:1]
        with pytest.raises(AssertionError):
            BodyEchoes(*parts)


def test_echoes_of_points_stand_for_all_paths_and_join_in_order() -> None:
    first, second = (BodyEchoes.of_points(np.full((n, 3), n), np.ones(n, dtype=complex), np.full(n, n)) for n in (2, 3))
    assert (first.path == ALL_PATHS).all() and not first.height_span.any()
    joined = BodyEchoes.joined([first, second])
    assert joined.body.tolist() == [2, 2, 3, 3, 3] and joined.chosen(np.array([1, 2])).position[:, 0].tolist() == [2, 3]
    assert len(BodyEchoes.joined([])) == 0
