"""Pieces of meshes: few, convex, flat, of the same surface, and the same however the mesh cuts its planes."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces, aspect_seconds
from radar_service.world.body import Mesh
from radar_service.world.shapes import hull_mesh
from tests.scattering.physical_optics.meshes import ODD, sphere

Floats = NDArray[np.float64]
SHIPS = {"pilot": (12.0, 3.0, 4.3), "fishing": (30.0, 6.0, 6.3), "cargo": (150.0, 26.0, 20.0), "ferry": (100.0, 17.7, 14.1)}


def welded(triangles: Floats) -> Mesh:
    """A mesh of triangles (F, 3, 3), equal corners as one vertex."""
    vertices, where = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return Mesh(vertices, where.reshape(-1, 3))


def split(mesh: Mesh) -> Mesh:
    """The same with each triangle in four."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
    return welded(np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]))


def grid(n: int, holes: list[tuple[int, int]] | None = None, rough: float = 0.0) -> Mesh:
    """A square of 10 m of 2 n^2 triangles without some of its squares; rough: deviation of its vertices [m]."""
    place = np.linspace(0.0, 10.0, n + 1)
    x, y = np.meshgrid(place, place)
    z = rough * np.random.default_rng(1).random(x.shape)
    first = np.array([j * (n + 1) + i for j in range(n) for i in range(n) if (i, j) not in (holes or [])])
    faces = np.concatenate(
        [np.stack([first, first + 1, first + n + 2], 1), np.stack([first, first + n + 2, first + n + 1], 1)]
    )
    return Mesh(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces)


def pieces_of(mesh: Mesh) -> PlanarPieces:
    return PlanarPieces.of(mesh, outward_side(mesh))


def areas(pieces: PlanarPieces) -> Floats:
    """(P,) along the normals: negative where a piece runs the wrong way round."""
    parts = [pieces.corner[a:b] - pieces.corner[a] for a, b in zip(pieces.first, pieces.first[1:], strict=False)]
    return np.array([np.cross(p[1:-1], p[2:]).sum(axis=0) @ n / 2.0 for p, n in zip(parts, pieces.normal, strict=True)])


