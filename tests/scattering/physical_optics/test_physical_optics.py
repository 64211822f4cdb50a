"""The short modules of scattering/physical_optics, each under its name."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.frames import wrap_angle
from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.body_legs import FLATTEST, BodyLeg, SeaField
from radar_service.scattering.physical_optics.cast_shadows import above_water, cut
from radar_service.scattering.physical_optics.mesh_quality import concave_sides, outward_side, shared_edges
from radar_service.scattering.physical_optics.picture import Picture, Windows
from radar_service.scattering.physical_optics.plane_echoes import (
    BEAM_SHARE,
    EXTENT_SHARE,
    MAX_BEND,
    RANGE_SHARE,
    EdgeLimits,
    PlaneEchoes,
)
from radar_service.scattering.physical_optics.plating import dark_share, upright_share, upright_warnings
from radar_service.scattering.physical_optics.scattering_centres import Lattice, flattest, over_nodes
from radar_service.world.body import Mesh
from radar_service.world.poses import MAP_POSE, BodyPose
from radar_service.world.shapes import box, dihedral, plate, sphere
from tests.reference.cast_shadows import homogeneous
from tests.reference.metal_on_water import EARTH, Setting
from tests.scattering.physical_optics.meshes import ODD, areas
from tests.scattering.physical_optics.test_mesh_quality import judged

# body_legs: legs in a body's frame: straight from an eye, and turned with the body.
ANTENNA = np.array([0.0, 0.0, 15.0])
MIDDLE = np.array([0.5, 3.0, 2.0])


@pytest.mark.parametrize("earth_radius", [np.inf, 8.5e6], ids=["flat", "curved"])
@pytest.mark.parametrize("by_sea", [False, True])
@pytest.mark.parametrize("heading", [0.0, 1.1])
def test_a_leg_is_straight_from_its_eye(by_sea: bool, heading: float, earth_radius: float) -> None:
    """Distances from the eye are lengths of the leg: over the flat sea to rounding, over the curved one, at 220 m, to 1e-5 m
    within 0.6 m of the middle: the sea spreads rays by some 1e-4 more, and they rise by 220 m / 8500 km more, over 1 m."""
    pose = BodyPose(np.array([130.0, 180.0, 1.0]), heading)
    leg = BodyLeg(by_sea, pose, ANTENNA, earth_radius)
    points = MIDDLE + np.random.default_rng(1).uniform(-0.6, 0.6, size=(20, 3))
    distance = np.linalg.norm(points - leg.eye(MIDDLE), axis=1)
    np.testing.assert_allclose(distance, leg.length(points), rtol=0.0, atol=1e-9 if earth_radius == np.inf else 5e-5)


# plane_echoes: how fine fields of metal have to be, by what bounds edges and cells.
LIMITS = EdgeLimits(range_cell=7.5, beamwidth=math.radians(1.2), wavelength=0.032, extent=100.0)


def test_cells_are_the_same_throughout_half_an_octave_and_bounded() -> None:
    """A quarter of the range cell far away, the share of the beam near by, of a small body its own."""
    near, same, next_one = LIMITS.cell(np.array([300.0, 350.0, 400.0]))
    assert near == same < next_one
    assert near == pytest.approx(BEAM_SHARE * math.radians(1.2) * 2.0**8)
    assert LIMITS.cell(np.array(50_000.0)) == RANGE_SHARE * 7.5
    assert LIMITS._replace(extent=2.0).cell(np.array(50_000.0)) == EXTENT_SHARE * 2.0


@pytest.mark.parametrize("distance", [100.0, 1000.0, 4000.0])
def test_over_half_the_longest_edge_the_two_way_phase_bends_by_the_limit(distance: float) -> None:
    half = LIMITS.longest.bend * math.sqrt(distance) / 2.0
    there = 2.0 * math.pi / 0.032 * 2.0 * (math.hypot(distance, half) - distance)
    assert there == pytest.approx(MAX_BEND, rel=1e-3)


def test_coherence_is_the_longer_of_cell_and_edge() -> None:
    for nearest in (20.0, 500.0, 20_000.0):
        edge, wide, bend = LIMITS.longest
        longest = min(edge, wide * nearest, bend * math.sqrt(nearest))
        assert LIMITS.coherence(nearest) == max(float(LIMITS.cell(np.array(nearest))), longest)


# picture: points and hulls in the antenna's picture, directly and by the sea.
FLAT = Picture(ANTENNA, np.inf, False)


@pytest.mark.parametrize("by_sea", [False, True])
@pytest.mark.parametrize("earth", [EARTH, np.inf])
def test_points_lie_as_in_the_oracles_picture(by_sea: bool, earth: float) -> None:
    """To 0.2 mm at up to 8 km: the cubic takes angles at the sea as small where the oracle takes their tangents."""
    rng = np.random.default_rng(1)
    points = np.stack([rng.uniform(-500, 500, 200), rng.uniform(100, 8000, 200), rng.uniform(0.0, 30.0, 200)], axis=1)
    setting = Setting(wavelength=0.1, antenna_height=15.0, earth_radius=earth)
    exact = homogeneous(points, np.array([0.0, 1.0]), setting, by_sea)
    virtual = Picture(ANTENNA, earth, by_sea).virtual(points)
    np.testing.assert_allclose(virtual[:, [0, 2, 1]], exact, atol=2e-4)


@pytest.mark.parametrize("by_sea", [False, True])
def test_windows_hold_their_hulls(by_sea: bool) -> None:
    """100 hulls of 8 points, each with 200 points within."""
    rng, picture = np.random.default_rng(2), Picture(ANTENNA, EARTH, by_sea)
    for _ in range(100):
        middle = np.array([rng.uniform(-300, 300), rng.uniform(-300, 3000), 0.0])
        corners = middle + rng.uniform(-1.0, 1.0, (8, 3)) * rng.uniform(1.0, 60.0) * (1.0, 1.0, 0.3)
        share = rng.dirichlet(np.ones(8), 200)
        inside = share @ corners
        inside = inside[inside[:, 2] > 0.0]
        hull, each = Windows.of(corners[None], picture), Windows.of(inside[:, None], picture)
        aside = np.abs(wrap_angle(each.middle - hull.middle))
        held = (aside <= hull.half + 1e-9) & (each.low >= hull.low - 1e-9) & (each.high <= hull.high + 1e-9)  # rounding
        assert (held & (each.nearest >= hull.nearest - 1e-6) & (each.farthest <= hull.farthest + 1e-6)).all()


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.0), (0.0, -300.0, 0.0)], ids=["about", "beside", "behind"])
def test_windows_hold_what_surrounds_the_antenna(place: Floats) -> None:
    """A ring of 20 m about the antenna fills all bearings; one behind it none of those ahead."""
    angle = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    ring = np.stack([20.0 * np.sin(angle), 20.0 * np.cos(angle), 20.0 + 0.0 * angle], axis=1) + place
    ahead, around = Windows.of(np.array([[[-2.0, 500.0, 0.0], [2.0, 500.0, 10.0]]]), FLAT), Windows.of(ring[None], FLAT)
    aside = np.abs(wrap_angle(around.middle - ahead.middle))
    assert bool(aside[0] <= around.half[0] + ahead.half[0]) == (place[1] > -100.0)


# scattering_centres: what legs weigh fields by, over what the nodes of a lattice have.
POINTS = np.array([[0.0, 0.0, 0.3], [1.0, 2.0, 1.0], [0.5, -1.0, 2.9]])
ENDS = np.array([[0.3, 0.3], [0.2, 1.8], [2.9, 2.9]])  # m: of a bounce both differ
ECHOES = PlaneEchoes(POINTS, ENDS, np.ones(3, dtype=np.complex128), np.zeros(3, dtype=np.int64), np.array([1, 2, 1]))
LATTICE = Lattice.over(POINTS, np.full(3, 1.0), 1.5, 0.0)


def leg(by_sea: bool, distance: float, earth_radius: float) -> BodyLeg:
    return BodyLeg(by_sea, MAP_POSE, np.array([0.0, distance, 15.0]), earth_radius)


def test_a_leg_alone_and_a_sea_that_lowers_little_weigh_nothing() -> None:
    assert over_nodes((leg(False, 1e3, np.inf),), LATTICE, ECHOES) == [1.0]
    assert over_nodes((leg(False, 1e3, np.inf), leg(True, 1e3, np.inf)), LATTICE, ECHOES) == [1.0] * 3
    assert flattest((leg(False, 1e3, np.inf),)) == np.inf
    assert flattest((leg(False, 1e3, np.inf), leg(True, 1e3, np.inf))) == FLATTEST


def test_the_curved_sea_weighs_points_over_what_nodes_share() -> None:
    """At 12 km its divergence bends over a cell's height: weights times what nodes share are those at the points."""
    legs = (leg(False, 12e3, 8.5e6), leg(True, 12e3, 8.5e6))
    for ways, weight in enumerate(over_nodes(legs, LATTICE, ECHOES)):
        shared = LATTICE.between(legs[1].weight(LATTICE.nodes) ** ways)
        np.testing.assert_allclose(weight * shared, legs[1].weight(POINTS) ** ways, rtol=1e-12)


