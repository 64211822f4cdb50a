"""The echoes of planar pieces against closed forms, and against brute force by narrow beams."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.special import j0

from radar_service.scattering.physical_optics import plane_echoes
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
from radar_service.scattering.physical_optics.plane_echoes import EdgeLimits, Longest, PlaneEchoes, PlaneOptics, Wave
from radar_service.scattering.physical_optics.plating import SPREAD, PlatedWalls
from radar_service.world.body import Mesh, Plating
from radar_service.world.poses import MAP_POSE
from radar_service.world.shapes import hull_mesh
from tests.reference import narrow_beams
from tests.scattering.physical_optics.meshes import WAVELENGTH, decibels, dihedral, plate, sheet
from tests.scattering.physical_optics.test_planar_pieces import split, welded

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
EARTH = 4.0 / 3.0 * 6_371_000.0
BY_SEA = -0.8  # coefficient of reflection


def optics(mesh: Mesh, bounces: int = 3, polarization: str = "h", wavelength: float = WAVELENGTH) -> PlaneOptics:
    """Pieces of which nothing is left out."""
    return PlaneOptics(PlanarPieces.of(mesh, outward_side(mesh)), Wave(wavelength, polarization), bounces, 0.0)


def legs(antenna: Floats, water: float | None = None, earth_radius: float = math.inf) -> tuple[BodyLeg, ...]:
    """The legs to a body at the origin, over the sea where there is water, at a height [m]."""
    height = np.array([0.0, 0.0, water or 0.0])
    pose = dataclasses.replace(MAP_POSE, position=MAP_POSE.position - height)
    ways = (False,) if water is None else (False, True)
    return tuple(BodyLeg(by_sea, pose, antenna - height, earth_radius) for by_sea in ways)


def seen(body: PlaneOptics, antenna: Floats, water: float | None = None, longest: float = 1.0) -> PlaneEchoes:
    return body.echoes(legs(antenna, water), -math.inf if water is None else water, Longest(longest))


def cross_section_db(body: PlaneOptics, toward: Floats, longest: float = 1.0) -> float:
    """Of all that a body returns to 3 km [dBsm]."""
    return decibels(np.abs(seen(body, 3000.0 * toward / np.linalg.norm(toward), longest=longest).amplitude.sum()) ** 2)


def profile(echoes: PlaneEchoes, antenna: Floats, water: float, first: float, count: int) -> Complexes:
    """What range cells of 7.5 m, 1.875 m apart, see over the sea."""
    image = antenna * (1, 1, -1) + (0, 0, 2.0 * water)
    direct, by_sea = (np.linalg.norm(echoes.place - eye, axis=1) for eye in (antenna, image))
    half_path = np.choose(echoes.ways, [direct, (direct + by_sea) / 2.0, by_sea])
    away = (first + 1.875 * np.arange(count)[:, None] - half_path) / 7.5
    return np.asarray(np.exp(-2.0 * np.log(2.0) * away**2) @ (echoes.amplitude * np.power(BY_SEA, echoes.ways)))


def corner(a: float, sides: int) -> Mesh:
    """So many squares between the positive axes."""
    x, y, z = a * np.eye(3)
    zero = [0, 0, 0]
    return welded(np.concatenate([sheet(zero, x, z, 1), sheet(zero, z, y, 1), sheet(zero, y, x, 1)][:sides]))


@pytest.mark.parametrize(("kind", "size"), [("fishing", (30.0, 6.0, 6.3)), ("ferry", (120.0, 22.0, 25.0))])
def test_triangles_in_four_and_from_other_corners_change_nothing(kind: str, size: tuple[float, float, float]) -> None:
    """At random aspects in both bands, leaning or not, over the sea or not: 0.05 dB of the power and of the largest cell. The
    first one is a ferry abeam, so near that the phase's gradient along its walls changes by half."""
    mesh, rng = hull_mesh(kind, 1, *size), np.random.default_rng(1)
    meshes = mesh, split(mesh), Mesh(mesh.vertices, np.roll(mesh.faces, 1, axis=1))
    pieces = [PlanarPieces.of(each, outward_side(each)) for each in meshes]
    for draw in range(6):
        azimuth, distance, height = math.radians(90.62555), 888.217, 22.77
        lean, band, water = np.array([7.178458, 3.297429]), 0.098293, 0.0 if draw % 2 == 0 else None
        if draw:
            azimuth, distance, height = rng.uniform(0.0, 2.0 * np.pi), 300.0 * 20.0 ** rng.random(), rng.uniform(5.0, 40.0)
            lean, band = rng.uniform(-15.0, 15.0, 2) * (draw % 3 > 0), [0.098293, WAVELENGTH][draw // 2 % 2]
        antenna = np.array([distance * math.sin(azimuth), distance * math.cos(azimuth), height])
        turned, levels = Rotation.from_euler("xy", lean, degrees=True).as_matrix(), []
        for each in pieces:
            body = PlaneOptics.of(each, Wave(band, "hv"[draw % 2]), 3, 7.5).rotated(turned)
            echoes = seen(body, antenna, water, min(4.5, size[0] / 9.0))
            cells = np.abs(profile(echoes, antenna, water or 0.0, distance - 150.0, 170)) ** 2
            levels.append([decibels(cells.sum()), decibels(cells.max())])
        assert np.ptp(levels, axis=0).max() < 0.05, f"draw {draw}"


def test_what_is_faint_is_left_out_by_its_share_of_the_usual_cell() -> None:
    """A cargo ship at 12 aspects: the median of errors of the largest cell is below 0.005, with half of the echoes."""
    body = optics(hull_mesh("cargo", 1, 150.0, 26.0, 20.0))
    quick = PlaneOptics.of(body.pieces, body.wave, 3, 7.5)
    errors, counts = [], []
    for azimuth in np.arange(12) * 0.53:
        antenna = np.array([1500.0 * np.sin(azimuth), 1500.0 * np.cos(azimuth), 15.0])
        both = [seen(each, antenna, 0.0, 2.0) for each in (body, quick)]
        exact, faster = (profile(each, antenna, 0.0, 1400.0, 110) for each in both)
        errors.append(np.abs(faster - exact).max() / np.abs(exact).max())
        counts.append(len(both[1].ways) / len(both[0].ways))
    assert np.median(errors) < 0.005 and max(errors) < 0.05
    assert np.mean(counts) < 0.6


@pytest.mark.parametrize("polarization", ["h", pytest.param("v", marks=pytest.mark.study)])
def test_a_boat_meets_brute_force(polarization: str) -> None:
    """A house with a mast on a deck, leaning toward the antenna, half under water, over the sea by four paths in S band. Its
    cells have 0.4 to 1 m, and beams of 4 mm at rims err by 0.02 m at most. (A deck at grazing has noisier rims.)"""
    deck = sheet([-1, -2, 0.4], [2, 0, 0], [0, 4, 0], 1)
    house = np.concatenate(
        [sheet([-0.6, 0, 0.3], [1.2, 0, 0], [0.05, 0.02, 1.0], 1), sheet([-0.6, 0, 0.3], [0, 1, 0], [0.02, 0.03, 1.1], 1)]
    )
    mast = np.concatenate(
        [sheet([0.1, 0.5, 0.4], [0.2, 0, 0], [0, 0, 1.6], 1), sheet([0.1, 0.5, 0.4], [0, 0.2, 0], [0, 0, 1.6], 1)]
    )
    roll = np.array([[1.0, 0.0, -0.15], [0.0, 1.0, -0.25], [0.15, 0.25, 1.0]])
    triangles = np.concatenate([deck, house, mast, sheet([-1, -2, -0.3], [2, 0, 0], [0, 0, 0.7], 1)]) @ roll.T
    antenna = np.array([-120.0, -260.0, 15.0])
    brute = narrow_beams.profile(triangles, antenna, 0.02, polarization=polarization, water=0.05, wavelength=0.0983)
    exact = brute.cells(7.5, 1.875, 260.0, 30, BY_SEA)
    fields = profile(seen(optics(welded(triangles), 3, polarization, 0.0983), antenna, 0.05), antenna, 0.05, 260.0, 30)
    assert np.abs(fields - exact).max() < 0.02 and np.abs(exact).max() > 0.3


@pytest.mark.parametrize(
    "screen",
    [
        sheet([1.1, 1.0, 0.1], [0.3, -0.1, 0.05], [0.05, 0.02, 0.4], 1),
        sheet([0.05, 0.05, 0.1], [0.2, 0.21, 0.0], [0.0, 0.0, 0.4], 1),
    ],
    ids=["before one wall", "between the walls"],
)
def test_screens_take_from_a_corner_what_brute_force_says(screen: Floats) -> None:
    """A dihedral of 0.6 m from 200 m, a screen aslant before one wall, or edge-on between both: to 1 % of the whole corner."""
    walls = np.concatenate([sheet([0, 0, 0], [0.6, 0, 0], [0, 0, 0.6], 1), sheet([0, 0, 0], [0, 0, 0.6], [0, 0.6, 0], 1)])
    antenna = 200.0 * np.array([1.0, 1.02, 0.01]) / np.sqrt(2.0)
    whole, shaded = (
        seen(optics(welded(mesh)), antenna).amplitude.sum() for mesh in (walls, np.concatenate([walls, screen]))
    )
    brute = narrow_beams.profile(np.concatenate([walls, screen]), antenna, 0.008).field[0].sum()
    assert abs(shaded - brute) < 0.01 * abs(whole)
    assert abs(shaded - whole) > 0.2 * abs(whole)


def test_no_ray_comes_through_the_bottom_of_a_hull() -> None:
    """A house on a flat hull, 60 m off: rays of the image that would rise inside of the hull stop at its side, on their way down
    to the sea. They would light 0.3 m of the wall's 1.6 m."""
    x, y, z = np.array([8.0, 0, 0]), np.array([0, 5.0, 0]), np.array([0, 0, 0.8])
    foot = np.array([-4.0, -2.5, -0.5])
    hull = np.concatenate([sheet(foot, x, z, 1), sheet(foot + z, x, y, 1), sheet(foot + y, z, x, 1), sheet(foot, y, x, 1),
                           sheet(foot, z, y, 1), sheet(foot + x, y, z, 1)])  # fmt: skip
    mesh = np.concatenate([hull, sheet([-1.0, 0.0, 0.3], [2.0, 0, 0], [0, 0, 1.6], 1)])
    antenna = np.array([0.7, -60.0, 15.0])
    echoes = seen(optics(welded(mesh), 1), antenna, 0.0, 0.3)
    brute = narrow_beams.profile(mesh, antenna, 0.04, bounces=1, water=0.0).field.sum(axis=1)
    for way in range(3):
        assert abs(echoes.amplitude[echoes.ways == way].sum() - brute[way]) < 0.01 * np.abs(brute).max()


@pytest.mark.study
@pytest.mark.parametrize(("kind", "size", "width"), [("pilot", (12.0, 3.0, 4.3), 0.06), ("cargo", (150.0, 26.0, 20.0), 0.2)])
@pytest.mark.parametrize("azimuth_deg", [51.0, 201.0])
def test_hulls_meet_brute_force(kind: str, size: tuple[float, float, float], width: float, azimuth_deg: float) -> None:
    """All that counts of hulls over the sea: 0.03 of the largest cell, of which the brute force itself has 0.01 to 0.02."""
    azimuth, mesh = np.deg2rad(azimuth_deg), hull_mesh(kind, 1, *size)
    antenna = np.array([1900.0 * np.sin(azimuth), 1900.0 * np.cos(azimuth), 15.0])
    body = PlaneOptics.of(PlanarPieces.of(mesh, outward_side(mesh)), Wave(WAVELENGTH, "h"), 3, 7.5)
    exact = narrow_beams.profile(mesh.vertices[mesh.faces], antenna, width, water=0.0).cells(7.5, 1.875, 1800.0, 110, BY_SEA)
    fields = profile(seen(body, antenna, 0.0, 2.0), antenna, 0.0, 1800.0, 110)
    assert np.abs(fields - exact).max() < 0.03 * np.abs(exact).max()


def test_the_curved_earth_lengthens_ways_as_legs_do() -> None:
    """A plate 8 km off, 5 m over the sea: each echo has the phase of its legs, out and back, to 0.01 rad."""
    plate = corner(0.6, 1)
    mesh, antenna = Mesh(plate.vertices + (0, 0, 5.0), plate.faces), np.array([0.0, 8000.0, 15.0])
    ways = legs(antenna, 0.0, EARTH)
    echoes = optics(mesh, 1).echoes(ways, 0.0, Longest(0.3))
    lengths = np.array([leg.length(echoes.place) for leg in ways])
    path = np.choose(echoes.ways, [2.0 * lengths[0], lengths.sum(axis=0), 2.0 * lengths[1]])
    flat = optics(mesh, 1).echoes(legs(antenna, 0.0), 0.0, Longest(0.3))
    assert set(echoes.ways) == {0, 1, 2} and len(echoes.ways) == len(flat.ways)
    relative = echoes.amplitude * np.exp(2j * np.pi / WAVELENGTH * path)
    for way in range(3):
        total = relative[echoes.ways == way].sum()
        assert abs(total) > 0.5 * np.abs(relative[echoes.ways == way]).sum()  # a small plate: one phase, but for the sign


@pytest.mark.parametrize("earth_radius", [math.inf, EARTH])
def test_a_body_of_planes_has_the_centres_of_its_echoes(earth_radius: float) -> None:
    """A pilot boat 1.5 km off, leaning: cells of the sums at nodes are those of the echoes, as weights are nearly linear
    over 1.3 m: 2 ln 2 (0.67 / 7.5)^2 = 0.01 of strong echoes that cancel. Each surface of half the power takes 3 dB."""
    mesh, antenna = hull_mesh("pilot", 1, 12.0, 3.0, 4.3), np.array([900.0, 1200.0, 15.0])
    lean = np.array([[1.0, 0.0, 0.05], [0.0, 1.0, 0.02], [-0.05, -0.02, 1.0]])
    limits = EdgeLimits(7.5, math.radians(1.2), WAVELENGTH, 12.0)
    body = OpticalBody(mesh, optics(mesh, 1), limits, 0.5).leaning(lean)
    ways = legs(antenna, 0.0, earth_radius)
    echoes = body.optics.echoes(ways, 0.0, Longest(1.0))
    paths = body.echoes(ways, 0.0)
    assert [path.path for path in paths] == [0, 1, 2]
    for path in paths:
        there, nodes = ([leg.length(points) for leg in ways] for points in (echoes.place, path.position))
        half, at = (lengths[path.path // 2] + lengths[(path.path + 1) // 2] for lengths in (there, nodes))
        cells = 1475.0 + 1.875 * np.arange(40)[:, None]
        weights = [np.exp(-2.0 * np.log(2.0) * ((cells - length / 2.0) / 7.5) ** 2) for length in (half, at)]
        exact = weights[0] @ np.where(echoes.ways == path.path, echoes.amplitude, 0.0)
        summed = weights[1] @ (path.amplitude * np.exp(-2j * np.pi / WAVELENGTH * at)) / 0.5**0.5
        assert np.abs(summed - exact).max() < 0.02 * np.abs(exact).max()
        assert len(path.amplitude) < len(echoes.ways)


def test_bounces_of_surfaces_that_cross_everywhere_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred large triangles that cross each other: after so much work the rest is left out, with a warning."""
    monkeypatch.setattr(plane_echoes, "MOST_WORK", 20_000)
    monkeypatch.setattr(plane_echoes, "MOST_OF_PIECE", 1)
    tangle = welded(10.0 * np.random.default_rng(1).random((100, 3, 3)))
    with pytest.warns(RuntimeWarning, match="metal of .* pieces: an aspect takes over 20000 cuts"):
        assert np.isfinite(seen(optics(tangle), np.array([500.0, 100.0, 15.0])).amplitude).all()


def test_an_aspect_from_amid_the_body_is_finite() -> None:
    mesh = hull_mesh("pilot", 1, 12.0, 3.0, 4.3)
    for antenna in ([0.0, 0.0, 1.0], [0.0, 0.0, 20.0], [1.0, 5.0, 3.0]):
        assert np.isfinite(seen(optics(mesh), np.array(antenna), 0.0).amplitude).all()


def plated(mesh: Mesh, depth: float, bounces: int = 1) -> PlaneOptics:
    """Pieces dented between frames 0.7 m apart."""
    body = optics(mesh, bounces)
    walls = PlatedWalls.of(mesh, body.pieces.normal, body.pieces.spans, Plating(depth, 0.7, 2.5, 0), WAVELENGTH)
    return dataclasses.replace(body, walls=walls)


@pytest.mark.parametrize("turn_deg", [0.0, 0.4, 1.3, 2.6, -5.0, 6.5])
def test_a_dented_wall_is_the_sum_of_its_elements(turn_deg: float) -> None:
    """A wall of 30 x 6 m 2 km off as elements of 17 mm at their dented positions: 0.05 dB at its normal, 0.001 of the flat wall's
    largest field off it. Leaning it has the same field from where it sees the antenna alike."""
    body, turn = plated(welded(plate(30.0, 6.0, 1)), 0.004), math.radians(turn_deg)
    antenna, walls = 2000.0 * np.array([np.sin(turn), np.cos(turn), 0.002]), body.walls
    assert walls is not None
    x, z = (grid.ravel() for grid in np.meshgrid((np.arange(1800) - 899.5) / 60.0, (np.arange(360) - 179.5) / 60.0))
    bay, tier = np.floor(x / 0.7).astype(int) - walls.first[0], np.floor(z / 2.5 - 0.5).astype(int) - walls.first[1]
    low, high = (walls.drawn[1, bay, tier + n] for n in (0, 1))  # of walls that face along y
    deep = (low + (z / 2.5 - 0.5) % 1.0 * (high - low)) * np.sin(np.pi * x / 0.7) ** 2
    way = antenna - np.stack([x, -deep, z], axis=1)
    length = np.linalg.norm(way, axis=1)
    most = 2.0 * np.sqrt(np.pi) / WAVELENGTH
    exact = abs((most / 3600.0 * way[:, 1] / length * np.exp(-4j * np.pi / WAVELENGTH * length)).sum())
    field = abs(seen(body, antenna, longest=1.8).amplitude.sum())
    assert abs(field - exact) < (0.006 * exact if abs(turn_deg) < 0.5 else 0.001 * 180.0 * most)
    lean = Rotation.from_euler("yx", [7.0, -5.0], degrees=True).as_matrix()
    leaning = seen(body.rotated(lean), lean @ antenna, longest=1.8).amplitude.sum()
    assert abs(leaning) == pytest.approx(field, abs=1e-6 * 180.0 * most)


def test_a_bounce_keeps_the_coherent_part_of_each_plated_wall() -> None:
    """A dihedral at 45 degrees, one wall or both dented: J0(k w cos 45) each, averaged over depths with their phases."""
    body, depth = (
        plated(welded(dihedral(4.0, 4.0, 1)), 0.006, 2),
        0.006 * (1 + SPREAD * np.sqrt(3) * np.linspace(-1, 1, 2001)),
    )
    assert body.walls is not None
    axis, antenna = body.walls.axis, np.array([1414.0, 1414.0, 4.0])
    masks = (-1 + 0 * axis, np.where(np.abs(body.pieces.normal[:, 0]) > 0.5, axis, -1), axis)
    every = (seen(dataclasses.replace(body, walls=dataclasses.replace(body.walls, axis=each)), antenna) for each in masks)
    none, one, both = (abs(each.amplitude[each.surfaces == 2].sum()) for each in every)
    phase = 2.0 * np.pi / WAVELENGTH * np.cos(np.pi / 4.0) * depth
    kept = abs(np.mean(j0(phase) * np.exp(1j * phase)))
    assert (one / none, both / none) == pytest.approx((kept, kept**2), abs=2e-4)


@pytest.mark.parametrize("gap", [0.0, 1e-4, 1e-2], ids=["in one place", "0.1 mm", "10 mm"])
def test_of_two_layers_one_reflects(gap: float) -> None:
    """A plate of 1 m^2, and 0.36 m^2 before it, half of which reach beyond. Over 1.3 m the phase bends by 0.1 rad at 3 km."""
    plate, other = corner(1.0, 1), corner(0.6, 1)
    faces = np.concatenate([plate.faces, other.faces + len(plate.vertices)])
    double = Mesh(np.concatenate([plate.vertices, other.vertices + [0.7, gap, 0.2]]), faces)
    surface = (
        10.0 ** (cross_section_db(optics(double), np.array([0.0, 1.0, 0.0])) / 20.0) * WAVELENGTH / np.sqrt(4.0 * np.pi)
    )
    assert surface == pytest.approx(abs(0.82 + 0.36 * np.exp(4j * np.pi * gap / WAVELENGTH)), rel=0.03)


@pytest.mark.parametrize("bend", [-2e-4, 2e-4], ids=["hides nothing beside it", "lights nothing beside it"])
def test_a_bent_piece_seen_edge_on_leaves_a_plate_beside_it_alone(bend: float) -> None:
    """Of 0.3 m^2, two corners 0.2 mm off the diagonal, seen from 0.05 m off its plane: as a line that bends, not as an area."""
    along, off, away = np.array([[0.8, 0.0, 0.6], [-0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])
    a, b, c, d = -0.5 * along, bend * off - 0.2 * along - 0.3 * away, 0.5 * along, bend * off + 0.2 * along + 0.3 * away
    screen = np.array([[a, b, c], [a, c, d]])
    behind = plate(0.1, 0.1, 1) + 5.0 * away - 0.2 * np.sign(bend) * off
    both = optics(welded(np.concatenate([screen, behind])), 2)
    with_it, alone = (seen(body, -1000.0 * away - 0.05 * off) for body in (both, optics(welded(behind), 2)))
    assert len(both.pieces) == 4  # two of two sides
    assert with_it.amplitude[with_it.place[:, 1] > 1.0].sum() == pytest.approx(alone.amplitude.sum(), rel=1e-9)


def test_a_usual_cell_of_what_has_no_end_is_found_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rough sheet, each part of which hides others: what a usual cell may take bounds it, without a warning."""
    across, along = np.meshgrid(np.linspace(0.0, 30.0, 40), np.linspace(0.0, 10.0, 40))
    points = np.stack([across, along, np.random.default_rng(1).uniform(0.0, 2.0, across.shape)], axis=2)
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    sheet_of = np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)
    pieces = PlanarPieces.of(welded(sheet_of), np.zeros(len(sheet_of), dtype=np.int8))
    whole = PlaneOptics.of(pieces, Wave(WAVELENGTH, "h"), 3, 7.5)
    monkeypatch.setattr(plane_echoes, "WORK_OF_LEVEL", 3000)
    assert 0.0 < PlaneOptics.of(pieces, Wave(WAVELENGTH, "h"), 3, 7.5).level < whole.level
