"""What `check` tells of bodies by physical optics, for shapes whose answers are known."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.plan.body_errors import body_run
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import Conditions
from radar_service.scattering.models import scattering_model
from radar_service.scattering.physical_optics.mesh_quality import concave, curve_sag, length_text, outward_side
from radar_service.world.body import Mesh
from radar_service.world.shapes import box, cylinder, dihedral, plate, sphere
from tests.reference.make_ships import coaster
from tests.scattering.physical_optics.meshes import cross_section, loaded, optical, toward
from tests.scattering.physical_optics.meshes import plate as plate_triangles
from tests.scattering.physical_optics.meshes import sphere as cube_sphere
from tests.scene_file.readers.mesh_files import mesh_from_bytes


def messages(wavelengths: float = 1.0, **body: Any) -> str:
    """Of one body 1 km off, at a multiple of the wavelength of 9.41 GHz."""
    made = {"name": "b", "scattering": "optics", "position_m": [0, 1000, 0], **body}
    scene = rs.load_scene({"radar": {"frequency_hz": 9.41e9 / wavelengths}, "body": [made]})
    return "\n".join(judged(scene)["b"])


def judged(scene: rs.Scene) -> dict[str, list[str]]:
    """What their models say of meshes of bodies at their closest; not of those about which they say nothing."""
    conditions = Conditions.of_scene(scene, PRESETS["balanced"])
    remarks = {
        body.name: scattering_model(body).mesh_remarks(body, conditions, body_run(body, scene).nearest)
        for body in scene.bodies
    }
    return {name: sentences for name, sentences in remarks.items() if sentences}


@pytest.mark.parametrize(("radius", "sag"), [(0.3, 0.004), (2.0, 0.0005)])
def test_sag_of_a_cylinder_is_that_of_its_sides(radius: float, sag: float) -> None:
    """r (1 - cos(pi / n)); turn x chord / 8 falls short of it by (pi / n)^2 / 12, and n is 20 or more: 0.2 %."""
    mesh = cylinder(radius, 3.0, sag)
    sides = len(mesh.faces) // 4
    assert curve_sag(mesh) == pytest.approx(radius * (1 - np.cos(np.pi / sides)), rel=2.1e-3)


def test_sag_of_a_sphere_is_that_of_its_largest_facet() -> None:
    """9/8 of it for equilateral facets, and the icosphere's are so to a fifth."""
    mesh = sphere(1.0, 0.001)
    corners = mesh.vertices[mesh.faces]
    middle = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    distance = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    assert curve_sag(mesh) == pytest.approx(1.125 * (1.0 - (distance / middle).min()), rel=0.2)


def test_sag_does_not_depend_on_winding() -> None:
    mesh = cylinder(1.0, 2.0)
    turned = mesh.faces.copy()
    turned[::2] = turned[::2, ::-1]
    assert curve_sag(Mesh(mesh.vertices, turned)) == pytest.approx(curve_sag(mesh), rel=1e-12)


@pytest.mark.parametrize("mesh", [box(3.0, 2.0, 1.0), plate(1.0, 1.0), dihedral(1.0, 1.0)])
def test_edges_are_no_curves(mesh: Mesh) -> None:
    assert curve_sag(mesh) == 0.0


def test_only_what_faces_something_is_concave() -> None:
    closed = box(3.0, 2.0, 1.0)
    inside_out = Mesh(closed.vertices, closed.faces[:, ::-1])
    assert not any(concave(mesh, outward_side(mesh)) for mesh in (closed, inside_out, plate(1.0, 1.0), cylinder(1.0, 2.0)))
    corner = dihedral(1.0, 1.0)
    assert concave(corner, outward_side(corner)) == 4


def test_a_fine_curve_is_fine_at_any_wavelength_that_it_suits() -> None:
    ball = {"shape": "sphere", "radius_m": 0.1}
    for wavelengths, told in ((1.0, "31.9 mm"), (0.4, "12.7 mm")):
        text = messages(wavelengths, **ball)
        assert f"fine at a wavelength of {told}" in text and "convex" in text


def test_the_sag_of_a_sphere_too_large_for_its_triangles() -> None:
    """50 m: 128,000 triangles sag by 2.28 mm, and the message says 9/8 of that."""
    message = messages(shape="sphere", radius_m=50.0)
    assert "up to 2.56 mm" in message and "beyond 0.16 mm" in message and "refine those that matter" in message


def test_a_ship_is_concave_and_declared_bodies_have_no_messages(tmp_path: Path) -> None:
    ship = loaded(tmp_path, coaster())
    assert "concave: " in judged(ship)["body"][0] and "up to 3 bounces" in judged(ship)["body"][0]
    declared = {"name": "b", "shape": "plate", "width_m": 1.0, "height_m": 1.0, "rcs_dbsm": 3}
    assert judged(rs.load_scene({"body": [declared]})) == {}


def test_lengths_are_told_in_millimetres_below_a_metre() -> None:
    assert [length_text(x) for x in (0.00016, 0.0244, 0.9, 2.19)] == ["0.16 mm", "24.4 mm", "900 mm", "2.19 m"]


def test_a_sphere_made_elsewhere_is_judged_by_its_mesh(tmp_path: Path) -> None:
    messages_by_n = ["\n".join(judged(loaded(tmp_path, cube_sphere(0.3, n)))["body"]) for n in (5, 48)]
    assert "refine" in messages_by_n[0] and "fine at" in messages_by_n[1]


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
    mesh, findings, *_ = mesh_from_bytes(text, "a.obj", "m")
    assert len(mesh.faces) == 2 and findings[0] == "3 duplicate triangles dropped"


def test_open_parts_are_told_and_closed_ones_are_not(tmp_path: Path) -> None:
    """A box without a triangle of its lid, and the whole box."""
    closed = box(3.0, 2.0, 1.0)
    triangles = closed.vertices[closed.faces]
    opened, whole = ("\n".join(judged(loaded(tmp_path, t))["body"]) for t in (triangles[1:], triangles))
    assert f"{len(triangles) - 1} of {len(triangles) - 1} facets belong to parts that are open" in opened
    assert "open or wound" not in whole
