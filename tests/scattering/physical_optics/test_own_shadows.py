"""Shadows of a body on itself, against lines drawn by hand over two walls, and against rays of the whole scene."""

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_body, map_from_deck
from radar_service.propagation.multipath import reflection_points
from radar_service.scattering.physical_optics.own_shadows import OwnShadows
from radar_service.trace.occluder import Occluder
from radar_service.world.body import Mesh
from radar_service.world.poses import BodyPose
from tests.scattering.physical_optics.meshes import sheet

EARTH = 4 / 3 * 6_371_000.0
HEADING = 2.1
BACK = 2  # first triangle of the back wall


def walls(front: float, rows: int = 1) -> Mesh:
    """A wall of some height [m] 10 m before another of 8 m, both 30 m wide, square to the antenna in the south; rows: in how
    many parts the triangles of the front one are divided."""
    parts = [sheet([-15, -5, 0], [30, 0, 0], [0, 0, front], rows), sheet([-15, 5, 0], [30, 0, 0], [0, 0, 8.0], 1)]
    triangles = np.concatenate(parts).reshape(-1, 3)
    return Mesh(triangles, np.arange(len(triangles)).reshape(-1, 3))


def shadows(mesh: Mesh, distance: float, height: float, by_sea: bool, roll: float = 0.0, earth: float = EARTH) -> OwnShadows:
    """Of a body whose upright frame has the antenna in the south; roll: of the body in which the mesh is rolled back."""
    rotation = map_from_deck(np.array(HEADING), np.array(roll), np.array(0.0))
    pose = BodyPose(np.array([300.0, -200.0, 0.0]), HEADING, rotation if roll else None)
    own = mesh if pose.lean is None else Mesh(mesh.vertices @ pose.lean, mesh.faces)
    antenna = map_from_body(np.array([0.0, 5.0 - distance, height]), pose.position, HEADING)
    return OwnShadows(Occluder(own, earth), pose, antenna, earth, by_sea)


@pytest.mark.parametrize("roll", [0.0, 0.2], ids=["upright", "rolled"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
@pytest.mark.parametrize("distance", [40.0, 400.0, 3000.0])
def test_the_edge_of_a_shadow_is_where_the_line_over_the_front_wall_meets_the_back_one(
    distance: float, by_sea: bool, roll: float
) -> None:
    """By the sea the line comes from the image of the antenna. 1 cm to either side; the earth curves by 2 mm on this body."""
    height = -12.0 if by_sea else 12.0
    edge = 2.0 + (2.0 - height) * 10.0 / (distance - 10.0)
    points = np.array([[x, 5.0, edge + aside] for x in (-7.0, 0.0, 7.0) for aside in (-0.01, 0.01)])
    seen = shadows(walls(2.0), distance, 12.0, by_sea, roll).visible(points, np.full(6, BACK))
    np.testing.assert_array_equal(seen, edge < points[:, 2])


@pytest.mark.parametrize("roll", [0.0, 0.2], ids=["upright", "rolled"])
@pytest.mark.parametrize(
    ("distance", "by_sea"), [(400.0, False), (3000.0, False), (40.0, True), (400.0, True), (3000.0, True)]
)
@pytest.mark.parametrize("rows", [1, 2], ids=["two triangles", "eight"])
def test_edges_are_found_to_millimetres_along_any_way(rows: int, distance: float, by_sea: bool, roll: float) -> None:
    """Where the line over the front wall meets the back one, as above; 3 mm for the curve of the earth. The ways lead straight
    up, and aslant."""
    height = -12.0 if by_sea else 12.0
    top = 2.0 + (2.0 - height) * 10.0 / (distance - 10.0)
    hidden = np.array([[x, 5.0, top - 1.2] for x in (-7.1, 0.3, 6.2)] * 2)
    seen = hidden + np.array([[aside, 0.0, 4.0] for aside in (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)])
    share = shadows(walls(2.0, rows), distance, 12.0, by_sea, roll).edges(hidden, seen, np.full(6, 2 * rows**2))
    np.testing.assert_allclose(hidden[:, 2] + 4.0 * share, top, atol=3e-3)


def test_an_edge_behind_too_many_triangles_is_not_made_up() -> None:
    """The way of 1.9 m passes the shadows of some 30 rows of triangles, more than are followed."""
    own = shadows(walls(2.0, 60), 400.0, 12.0, False)
    hidden, seen = np.array([[0.3, 5.0, 0.2]]), np.array([[0.3, 5.0, 4.0]])
    assert np.isnan(own.edges(hidden, seen, np.array([7200]))).all()


def test_a_wall_stands_in_the_way_of_the_ray_to_the_sea_too() -> None:
    """At 200 m a ray from 20 m to 0.5 m of the back wall meets the sea 5 m behind the front wall, and passes that at 0.5 m."""
    points, triangle = np.array([[0.0, 5.0, 0.5]]), np.array([BACK])
    assert shadows(walls(0.3), 200.0, 20.0, True).visible(points, triangle).all()
    assert not shadows(walls(1.0), 200.0, 20.0, True).visible(points, triangle).any()


@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_the_answer_is_that_of_rays_on_the_map(by_sea: bool, earth: float) -> None:
    """2000 points on rough triangles; single precision may decide one in a thousand otherwise."""
    rng = np.random.default_rng(5)
    centre = rng.uniform([-20, -20, 3], [20, 20, 12], (60, 3))
    corners = centre[:, None] + rng.uniform(-3, 3, (60, 3, 3))
    mesh = Mesh(corners.reshape(-1, 3), np.arange(180).reshape(-1, 3))
    triangle = rng.integers(0, 60, 2000)
    points = np.einsum("nc,ncx->nx", rng.dirichlet(np.ones(3), 2000), corners[triangle])
    own = shadows(mesh, 700.0, 15.0, by_sea, earth=earth)
    position = map_from_body(points, own.pose.position, HEADING)
    origin = reflection_points(position, own.antenna, earth)[0] if by_sea else own.antenna
    expected = ~own.occluder.self_occluded(own.pose, origin, position, (triangle, triangle + 1))
    seen = own.visible(points, triangle)
    assert 500 < seen.sum() < 1900
    assert np.count_nonzero(seen != expected) <= 2
