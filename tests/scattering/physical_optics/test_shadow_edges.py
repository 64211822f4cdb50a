"""Facets are cut along the edges of shadows: what is visible of them is what the shadow leaves."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.shadow_edges import (
    COARSE,
    SMALLEST,
    sampled,
    visible_parts,
    visible_share,
)

PLATE = np.array([[[0.0, 0, 0], [1.7, 0, 0], [1.7, 0, 1.7]], [[0.0, 0, 0], [1.7, 0, 1.7], [0, 0, 1.7]]])
Floats = NDArray[np.float64]


def visible_area(corners: Floats, visible: object) -> float:
    flags = sampled(corners, np.arange(len(corners)), visible)  # type: ignore[arg-type]
    share = visible_share(flags, False)
    mixed = np.flatnonzero(np.isnan(share))
    parts = visible_parts(corners[mixed], mixed, visible, float(areas(corners).sum()))  # type: ignore[arg-type]
    return float(areas(corners)[share == 1.0].sum() + (areas(parts.corners) * parts.share).sum())


@pytest.mark.parametrize("hidden", [0.0, 0.003, 0.25, 0.6, 0.8, 1.0])
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2])
def test_a_straight_edge_is_found(hidden: float, turn: float) -> None:
    """To 5 cm, over 2.4 m at most; a strip next to an edge or corner may be missed that is thinner than the inset of 0.2 %."""
    way = np.array([np.cos(turn), np.sin(turn)])
    low, high = 0.0, float(way.sum() * 1.7)
    limit = low + hidden * (high - low)

    def visible(points: Floats, triangle: NDArray[np.int64]) -> NDArray[np.bool_]:
        return points[:, [0, 2]] @ way > limit

    grid = (np.arange(2000) + 0.5) / 2000 * 1.7
    exact = np.mean(grid[:, None] * way[0] + grid * way[1] > limit) * 1.7**2
    assert visible_area(PLATE, visible) == pytest.approx(exact, abs=COARSE.precision / 2 * 2.4)


def test_nothing_visible_and_nothing_there() -> None:
    none = visible_parts(np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64), lambda p, t: np.ones(len(p), bool), 1.0)
    assert len(none.corners) == len(none.origin) == 0
    assert visible_area(PLATE, lambda p, t: np.zeros(len(p), bool)) == 0.0


@pytest.mark.parametrize("scale", [1.0, 0.1])
def test_shadows_of_the_body_itself_are_found_to_five_centimetres(scale: float) -> None:
    """On plates of 1.7 m and 0.17 m; searches end there, so a small plate takes fewer samples."""
    asked = []

    def visible(points: Floats, triangle: NDArray[np.int64]) -> NDArray[np.bool_]:
        asked.append(len(points))
        return points[:, 0] > 0.6 * scale

    parts = visible_parts(PLATE * scale, np.arange(2), visible, 2.89 * scale**2)
    seen = float((areas(parts.corners) * parts.share).sum())
    assert seen == pytest.approx(1.1 * 1.7 * scale**2, abs=COARSE.precision / 2 * 1.7 * scale)
    assert COARSE.precision == 0.05 and (sum(asked) > 40) == (scale == 1.0)


def test_facets_too_small_to_matter_count_by_their_share() -> None:
    """Below a millionth of the body's area they are not cut."""
    flags = np.array([[True, True, False, True], [True] * 4, [False] * 4])
    np.testing.assert_array_equal(visible_share(flags, np.array([True, False, True])), [0.75, 1.0, 0.0])
    assert np.isnan(visible_share(flags, False)[0])
    parts = visible_parts(PLATE, np.arange(2), lambda p, t: p[:, 0] > 0.6, 2.0 / SMALLEST)
    assert len(parts.corners) == 2 and ((parts.share > 0.0) & (parts.share < 1.0)).all()