def test_a_leg_for_all_paths_weighs_both_ends_of_bounces() -> None:
    height = np.linspace(0.0, 10.0, 50)
    field = SeaField(height, ((height / 10.0) ** 2).astype(np.complex128), True, 4.8, 3.0)
    alone = dataclasses.replace(leg(False, 12e3, 8.5e6), sea=field)
    (weight,) = over_nodes((alone,), LATTICE, ECHOES)
    np.testing.assert_allclose(
        weight * LATTICE.between(field.at(LATTICE.nodes[:, 2]) ** 2), field.at(ENDS).prod(axis=1), rtol=1e-9
    )
    assert flattest((alone,)) == pytest.approx(min(FLATTEST, 0.3 * 4.8))


# mesh_quality: shared edges, facing triangles and outer sides of shapes whose answers are known.
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


# cast_shadows: triangles cut along a line keep their area, and each part lies on its own side.
RNG = np.random.default_rng(4)


def test_parts_lie_on_their_sides_and_make_up_the_whole() -> None:
    """200 triangles at random, cut by a plane: areas to rounding. The parts face the way of their triangles."""
    corners = RNG.uniform(-1.0, 1.0, (200, 3, 3))
    normal = np.array([0.3, -0.5, 0.8])
    (kept, first), (lost, second) = cut(corners, corners @ normal - 0.1)
    assert (kept @ normal >= 0.1 - 1e-12).all() and (lost @ normal <= 0.1 + 1e-12).all()
    for parts, whole in ((kept, first), (lost, second)):
        ahead = [np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in (parts, corners[whole])]
        np.testing.assert_allclose(np.einsum("ij,ij->i", *ahead), 4.0 * areas(parts) * areas(corners[whole]), atol=1e-12)
    total = np.bincount(first, areas(kept), 200) + np.bincount(second, areas(lost), 200)
    np.testing.assert_allclose(total, areas(corners), rtol=1e-9)


