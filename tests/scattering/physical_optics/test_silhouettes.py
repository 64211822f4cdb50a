"""Silhouettes: which edges of meshes are any, and by the witness which of them other shadows cover."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.cast_shadows import CastShadows, silhouettes
from tests.reference.shadow_witnesses import is_covered
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
    ends = np.cross(planes[:, 1], planes[:, 0]), np.cross(planes[:, 0], planes[:, 2])
    return np.asarray(planes[np.maximum(*(np.abs(end[:, 2]) for end in ends)).argmin()])


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
