"""Points of a surface by hand: evenly over the faces, along an outline, and in columns between corners."""

import numpy as np
import pytest

from radar_service.truth.surface_points import (
    FACE_POINTS,
    MAX_CORNERS,
    PLAN_CELLS,
    ROWS,
    Surface,
    column_points,
    columns,
    ends_at_edges,
    ends_at_outline,
    outermost,
    outline,
    viewed,
)
from radar_service.world.body import Mesh
from radar_service.world.shapes import shape_mesh

FLAT = np.inf  # radius of the earth [m]
ANTENNA = np.array([0.0, 0.0, 15.0])
BOX = shape_mesh("box", {"length_m": 10.0, "width_m": 40.0, "height_m": 6.0})
FAR = np.array([0.0, 500.0, 0.0])  # its near face is 495 m off


def hills() -> Mesh:
    """A sheet of 100 x 120 m with 90 x 90 corners, and heights drawn at random."""
    x, y = np.meshgrid(np.linspace(0.0, 100.0, 90), np.linspace(0.0, 120.0, 90))
    z = np.random.default_rng(3).uniform(0.0, 30.0, x.shape)
    index = np.arange(90 * 90).reshape(90, 90)
    faces = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, :-1]], axis=-1).reshape(-1, 3)
    return Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), faces)


def test_points_of_faces_lie_in_them_evenly() -> None:
    """A box has 512: of each face its share of the area, to the two that a sample at its edges may be off."""
    position, triangle = Surface(BOX).faces
    a, b, c = BOX.vertices[BOX.faces[triangle]].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    assert np.einsum("ij,ij->i", position - a, normal) == pytest.approx(0.0, abs=1e-9)  # rounding of 40 m x 240 m^2
    assert (position >= BOX.vertices.min(axis=0) - 1e-12).all() and (position <= BOX.vertices.max(axis=0) + 1e-12).all()
    area = np.linalg.norm(np.cross(*(BOX.vertices[BOX.faces[:, i]] - BOX.vertices[BOX.faces[:, 0]] for i in (1, 2))), axis=1)
    assert np.bincount(triangle, minlength=12) == pytest.approx(FACE_POINTS * area / area.sum(), abs=2)


def test_outermost_points_of_a_box_are_its_upper_corners_and_more() -> None:
    assert {(20.0, 5.0, 6.0), (-20.0, 5.0, 6.0), (20.0, -5.0, 6.0), (-20.0, -5.0, 6.0)} <= {*map(tuple, outermost(BOX))}


def test_corners_of_a_fine_mesh_are_the_highest_of_each_cell() -> None:
    mesh = hills()
    corners = Surface(mesh).corners
    assert len(corners) <= MAX_CORNERS < len(mesh.vertices)
    assert corners[:, 2].max() == mesh.vertices[mesh.faces.ravel(), 2].max()
    cell = (mesh.vertices[:, :2] / [100.0, 120.0] * PLAN_CELLS).astype(int) == [20, 30]
    inside = mesh.vertices[cell.all(axis=1)]
    assert inside[:, 2].max() in corners[:, 2]


def test_an_outline_has_the_highest_and_the_nearest_points() -> None:
    """Of 400 points at random: the one with the greatest rise over distance, and the nearest."""
    points = np.random.default_rng(4).uniform([-50, 400, 0], [50, 500, 10], (400, 3))
    which = outline(viewed(points, ANTENNA, FLAT, 0.0))
    rise = (points[:, 2] - 15.0) / np.hypot(points[:, 0], points[:, 1])
    assert {int(np.argmax(rise)), int(np.argmin(np.hypot(points[:, 0], points[:, 1])))} <= {*which.tolist()}
    assert len(which) <= 256


def test_a_view_by_hand() -> None:
    """1 km to the east of an antenna 15 m high, over an earth of 8500 km: 58.8 mm below a flat one."""
    view = viewed(np.array([[1000.0, 0.0, 20.0]]), ANTENNA, 8.5e6, np.pi / 2)
    assert (view.azimuth[0], view.distance[0]) == pytest.approx((0.0, 1000.0), abs=1e-12)
    assert view.slope[0] == pytest.approx((5.0 - 1e6 / 17e6) / 1000.0, rel=1e-12)


def test_a_column_stands_in_each_opening_between_others() -> None:
    """Corners at -3, -2.99 and 7 m, 400 m off, and one behind the box, which opens nothing."""
    own = viewed(BOX.vertices + FAR, ANTENNA, FLAT, 0.0)
    others = np.array([[-3.0, 400, 5], [-2.99, 400, 5], [7.0, 400, 5], [9.0, 700, 5]])
    middles, sides = columns(own, viewed(others, ANTENNA, FLAT, 0.0))
    edge = np.array([own.azimuth.min(), *np.arctan2([-3.0, -2.99, 7.0], 400.0), own.azimuth.max()])
    assert np.sort(middles[:4]) == pytest.approx((edge[1:] + edge[:-1]) / 2.0)
    assert len(sides) == 8 and len(middles) == 4 + 16


def test_columns_end_at_the_top_and_at_the_bottom_of_a_box() -> None:
    """At an azimuth its face is cut at 495 m north, its back at 505 m; the top of the back rises most, seen from above."""
    azimuth = np.array([0.0, 0.02, 0.5])
    low, high = ends_at_edges(Surface(BOX).edges + FAR, ANTENNA, FLAT, azimuth)
    cosine = np.cos(azimuth[:2])
    assert low[:2] == pytest.approx(-15.0 / (495.0 / cosine)) and high[:2] == pytest.approx(-9.0 / (505.0 / cosine))
    assert np.isnan(low[2]) and np.isnan(high[2])


def test_columns_of_a_fine_mesh_end_at_its_outline() -> None:
    """A half disc of 2,000 corners, 50 m high, 1 km off: between its corners its outline is a straight line, 0.1 % too low."""
    angle = np.linspace(0.0, np.pi, 2000)
    points = np.stack([50.0 * np.cos(angle), np.full(2000, 1000.0), 15.0 + 50.0 * np.sin(angle)], axis=1)
    azimuth = np.arctan2(np.array([-30.0, 0.0, 14.0]), 1000.0)
    low, high = ends_at_outline(viewed(points, ANTENNA, FLAT, 0.0), azimuth)
    distance = np.hypot(1000.0, [-30.0, 0.0, 14.0])
    assert high == pytest.approx(np.sqrt(2500.0 - np.array([900.0, 0.0, 196.0])) / distance, rel=1e-3)


def test_points_of_columns_lie_on_lines_of_sight() -> None:
    """At ROWS between the ends, 600 m off, where a curved earth has fallen by 600^2 / 2 ae."""
    ends = np.array([-0.03, np.nan]), np.array([-0.01, np.nan])
    points = column_points(ANTENNA, 8.5e6, np.array([0.3, 0.4]), ends, 600.0, ROWS)
    assert points[:, :2] == pytest.approx(np.tile(600.0 * np.array([np.sin(0.3), np.cos(0.3)]), (len(ROWS), 1)))
    assert points[:, 2] == pytest.approx(15.0 + 600.0 * (-0.03 + 0.02 * ROWS) + 600.0**2 / 17e6)