def test_what_lies_on_one_side_stays_as_it_is() -> None:
    corners = RNG.uniform(0.0, 1.0, (5, 3, 3))
    (kept, first), (lost, second) = cut(corners, np.ones((5, 3)))
    assert np.array_equal(kept, corners) and first.tolist() == [0, 1, 2, 3, 4] and not len(lost) and not len(second)


def test_further_columns_are_interpolated_along_the_edges() -> None:
    """A column that is linear over the triangle stays so."""
    corners = RNG.uniform(-1.0, 1.0, (20, 3, 3))
    wide = np.concatenate([corners, corners @ np.array([[2.0], [-1.0], [0.5]])], axis=2)
    for part, _ in cut(wide, corners[..., 0]):
        assert part[..., 3] == pytest.approx(part[..., :3] @ np.array([2.0, -1.0, 0.5]), abs=1e-12)


def test_a_plate_keeps_what_rises_above_the_water() -> None:
    """4 m wide and high, about the origin: 0.4 m of it above water is 1.6 m^2, and no corner lies below."""
    a, b, c, d = np.array([[-2.0, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]])
    corners = np.array([[a, b, c], [a, c, d]])
    for rises in (0.4, 0.8, 1.3, 3.9):
        cut, origin = above_water(corners, 2.0 - rises)
        np.testing.assert_allclose(areas(cut).sum(), 4.0 * rises, rtol=1e-12)
        assert cut[:, :, 2].min() >= 2.0 - rises - 1e-12 and set(origin) <= {0, 1}


