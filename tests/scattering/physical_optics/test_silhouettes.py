"""Silhouettes: which edges of meshes are any, and which of them other shadows cover."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.cast_shadows import CastShadows
from radar_service.scattering.physical_optics.silhouettes import View, ends, is_covered, silhouettes
from tests.scattering.physical_optics.test_cast_shadows import ANTENNA, FLAT, box

SLOPE = np.array([[[-2.0, 100.0, 0.0], [2.0, 100.0, 0.0], [0.0, 100.0, -6.0]]])  # a triangle whose upper side is level


def test_a_box_has_six_silhouettes() -> None:
    """From a point off its corner, three faces of a box are seen and six edges bound them."""
    mesh = box((3.0, 50.0, 1.0), (9.0, 60.0, 4.0))
    planes, offsets = silhouettes(mesh.vertices[mesh.faces] - ANTENNA)
    assert planes.shape == (6, 4, 3) and offsets.shape == (6, 4)


def upper_side() -> Floats:
    """The planes (4, 3) of the level silhouette of a triangle."""
    planes, _ = silhouettes(SLOPE)
    return np.asarray(planes[np.abs(ends(planes)[:, :, 2]).max(axis=1).argmin()])


def shadow(*corners: tuple[float, float]) -> Floats:
    """The planes (1, 4, 3) of a triangle 50 m away with these corners, east and up [m]."""
    return CastShadows(FLAT, np.array([[(east, 50.0, up) for east, up in corners]])).plane


@pytest.mark.parametrize("others, covered", [
    ([], False),
    ([shadow((-3, -1), (3, -1), (0, 5))], True),
    ([shadow((-3, -1), (0, -1), (0, 5))], False),  # its left half
    ([shadow((-3, -1), (0, -1), (0, 5)), shadow((3, -1), (0, -1), (0, 5))], True),  # halves that share a side
    ([shadow((-3, -1), (-0.001, -1), (-0.001, 5)), shadow((3, -1), (0, -1), (0, 5))], False),  # 1 mm between them
    ([shadow((-3, 0), (3, 0), (0, 5))], False),  # stands on it: light ends there below, or does not
    ([shadow((-3, -5), (3, -5), (0, -0.1))], False),  # below it
], ids=["nothing", "one", "half", "both halves", "a gap", "along a side", "below"])  # fmt: skip
def test_a_silhouette_is_covered_where_shadows_lie_on_both_sides_all_along_it(others: list[Floats], covered: bool) -> None:
    assert is_covered(upper_side(), np.concatenate([np.zeros((0, 4, 3)), *others])) is covered


def test_ends_of_silhouettes_are_those_of_their_edges() -> None:
    begin, end = ends(upper_side()[None])[0]
    seen = {tuple(np.round(end / np.linalg.norm(end), 9)) for end in (begin, end)}
    assert seen == {tuple(np.round(corner / np.linalg.norm(corner), 9)) for corner in SLOPE[0, :2]}


def test_a_view_tells_where_directions_point() -> None:
    """To the north a point 100 m ahead, 30 m east and 20 m up lies at 0.3 and 0.2; what does not lie ahead has no bounds."""
    view = View.to(np.array([[-5.0, 80.0, 0.0], [5.0, 120.0, 0.0]]))
    low, high = view.extents(np.array([[[30.0, 100.0, 20.0], [0.0, 10.0, -1.0]], [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]]))
    np.testing.assert_allclose(low, [[0.0, -0.1], [-np.inf, -np.inf]], atol=1e-12)
    np.testing.assert_allclose(high, [[0.3, 0.2], [np.inf, np.inf]], atol=1e-12)
    upright = View.to(np.array([[0.0, 0.0, 7.0]]))
    assert np.isfinite(upright.extents(np.array([[[1.0, 1.0, 9.0]]])).low).all()


def test_extents_overlap_where_they_share_a_point() -> None:
    view = View.to(np.array([[0.0, 1.0, 0.0]]))
    some = view.extents(np.array([[[0.0, 1.0, 0.0], [1.0, 1.0, 1.0]]]))
    others = view.extents(
        np.array([[[1.0, 1.0, 1.0], [2.0, 1.0, 2.0]], [[0.0, 1.0, 1.1], [1.0, 1.0, 2.0]], [[0.5, 1.0, 0.5]] * 2])
    )
    assert some.overlap(others).tolist() == [[True, False, True]]