def surface(mesh: Mesh) -> float:
    """The area of a mesh, of each side that may be seen [m^2]."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    sizes = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    return float((sizes * np.where(outward_side(mesh) == 0, 2.0, 1.0)).sum())


def assert_sound(mesh: Mesh, pieces: PlanarPieces, within: float = 1e-9) -> None:
    """They have the surface of the mesh, are convex, run counterclockwise and lie in their planes."""
    assert areas(pieces).sum() == pytest.approx(surface(mesh), rel=within)
    assert (areas(pieces) > 0.0).all()
    for a, b, normal in zip(pieces.first, pieces.first[1:], pieces.normal, strict=False):
        corners = pieces.corner[a:b]
        edges = np.roll(corners, -1, axis=0) - corners
        assert (np.cross(edges, np.roll(edges, -1, axis=0)) @ normal > -1e-6).all()
        assert np.ptp(corners @ normal) < 2e-3  # 0.5 mm off the largest triangle each way


@pytest.mark.parametrize("kind", SHIPS)
def test_hulls_have_half_as_many_pieces_and_the_same_when_split(kind: str) -> None:
    """Triangles in four, and those in four: as many pieces, of the same sizes."""
    mesh = hull_mesh(kind, 1, *SHIPS[kind])
    pieces, finer = pieces_of(mesh), pieces_of(split(split(mesh)))
    assert_sound(mesh, pieces)
    assert len(pieces) < 0.56 * len(mesh.faces)
    np.testing.assert_allclose(np.sort(areas(finer)), np.sort(areas(pieces)), rtol=1e-9, atol=1e-9)


def test_a_plate_with_holes_is_cut_around_them() -> None:
    """Two apart, two that touch at a corner, one at the rim; turned anyhow. Without its rim hole there are 4 holes in 9 x 9."""
    mesh = grid(9, [(2, 2), (5, 3), (6, 4), (3, 6), (0, 4)])
    turned = Mesh(mesh.vertices @ ODD.T, mesh.faces)
    pieces = pieces_of(turned)
    assert_sound(turned, pieces)
    assert len(pieces) <= 2 * 16  # both sides; a cut for each of 4 x 4 + 2 concave corners at most
    assert len(np.unique(pieces.patch)) == 2


def test_what_faces_outward_is_kept_of_closed_bodies_and_both_sides_of_sheets() -> None:
    box = hull_mesh("pilot", 1, *SHIPS["pilot"])
    inside_out = Mesh(box.vertices, box.faces[:, ::-1])
    pieces, turned = pieces_of(box), pieces_of(inside_out)
    np.testing.assert_allclose(np.sort(turned.normal @ [1, 2, 3]), np.sort(pieces.normal @ [1, 2, 3]), atol=1e-12)
    sheet = pieces_of(grid(4))
    assert len(sheet) == 2 and set(sheet.normal[:, 2]) == {1.0, -1.0}


@pytest.mark.parametrize("name", ["rough", "nearly flat", "soup", "swiss", "comb", "fan", "sphere"])
def test_any_mesh_has_pieces_of_its_surface(name: str) -> None:
    """Crossing triangles, a plate of scattered holes, teeth, 500 sheets about one edge, curves: what cannot be joined stays its
    triangles. Vertices 0.2 mm off a plane change its surface by 2e-6 of it."""
    rng = np.random.default_rng(1)
    if name == "rough":
        mesh = grid(20, rough=0.05)
    elif name == "nearly flat":
        mesh = grid(20, rough=0.0002)
    elif name == "soup":
        mesh = welded(10.0 * rng.random((200, 3, 3)))
    elif name == "swiss":
        mesh = grid(30, [(int(i), int(j)) for i, j in rng.integers(0, 30, (300, 2))])
    elif name == "comb":
        x = np.arange(400) * 0.01
        teeth = np.stack([x, np.where(np.arange(400) % 2, 1.0, 5.0), 0.0 * x], axis=1)
        first = np.arange(399)
        faces = np.concatenate(
            [np.stack([first, first + 1, first + 400], 1), np.stack([first + 1, first + 401, first + 400], 1)]
        )
        mesh = Mesh(np.concatenate([np.stack([x, 0 * x, 0 * x], axis=1), teeth]), faces)
    elif name == "fan":
        turn = np.linspace(0.0, 6.0, 500)
        rim = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
        faces = np.stack([np.zeros(500, dtype=np.int64), np.ones(500, dtype=np.int64), np.arange(500) + 2], axis=1)
        mesh = Mesh(np.concatenate([[[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]], rim]), faces)
    else:
        mesh = welded(sphere(5.0, 6))
    assert_sound(mesh, pieces_of(mesh), 1e-5)


def test_equal_and_empty_triangles_count_once_or_not_at_all() -> None:
    """Each triangle three times, once turned over, and slivers 1e-8 m wide: a sheet of two sides."""
    mesh = grid(3)
    again = Mesh(
        np.concatenate([mesh.vertices, mesh.vertices + 1e-8]),
        np.concatenate([mesh.faces, mesh.faces + 16, mesh.faces[:, ::-1]]),
    )
    slivers = Mesh(again.vertices, np.concatenate([again.faces, [[0, 16, 1], [0, 0, 1], [5, 21, 6]]]))
    pieces = pieces_of(slivers)
    assert areas(pieces).sum() in (pytest.approx(200.0), pytest.approx(400.0))  # each way round is a surface of two sides
    assert len(pieces) <= 4


@pytest.mark.study
@pytest.mark.parametrize("rough", [0.0, 0.05])
def test_three_million_triangles_take_seconds_and_a_gigabyte(rough: float) -> None:
    n = 1225
    place = np.linspace(0.0, 10.0, n + 1)
    x, y = np.meshgrid(place, place)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([first, first + 1, first + n + 2], 1), np.stack([first, first + n + 2, first + n + 1], 1)]
    )
    mesh = Mesh(np.stack([x.ravel(), y.ravel(), rough * np.random.default_rng(1).random(x.size)], axis=1), faces)
    tracemalloc.start()
    pieces = PlanarPieces.of(mesh, np.zeros(len(faces), dtype=np.int8))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(pieces) == (2 if rough == 0.0 else 2 * len(faces)) or len(pieces) > len(faces)
    assert peak < 1.2e9  # of Python's own; the kernel has 100 bytes a triangle besides


def test_scenes_of_ships_keep_their_surface() -> None:
    """The shipped coaster, by its triangles: sheets and closed parts together."""
    lines = [
        line.split() for line in (Path(__file__).parents[3] / "scenes" / "coaster.obj").read_text().splitlines() if line
    ]
    vertices = np.array([[float(x) for x in p[1:4]] for p in lines if p[0] == "v"])
    corners = [[int(x.split("/")[0]) - 1 for x in p[1:]] for p in lines if p[0] == "f"]
    faces = np.array([[c[0], c[k], c[k + 1]] for c in corners for k in range(1, len(c) - 1)])
    mesh = Mesh(vertices, faces)
    pieces = pieces_of(mesh)
    assert_sound(mesh, pieces)
    assert len(areas(pieces)) == len(areas(pieces_of(split(mesh))))


def test_an_aspect_of_a_hull_takes_what_was_measured() -> None:
    """Milliseconds of hulls of 250 pieces; about linear up to 1000, and some 50 at 2000."""
    assert [aspect_seconds(250, bounces) * 1e3 for bounces in (1, 3)] == pytest.approx([1.45, 4.5])
    assert (
        aspect_seconds(1000, 3) == 4 * aspect_seconds(250, 3)
        and 2.5 * aspect_seconds(1000, 3) < aspect_seconds(2000, 3) < 0.06
    )
