"""Faces that lie on one another, cut along other diagonals: which are found, which not, and that the rest reflects once."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.numerics.types import Floats, Indices
from radar_service.scene_file.readers.mesh import flat_copies, numbered_edges
from radar_service.world.shapes import cylinder, sphere
from tests.scattering.physical_optics.meshes import ODD, cross_section, loaded, optical, toward
from tests.scene_file.readers.mesh_files import mesh_from_bytes

QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]  # of a box, seen from outside


def corners(length: float, width: float, height: float) -> Floats:
    """Of a box, (8, 3)."""
    return np.array([(x, y, z) for z in (0.0, height) for y in (0.0, width) for x in (0.0, length)])


def halves(quads: list[tuple[int, ...]], other: bool) -> Indices:
    """Two triangles of each quadrilateral, along one diagonal or the other."""
    cut = ((0, 1, 3), (1, 2, 3)) if other else ((0, 1, 2), (0, 2, 3))
    return np.array([[quad[i] for i in three] for quad in quads for three in cut])


def fans(points: Floats) -> tuple[Floats, Indices]:
    """Four triangles of each face of a box, about a vertex in its middle that is added to the points (8, 3)."""
    faces = [(a, b, 8 + k) for k, quad in enumerate(QUADS) for a, b in zip(quad, quad[1:] + quad[:1], strict=True)]
    return np.concatenate([points, points[np.array(QUADS)].mean(axis=1)]), np.array(faces)


def copies(points: Floats, faces: Indices) -> list[int]:
    return flat_copies(points, faces, numbered_edges(faces)).tolist()


BOX = corners(10.0, 4.0, 3.0)
ASPECTS = ([0.0, -1.0, 0.0], [0.2, -1.0, 0.1], [1.0, 0.5, 0.3])
PLAIN, OTHER = halves(QUADS, False), halves(QUADS, True)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("reversed_too", [False, True])
@pytest.mark.parametrize("kind", ["diagonals", "fans"])
def test_a_box_with_a_copy_cut_otherwise(kind: str, reversed_too: bool, turned: bool) -> None:
    """All of the copy and nothing else, wound either way, along the axes or turned, which rounds its planes."""
    points, copy = (BOX, OTHER) if kind == "diagonals" else fans(BOX)
    faces = np.concatenate([PLAIN, copy[:, ::-1] if reversed_too else copy])
    assert copies(points @ ODD.T if turned else points, faces) == list(range(12, len(faces)))


def test_a_sheet_drawn_on_both_sides() -> None:
    """Front and back of one quadrilateral, whose edges have two triangles each, folded back."""
    assert copies(BOX[:4] @ ODD.T, np.concatenate([halves(QUADS[:1], False), halves(QUADS[:1], True)[:, ::-1]])) == [2, 3]


def test_one_face_of_many() -> None:
    """A deck of 5 x 5 squares, of which one is there twice."""
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    index = np.arange(36).reshape(6, 6)
    quads = [tuple(q) for q in np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)]
    faces = np.concatenate([halves(quads, False), halves(quads[12:13], True)])
    assert copies(np.stack([x, y, 0.0 * x], axis=-1).reshape(-1, 3), faces) == [50, 51]


def test_a_bent_face_cut_otherwise_encloses_something() -> None:
    """Four corners of which one stands off the plane of the others: what lies between both cuts is as thick as that."""
    for off, expected in ((5e-4, [2, 3]), (4e-3, [])):
        points = BOX[[0, 2, 3, 1]] + [[0.0, 0.0, off], *np.zeros((3, 3))]
        quad = [(0, 1, 2, 3)]
        assert copies(points, np.concatenate([halves(quad, False), halves(quad, True)[:, ::-1]])) == expected


def test_a_pillow_is_no_copy_of_its_own_half() -> None:
    """Two caps of 0.3 x 0.3 m on one rim, bent so little that each is one piece, but 3.4 mm apart in the middle."""
    side = np.linspace(-1.0, 1.0, 25)
    x, y = np.meshgrid(side, side)
    inner = (np.abs(x) < 1.0) & (np.abs(y) < 1.0)
    upper = np.arange(625).reshape(25, 25)
    lower = np.where(inner, 625 + upper, upper)
    quads = [
        [(g[i, j], g[i, j + 1], g[i + 1, j + 1], g[i + 1, j]) for i in range(24) for j in range(24)] for g in (upper, lower)
    ]
    up = 1.7e-3 * (1.0 - x**2) * (1.0 - y**2)
    points = np.concatenate([np.stack([0.15 * x, 0.15 * y, z], axis=-1).reshape(-1, 3) for z in (up, -up)])
    assert copies(points, np.concatenate([halves(quads[0], False), halves(quads[1], True)[:, ::-1]])) == []


@pytest.mark.parametrize(
    ("points", "faces"),
    [
        (BOX, PLAIN),
        (sphere(1.0).vertices, sphere(1.0).faces),  # halves of it have one boundary
        (cylinder(0.3, 2.0).vertices, cylinder(0.3, 2.0).faces),
        (corners(10.0, 4.0, 0.01), PLAIN),  # a door 10 mm thick
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])),
        (np.concatenate([BOX, BOX + [10.0, 0.0, 0.0]]), np.concatenate([PLAIN, PLAIN + 8])),
        (BOX[[0, 1, 2, 3]], np.array([[0, 1, 2], [0, 1, 3]])),  # two that overlap, but with other boundaries
    ],
)  # fmt: skip
def test_what_is_no_copy(points: Floats, faces: Indices) -> None:
    assert copies(points, faces) == []


def test_a_box_with_a_copy_reflects_as_the_single_box(tmp_path: Path) -> None:
    """Before, 6.02 dB more; now the same to the rounding of phases of 8e5 rad, from three sides."""
    both = np.concatenate([PLAIN, OTHER[:, ::-1]])
    single, doubled = (
        [cross_section(optical(loaded(tmp_path, BOX[faces])), toward(aspect, 2000.0)) for aspect in ASPECTS]
        for faces in (PLAIN, both)
    )
    assert doubled == pytest.approx(single, rel=1e-8)


def test_the_finding_says_how_many() -> None:
    lines = [f"v {x} {y} {z}" for x, y, z in BOX.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.concatenate([PLAIN, OTHER[:, ::-1]]) + 1).tolist()]
    mesh, findings, *_ = mesh_from_bytes("\n".join(lines).encode(), "a.obj", "m")
    assert len(mesh.faces) == 12 and findings == ("12 triangles of faces dropped that repeat others, cut differently",)