def test_bodies_above_the_water_are_left_as_they_are() -> None:
    corners = np.arange(18.0).reshape(2, 3, 3)
    cut, origin = above_water(corners, -np.inf)
    assert cut is corners and origin.tolist() == [0, 1]
    assert len(above_water(corners, 100.0)[0]) == 0


# plating: what `check` says of the walls of vessels.
UPRIGHT, DARK = "upright, over a reflecting sea", "flat plates: echo at broadside alone"
HULL = {"shape": "hull", "length_m": 60.0, "beam_m": 11.0, "height_m": 10.0}


def remarks(*, sea: bool = True, folder: Path | None = None, environment: dict[str, Any] | None = None, **body: Any) -> str:
    """Of one body by physical optics."""
    table = {"name": "b", "position_m": [0, 1500, 0], "scattering": "optics", **body}
    scene = rs.load_scene({"environment": {"multipath": sea, **(environment or {})}, "body": [table]}, folder=folder)
    return "\n".join([*judged(scene)["b"], *upright_warnings(scene.bodies, scene.environment)])


def test_plain_hulls_are_upright_and_dark_and_other_types_neither() -> None:
    plain = remarks(**HULL)
    assert UPRIGHT in plain and "seaway = true" in plain and DARK in plain and "hull_type" in plain
    for hull_type in ("cargo", "ferry", "fishing", "yacht", "pilot"):
        other = remarks(**HULL, hull_type=hull_type)
        assert UPRIGHT not in other and DARK not in other


@pytest.mark.parametrize(
    "change",
    [{"sea": False}, {"environment": {"sea_state": 3, "seaway": True}}, {"list_deg": 1.0}, {"material": "wood"}],
)
def test_the_corner_with_the_sea_is_gone(change: dict[str, Any]) -> None:
    """Over no sea, in a seaway, with a list, and of a material that hardly reflects."""
    assert UPRIGHT not in remarks(**HULL, **change)


def test_a_shipped_mesh_is_upright_but_not_dark() -> None:
    text = remarks(folder=Path(rs.__file__).parents[1] / "scenes", mesh="coaster.obj")
    assert UPRIGHT in text and DARK not in text


def test_many_upright_vessels_are_one_sentence() -> None:
    hulls = [{**HULL, "name": f"h{k}", "position_m": [300 * k, 1500, 0], "scattering": "optics"} for k in range(4)]
    scene = rs.load_scene({"environment": {"multipath": True}, "body": hulls})
    (text,) = upright_warnings(scene.bodies, scene.environment)
    assert text.startswith("h0, h1 and 2 more: metal, upright, over a reflecting sea: ")


def test_bodies_that_are_no_vessels_are_left_alone() -> None:
    text = remarks(shape="box", length_m=20.0, width_m=5.0, height_m=5.0)
    assert UPRIGHT not in text and DARK not in text


def test_shares_of_walls_whose_answers_are_known() -> None:
    """A box faces 4 of 36 sectors of 10 degrees, to an aspect or two; half its area leans by 1 degree."""
    angle = np.deg2rad([10.0, 100.0, 190.0, 280.0])
    box = np.column_stack([np.sin(angle), np.cos(angle), np.zeros(4)])
    assert dark_share(box) == pytest.approx(1.0 - 4.0 * 10.0 / 360.0, abs=0.006)
    assert dark_share(box[:1]) == pytest.approx(1.0 - 10.0 / 360.0, abs=0.003)
    leaning = box.copy()
    leaning[:2, 2] = np.sin(np.deg2rad(1.0))
    assert upright_share(leaning, np.array([3.0, 2.0, 4.0, 1.0])) == pytest.approx(0.5)
