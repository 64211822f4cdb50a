"""Shared edges, facing triangles and outer sides of shapes whose answers are known."""

import numpy as np

from radar_service.scattering.physical_optics.mesh_quality import concave_sides, outward_side, shared_edges
from radar_service.world.body import Mesh
from radar_service.world.shapes import box, dihedral, plate, sphere
from tests.scattering.physical_optics.meshes import ODD


def united(*parts: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    return Mesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def test_convex_bodies_face_nothing_and_corners_do() -> None:
    front_back = concave_sides(box(2.0, 3.0, 4.0))
    assert not front_back[:, 0].any() and front_back[:, 1].all()
    assert not concave_sides(plate(1.0, 1.0)).any()
    assert (concave_sides(dihedral(1.0, 1.0)).sum(axis=1) == 1).all()
    assert not concave_sides(sphere(1.0))[:, 0].any()


def test_outside_is_known_of_closed_bodies_however_they_are_wound() -> None:
    """Of a box, a box turned inside out, and a box without a side; vertices unshared, as in STL."""
    for mesh, expected in ((box(2, 3, 4), 1), (Mesh(box(2, 3, 4).vertices, box(2, 3, 4).faces[:, ::-1]), -1)):
        apart = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))
        assert (outward_side(mesh) == expected).all() and (outward_side(apart) == expected).all()
    opened = Mesh(box(2, 3, 4).vertices, box(2, 3, 4).faces[1:])
    assert (outward_side(opened) == 0).all()
    mixed = box(2, 3, 4).faces.copy()
    mixed[0] = mixed[0, ::-1]
    assert (outward_side(Mesh(box(2, 3, 4).vertices, mixed)) == 0).all()


def test_a_closed_part_stays_closed_where_others_touch_it() -> None:
    """A hull with a fin on its side, and two boxes that touch along an edge, the second one inside out; the fin is open."""
    hull = box(6.0, 2.0, 2.0)
    fin = Mesh(np.array([[1.0, -3.0, 0.0], [1.0, 3.0, 0.0], [2.0, 0.0, 0.0]]), np.array([[0, 1, 2]]))
    sides = outward_side(united(hull, fin))
    assert (sides[: len(hull.faces)] == 1).all() and (sides[len(hull.faces) :] == 0).all()
    touching = Mesh(hull.vertices + [2.0, 0.0, 2.0], hull.faces[:, ::-1])
    assert outward_side(united(hull, touching)).tolist() == [1] * len(hull.faces) + [-1] * len(hull.faces)


def test_a_closed_sheet_has_no_inside() -> None:
    """Front and back cut along different diagonals: every edge joins two triangles wound alike, but no volume has a sign."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]) @ ODD.T + [0.3, 0.1, 0.7]
    assert (outward_side(Mesh(corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))) == 0).all()


def test_neighbours_share_an_edge_though_not_its_vertices() -> None:
    """A box of 16 triangles has 24 edges, each of which joins two; the same with vertices of its own for each triangle."""
    mesh = box(2.0, 3.0, 4.0)
    apart = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))
    for one, other in (shared_edges(mesh), shared_edges(apart)):
        assert len(one) == 24 and (np.bincount(np.concatenate([one, other]) // 3) == 3).all()
