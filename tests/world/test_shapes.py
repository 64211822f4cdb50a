"""Built-in shapes: volume, area, extent and facing by theory."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.scattering.physical_optics.model import OpticalBody, PhysicalOptics
from radar_service.world import shapes
from radar_service.world.body import Mesh
from radar_service.world.shapes import HULL_TYPES, PLAIN, hull_mesh, shape_mesh
from tests.scattering.physical_optics.meshes import cross_section, decibels
from tests.scenes import scene

Floats = NDArray[np.float64]
WAVELENGTH = 0.0319  # m
SMALL = 1e-12  # relative rounding of a few hundred sums of float64


def normals_and_areas(mesh: Mesh) -> tuple[Floats, Floats]:
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    doubled = np.linalg.norm(cross, axis=1)
    return cross / doubled[:, None], doubled / 2.0


def volume(mesh: Mesh) -> float:
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def open_edges(mesh: Mesh) -> int:
    start, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    directed = set(zip(start.tolist(), end.tolist(), strict=True))
    assert len(directed) == start.size, "an edge runs the same way twice"
    return sum((b, a) not in directed for a, b in directed)


@pytest.mark.parametrize(
    "shape, sizes",
    [
        ("sphere", {"radius_m": 2.0}),
        ("box", {"length_m": 4.0, "width_m": 2.0, "height_m": 1.0}),
        ("cylinder", {"radius_m": 1.0, "height_m": 3.0}),
        ("hull", {"length_m": 100.0, "beam_m": 16.0, "height_m": 20.0}),
        ("hull", {"length_m": 0.7, "beam_m": 0.3, "height_m": 0.2}),
    ],
)
def test_bodies_are_closed_and_wound_outward(shape: str, sizes: dict[str, float]) -> None:
    mesh = shape_mesh(shape, sizes)
    assert open_edges(mesh) == 0
    assert volume(mesh) > 0.0
    assert normals_and_areas(mesh)[1].min() > 0.0
    assert mesh.solid and mesh.placed(1.0, np.ones(3)).solid


@pytest.mark.parametrize(
    ("shape", "sizes"),
    [("plate", {"width_m": 1, "height_m": 1}), ("dihedral", {"width_m": 1, "height_m": 1}), ("trihedral", {"edge_m": 1})],
)
def test_sheets_are_not_solid(shape: str, sizes: dict[str, float]) -> None:
    assert open_edges(shape_mesh(shape, sizes)) > 0 and not shape_mesh(shape, sizes).solid


@pytest.mark.parametrize("radius", [0.1, 1.0, 10.0])
def test_sphere(radius: float) -> None:
    mesh = shapes.sphere(radius)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), radius, rtol=SMALL)
    _, areas = normals_and_areas(mesh)
    assert sag_of_sphere(mesh, radius) < 0.032 / 8  # m: the rule that sets the fineness
    assert areas.sum() == pytest.approx(4 * math.pi * radius**2, rel=2 * 0.004 / radius)  # area shrinks by 2 sag / r at most
    assert volume(mesh) == pytest.approx(4 / 3 * math.pi * radius**3, rel=3 * 0.004 / radius)


def sag_of_sphere(mesh: Mesh, radius: float) -> float:
    """Largest distance [m] between the sphere and the middle of a facet."""
    normals, _ = normals_and_areas(mesh)
    return radius - float(np.einsum("ij,ij->i", mesh.vertices[mesh.faces].mean(axis=1), normals).min())


def fine(shape: str, sizes: dict[str, float]) -> Mesh:
    """The mesh of a shape as physical optics asks for it."""
    return shape_mesh(shape, sizes, PhysicalOptics.shape_sag(shape, WAVELENGTH))


@pytest.mark.parametrize("radius", [0.1, 1.0, 10.0])
def test_curves_by_optics_are_finer(radius: float) -> None:
    """Phases ask for 1/300 and 1/400 wavelength, bounds end it at 73 wavelengths of radius for spheres, and shapes without
    curves stay as they are."""
    assert sag_of_sphere(fine("sphere", {"radius_m": radius}), radius) < max(WAVELENGTH / 300, 0.0000457 * radius)
    size = {"radius_m": radius, "height_m": 3.0}
    sides = len(fine("cylinder", size).faces) // 4
    assert radius * (1.0 - math.cos(math.pi / sides)) < WAVELENGTH / 400
    plain = {"length_m": 4.0, "width_m": 2.0, "height_m": 1.0}
    assert len(fine("box", plain).faces) == len(shape_mesh("box", plain).faces)


@pytest.mark.parametrize("radius", [0.01, 0.2, 1.0])
def test_a_fine_sphere_is_closed_and_has_no_more_facets_than_needed(radius: float) -> None:
    mesh = fine("sphere", {"radius_m": radius})
    assert open_edges(mesh) == 0 and len(mesh.vertices) == len(mesh.faces) // 2 + 2  # Euler
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), radius, rtol=SMALL)
    parts = math.sqrt(len(mesh.faces) / 20)
    assert parts == 4 or sag_of_sphere(mesh, radius) * (parts / (parts - 1)) ** 2 > 0.95 * WAVELENGTH / 300


def test_large_curves_by_optics_stay_within_bounds() -> None:
    """50 m takes 128,000 triangles, which sag by r / 21 900, as `check` then says; a cylinder has 4096 sides at most."""
    large = fine("sphere", {"radius_m": 50.0})
    assert len(large.faces) == 20 * 80**2 and sag_of_sphere(large, 50.0) < 50.0 / 21_900
    endless = fine("cylinder", {"radius_m": 50_000.0, "height_m": 3.0})
    assert len(endless.faces) == 4 * 4096


def test_the_loader_makes_curves_fine_where_they_scatter_by_optics() -> None:
    ball = {"shape": "sphere", "radius_m": 1.0, "position_m": [0, 900, 0]}
    bodies = [{**ball, "name": "o", "scattering": "optics"}, {**ball, "name": "d", "rcs_dbsm": 5}]
    counts = [len(body.mesh.faces) for body in rs.load_scene({"body": bodies}).bodies if body.mesh is not None]
    assert counts == [20 * 53**2, 20 * 4**4]  # sqrt(0.292 x 300 / 0.0319) = 52.4


def test_spheres_stay_within_bounds() -> None:
    assert len(shapes.sphere(0.001).faces) == 20 * 4**2
    assert len(shapes.sphere(100_000.0).faces) == 20 * 4**6


def test_plate_faces_north_about_its_centre() -> None:
    mesh = shapes.plate(2.0, 3.0)
    normals, areas = normals_and_areas(mesh)
    np.testing.assert_allclose(normals, [[0, 1, 0]] * 2, atol=SMALL)
    assert areas.sum() == pytest.approx(6.0, rel=SMALL)
    np.testing.assert_array_equal(mesh.vertices.min(axis=0), [-1.0, 0.0, -1.5])
    np.testing.assert_array_equal(mesh.vertices.max(axis=0), [1.0, 0.0, 1.5])


def test_box_stands_on_its_foot() -> None:
    mesh = shapes.box(4.0, 2.0, 1.0)
    assert volume(mesh) == pytest.approx(8.0, rel=SMALL)
    assert normals_and_areas(mesh)[1].sum() == pytest.approx(28.0, rel=SMALL)
    np.testing.assert_array_equal(mesh.vertices.min(axis=0), [-1.0, -2.0, 0.0])
    np.testing.assert_array_equal(mesh.vertices.max(axis=0), [1.0, 2.0, 1.0])


def test_cylinder_is_a_regular_prism() -> None:
    mesh = shapes.cylinder(1.0, 3.0)
    sides = (len(mesh.faces)) // 4
    ring = 0.5 * sides * math.sin(2 * math.pi / sides)  # area of the regular polygon inscribed in the unit circle
    assert volume(mesh) == pytest.approx(3.0 * ring, rel=SMALL)
    assert 1.0 - math.cos(math.pi / sides) < 0.032 / 8  # m: the rule that sets the fineness
    np.testing.assert_allclose([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)], [[-1, -1, 0], [1, 1, 3]], atol=SMALL)


def test_dihedral_opens_north_with_an_upright_fold() -> None:
    mesh = shapes.dihedral(1.5, 2.0)
    normals, areas = normals_and_areas(mesh)
    s = math.sqrt(0.5)
    np.testing.assert_allclose(np.sort(normals[:, 0]), [-s, -s, s, s], atol=SMALL)
    np.testing.assert_allclose(normals[:, 1], s, atol=SMALL)
    assert areas.sum() == pytest.approx(2 * 1.5 * 2.0, rel=SMALL)
    for normal, face in zip(normals, mesh.faces, strict=True):  # each plate faces the other one
        assert np.dot(normal, [0.0, 1.0, 0.0] - mesh.vertices[face].mean(axis=0)) > 0.0
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [-1.5 * s, 0.0, -1.0], atol=SMALL)
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [1.5 * s, 1.5 * s, 1.0], atol=SMALL)


def test_trihedral_opens_north_on_a_level_axis() -> None:
    mesh = shapes.trihedral(2.0)
    normals, areas = normals_and_areas(mesh)
    np.testing.assert_allclose(normals @ normals.T, np.eye(3), atol=SMALL)
    np.testing.assert_allclose(normals @ [0.0, 1.0, 0.0], 1 / math.sqrt(3), atol=SMALL)  # 54.7 degrees off each plate
    np.testing.assert_allclose(areas, 2.0, rtol=SMALL)  # right triangles with legs of 2 m
    np.testing.assert_array_equal(mesh.vertices[0], 0.0)  # the apex
    assert all(0 in face for face in mesh.faces)


def test_hull_fills_its_sizes_with_the_bow_north() -> None:
    mesh = shapes.hull(100.0, 16.0, 20.0)
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [-8.0, -50.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [8.0, 50.0, 20.0], atol=1e-12)
    bow = mesh.vertices[mesh.vertices[:, 1] > 49.999]
    assert np.abs(bow[:, 0]).max() == 0.0  # pointed
    assert mesh.vertices[mesh.vertices[:, 2] == 0.0, 1].max() == pytest.approx(46.0)  # the stem rakes, by 8 % of 50 m
    tall = mesh.vertices[mesh.vertices[:, 2] > 19.999]
    assert tall[:, 1].max() < 0.0  # the house stands aft
    mirrored = {tuple(v) for v in (mesh.vertices * [-1, 1, 1] + 0.0).round(9)}
    assert mirrored == {tuple(v) for v in (mesh.vertices + 0.0).round(9)}


# Types of hulls: closed parts without coincident facets, their sizes, their draws, and an echo at every aspect.
DRAWN = [name for name in HULL_TYPES if name != PLAIN]
SIZES = {"cargo": (103.0, 16.0, 20.0), "ferry": (90.0, 16.0, 14.0), "fishing": (25.0, 7.0, 8.0), "yacht": (12.0, 3.6, 2.5),
         "pilot": (14.0, 4.4, 4.2)}  # fmt: skip


def hull_table(hull_type: str, **more: Any) -> dict[str, Any]:
    sizes = dict(zip(("length_m", "beam_m", "height_m"), SIZES.get(hull_type, (90.0, 16.0, 14.0)), strict=True))
    return {"name": "ship", "shape": "hull", "hull_type": hull_type, **sizes, **more}


@pytest.mark.parametrize("hull_type", DRAWN)
def test_parts_are_closed_wound_outward_and_nowhere_coincident(hull_type: str) -> None:
    for seed in range(4):
        mesh = hull_mesh(hull_type, seed, *SIZES[hull_type])
        outside = outward_side(mesh)
        assert open_edges(mesh) == 0 and (outside == 1).all()


@pytest.mark.parametrize("hull_type", DRAWN)
def test_the_waterline_lies_at_height_0_and_sizes_are_kept(hull_type: str) -> None:
    """The deck has the length and the beam, some roof the height, which masts exceed; the bottom is below the waterline."""
    for seed in range(4):
        length, beam, height = SIZES[hull_type]
        mesh = hull_mesh(hull_type, seed, length, beam, height)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        np.testing.assert_allclose([high[0], -low[0], high[1], -low[1]], [beam / 2, beam / 2, length / 2, length / 2])
        assert 0.2 * beam < -low[2] < 0.5 * beam and high[2] > 1.2 * height
        assert (np.abs(mesh.vertices[:, 2] - height) < 1e-9).any() and (mesh.vertices[:, 2] == 0.0).any()


@pytest.mark.parametrize("hull_type", DRAWN)
def test_its_sides_are_flared(hull_type: str) -> None:
    """Sides above the waterline look down: by 12 degrees and more at the bow, hardly at all along a ship's middle."""
    mesh = hull_mesh(hull_type, 0, 100.0, 16.0, 14.0)
    corners = mesh.vertices[mesh.faces]
    side = (corners[..., 2].min(axis=1) == 0.0) & (corners[..., 1].min(axis=1) > -49.0)
    normals, _ = normals_and_areas(mesh)
    ahead = corners[side, :, 1].mean(axis=1)
    down = -normals[side, 2]
    assert (down > 0.0).all() and (down[(ahead > 25.0) & (ahead < 45.0)] > 0.2).any()
    assert hull_type not in ("cargo", "ferry") or (down[np.abs(ahead) < 5.0] < 0.02).all()


