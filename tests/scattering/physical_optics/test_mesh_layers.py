"""Doubled layers of synthetic meshes: which triangles reflect twice, told from crates on decks and from plates with two skins."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.mesh_layers import doubled_layers
from radar_service.scattering.physical_optics.patches import outward_side
from radar_service.scene.body import Mesh
from radar_service.scene.files.mesh import mesh_from_bytes
from radar_service.scene.shapes import box, plate, sphere
from tests.scattering.physical_optics.meshes import ODD, cross_section, decibels, loaded, optical, toward
from tests.scattering.physical_optics.meshes import plate as plate_triangles

HULL = box(60.0, 12.0, 8.0)


def united(*parts: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    return Mesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def shifted(mesh: Mesh, *by: float) -> Mesh:
    return Mesh(mesh.vertices + np.array(by), mesh.faces)


def turned(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])


SHEET = plate(3.0, 2.0)


@pytest.mark.parametrize(
    ("mesh", "share"),
    [
        (HULL, 0.0),
        (sphere(1.0), 0.0),
        (SHEET, 0.0),
        (united(HULL, shifted(box(6.0, 2.4, 2.6), 0.0, 9.0, 8.0)), 0.0),  # a crate on deck: faces that face each other
        (united(HULL, shifted(SHEET, 0.0, 0.0, 20.0), shifted(SHEET, 0.0, 0.01, 20.0)), 0.0),  # 10 mm: one shadows the other
        (united(SHEET, shifted(SHEET, 0.0, 1e-3, 0.0)), 1.0),
        (united(SHEET, shifted(turned(SHEET), 0.0, 1e-3, 0.0)), 1.0),  # of open parts both sides reflect
        (united(HULL, shifted(HULL, 0.0, 0.0, 0.0)), 1.0),  # the same twice, in vertices of its own
        (united(HULL, shifted(box(60.0, 12.0, 4.0), 0.0, 0.0, 4.0)), None),  # its upper half doubled, deck included
    ],
)
def test_share_of_doubled_layers(mesh: Mesh, share: float | None) -> None:
    """Exact, but for the last: of 8 and 4 triangles as large as half a side, bow or deck, those of the upper half and the
    deck lie on others; the sides of the hull reach below, and only the middle of a triangle is looked at."""
    found = doubled_layers(Mesh(mesh.vertices @ ODD.T, mesh.faces), outward_side(mesh))
    if share is None:
        assert 0.3 < found.share < 1.0
    else:
        assert found.share == pytest.approx(share, abs=1e-12) and (found.facets == len(mesh.faces) * share)


def test_what_is_said_to_reflect_twice_does(tmp_path: Path) -> None:
    """Two layers 0.1 mm apart, 0.04 rad of two-way phase: 6.02 dB over one within 0.01 dB. 10 mm apart there is no more."""
    sheet = plate_triangles(2.0, 1.0, 1)

    def of(triangles: Floats) -> float:
        return decibels(cross_section(optical(loaded(tmp_path, triangles)), toward([0.0, -1.0, 0.0], 2000.0)))

    single, close, apart = (
        of(np.concatenate([sheet, sheet + [0, gap, 0]])[: 2 + n]) for gap, n in ((0, 0), (1e-4, 2), (0.01, 2))
    )
    assert close - single == pytest.approx(6.02, abs=0.01) and apart == pytest.approx(single, abs=0.01)


def test_a_sheet_with_a_triangle_on_either_side_reflects_once(tmp_path: Path) -> None:
    """As exported by programs that draw front and back: equal to the plain sheet, from the front and from the back."""
    sheet = plate_triangles(2.0, 1.0, 2)
    for both in (np.concatenate([sheet, sheet[:, ::-1]]), np.concatenate([sheet[:, [1, 0, 2]], sheet])):
        for side in (1.0, -1.0):
            plain, doubled = (
                cross_section(optical(loaded(tmp_path, t)), toward([0.02, side, 0.01], 2000.0)) for t in (sheet, both)
            )
            assert doubled == pytest.approx(plain, rel=1e-8)  # rounding of phases of 8e5 rad


def test_triangles_back_to_back_are_dropped_and_counted() -> None:
    text = b"v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 2 3\nf 1 3 2\nf 2 4 3\nf 3 4 2\nf 4 3 2\n"
    mesh, findings = mesh_from_bytes(text, "a.obj", "m")
    assert len(mesh.faces) == 2 and findings[0] == "3 duplicate triangles dropped"