def test_a_seed_draws_the_parts_and_the_plain_hull_has_none() -> None:
    cargo = [hull_mesh("cargo", seed, *SIZES["cargo"]) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(cargo[0].vertices, cargo[1].vertices)
    assert cargo[0].vertices.shape != cargo[2].vertices.shape or (cargo[0].vertices != cargo[2].vertices).any()
    np.testing.assert_array_equal(hull_mesh(PLAIN, 3, 90.0, 16.0, 14.0).vertices, shapes.hull(90.0, 16.0, 14.0).vertices)


def sections(hull_type: str, sizes_of: str) -> Floats:
    """Cross-sections [m^2] in free space, 2 km off, at 12 aspects that are no round numbers."""
    made = scene([hull_table(sizes_of) | {"hull_type": hull_type}])
    body, turn = OpticalBody.of(made.bodies[0], made.radar, 3), np.deg2rad(np.arange(12) * 30.0 + 7.3)
    return np.array([cross_section(body, np.array([2000.0 * np.sin(a), 2000.0 * np.cos(a), 15.0])) for a in turn])


@pytest.mark.parametrize("hull_type", DRAWN)
def test_there_is_an_echo_at_every_aspect(hull_type: str) -> None:
    """The weakest tenth is within 20 dB of the median: Rayleigh's sum of many alike centres would have 8 dB."""
    drawn = sections(hull_type, hull_type)
    assert decibels(float(np.percentile(drawn, 10) / np.median(drawn))) > -20.0


def test_a_plain_hull_hardly_has_one() -> None:
    """Of the same size its median is 20 dB and more below that of a ferry."""
    assert decibels(float(np.median(sections("ferry", "ferry")) / np.median(sections(PLAIN, "ferry")))) > 20.0


def test_small_sizes_make_a_hull_too() -> None:
    for name in DRAWN:
        mesh = hull_mesh(name, 0, 2.0, 0.8, 0.7)
        assert open_edges(mesh) == 0 and math.isfinite(float(mesh.vertices.sum()))


def test_keys_are_checked() -> None:
    box = {"name": "b", "shape": "box", "length_m": 3, "width_m": 2, "height_m": 1, "hull_type": "cargo"}
    with pytest.raises(rs.SceneError, match=r'hull_type: shape = "box" has none; remove it, or take shape = "hull"'):
        scene([box])
    with pytest.raises(rs.SceneError, match="hull_seed: a plain hull has no parts to draw"):
        scene([hull_table(PLAIN, hull_seed=2)])
    with pytest.raises(rs.SceneError, match="hull_type"):
        scene([hull_table("tug")])


def test_the_loader_draws_by_seed_and_sisters_share_a_mesh() -> None:
    tables = [hull_table("cargo", hull_seed=seed) | {"name": str(n)} for n, seed in enumerate((0, 5, 5))]
    bodies = scene(tables).bodies
    assert bodies[1].mesh is bodies[2].mesh and bodies[0].mesh is not bodies[1].mesh
    assert bodies[0].is_vessel and abs(float(bodies[0].reference[2])) == 0.0
