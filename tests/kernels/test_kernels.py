"""The short modules of kernels, each under its name."""

import subprocess
import sys
from decimal import Decimal, localcontext
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.echo.block_geometry import BlockGeometry, ObservedEchoes
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.moving_beam import BeamTable
from radar_service.echo.range_history import parabola
from radar_service.kernels.library import KERNELS
from radar_service.numerics.frames import map_from_body, map_from_deck
from radar_service.numerics.types import Flags, Floats
from radar_service.receive.gridding import Kernel, KernelTable, spread, spread_moving
from radar_service.scattering.model import BodyEchoes
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.cast_shadows import CastShadows, Onlooker
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.scattering.physical_optics.plane_echoes import Wave
from radar_service.scattering.physical_optics.scattering_centres import Lattice
from radar_service.scattering.surface_sampling import Scatterers, sample_surface
from radar_service.trace.occluder import Occluder
from radar_service.trace.posed_occluders import OccluderKinds, PosedOccluders
from radar_service.trace.shadow_sectors import ShadowSectors, points_behind
from radar_service.trace.triangle_clusters import Test, TriangleClusters
from radar_service.world.body import Mesh
from radar_service.world.poses import BodyPose, PoseArrays
from radar_service.world.shapes import box
from tests.kernels.both import both
from tests.scenes import scene


# beam_weights: the kernel of beam weights against numpy.
@pytest.mark.parametrize(("count", "azimuths"), [(0, 4), (1, 1), (1, 17), (700, 16), (700, 3)])
def test_beam_weights_are_those_of_numpy(count: int, azimuths: int) -> None:
    """Also beyond the table's end, and near enough for the loss to change by a fifth. Bytes are equal."""
    draw, table = np.random.default_rng(18), BeamTable(lambda offset: np.cos(offset) ** 2, 0.03, 0.1, 0.02)
    boresight, azimuth = draw.uniform(-0.02, 0.02, azimuths), draw.uniform(-0.3, 0.3, count)
    changes, migration = draw.uniform(-0.01, 0.01, (count, azimuths)), draw.uniform(-9.0, 9.0, (count, azimuths))
    columns = [c.astype(np.float32) for c in (boresight, azimuth, changes, draw.uniform(0.0, 0.01, count), migration)]
    compiled, by_numpy = both(lambda: table.weights(*columns))
    np.testing.assert_array_equal(compiled, by_numpy)
    assert compiled.dtype == np.float32 and compiled.shape == (count, azimuths)


# echo_positions: the kernel that places echoes at some instants against numpy.
@pytest.mark.parametrize("leaning", [[], [1], [0, 2, 3]], ids=["upright", "one leans", "most lean"])
@pytest.mark.parametrize("count", [0, 1, 500])
def test_positions_are_those_of_numpy(count: int, leaning: list[int]) -> None:
    """Four bodies, of which the last rests; one of them has no echo, and an undefined heading. The tolerance is four roundings of
    5 km."""
    draw, time = np.random.default_rng(17), 0.01 * np.arange(4)
    instants, body = 3 + len(time), draw.choice([0, 1, 3], 500)
    heading = draw.uniform(0.0, 6.0, (instants, 4))
    heading[:, 2] = np.nan
    rotation = {b: map_from_deck(*draw.uniform(-1.0, 1.0, (3, instants))) for b in leaning}
    poses = PoseArrays(draw.uniform(-5000.0, 5000.0, (instants, 4, 3)), heading, rotation)
    moves, antenna = np.array([True, True, True, False]), draw.uniform(-10.0, 10.0, (instants, 3))
    over, azimuths = parabola(time), AzimuthTimes(np.arange(4), np.zeros(4), time)
    block = BlockGeometry(azimuths, over, poses, antenna, None, ~moves, moves)
    echoes = BodyEchoes.of_points(draw.uniform(-50.0, 50.0, (500, 3)), np.ones(500, dtype=np.complex128), body)
    observed, which = ObservedEchoes(echoes, draw.uniform(-5000.0, 5000.0, (500, 3))), draw.integers(0, 500, count)
    for instants_of in ([1], range(3), range(3, 7)):
        for one, other in zip(*both(lambda: block.positions(observed, which, instants_of)), strict=True):  # noqa: B023
            np.testing.assert_allclose(one, other, rtol=0.0, atol=4e-12)
            assert one.T.flags.c_contiguous and np.isfinite(one).all()


# fuzz: no call of a kernel ends a process, whatever it is given: in a child process, whose last line names the kernel that did.
def fuzzed(seed: int, rounds: int) -> None:
    command = [sys.executable, "-m", "tests.kernels.fuzz", str(seed), str(rounds)]
    child = subprocess.run(command, capture_output=True, text=True)
    assert (child.returncode, child.stdout.split()[-1]) == (0, "done"), child.stderr


def test_kernels_survive_what_is_odd_and_refuse_what_is_wrong() -> None:
    fuzzed(1, 30)


@pytest.mark.study
@pytest.mark.parametrize("seed", range(2, 12))
def test_kernels_survive_a_thousand_calls_each(seed: int) -> None:
    fuzzed(seed, 1000)


# fields: kernels of legs and of sums on a lattice against numpy; phasors also against exact ones.
EARTH = 4 / 3 * 6_371_000.0
WAVE = Wave(2.0 * np.pi, "h")  # 1 rad/m
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


def test_phasors_are_exact_up_to_1e8_rad() -> None:
    """Within 4 units in the last place of 1, after the phase is reduced with 60 digits; at 0, quarter turns, and tiny phases."""
    draw = np.random.default_rng(1)
    phase = np.concatenate([draw.uniform(-1e8, 1e8, 2000), draw.uniform(-4.0, 4.0, 2000), np.arange(-9, 10) * np.pi / 4])
    phase = np.append(phase, [0.0, -0.0, 1e-300, 1e-9, 1e8])
    with localcontext(prec=60):
        reduced = np.array([float(Decimal(float(x)) % (2 * PI)) for x in phase])
    compiled, by_numpy = both(lambda: WAVE.phasor(-phase))
    for result in (compiled, by_numpy):
        np.testing.assert_allclose(result, np.cos(reduced) + 1j * np.sin(reduced), rtol=0.0, atol=4 * 2.3e-16)
    assert WAVE.phasor(np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("count", [0, 1, 500])
@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_rays_and_lengths_of_legs(by_sea: bool, earth: float, count: int) -> None:
    """Also at the foot of the antenna, below the sea and beyond the horizon. Positions on the map of 30 km round to 4e-12 m."""
    pose = BodyPose(np.array([300.0, -200.0, 0.5]), 2.1, None)
    antenna = map_from_body(np.array([30.0, 40.0, 20.0]), pose.position, pose.heading)
    leg = BodyLeg(by_sea, pose, antenna, earth)
    points = np.random.default_rng(2).uniform([-100, -100, -2], [100, 100, 40], (500, 3))
    points[:3] = [30.0, 40.0, 3.0], [40_000.0, 0.0, 2.0], [0.0, 0.0, -5.0]
    points = points[:count]
    for one, other in zip(*both(lambda: [leg.eye(point) for point in points]), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(*both(lambda: leg.length(points)), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("rows", [1, 3])
@pytest.mark.parametrize("count", [0, 2, 60])
def test_sums_on_a_lattice(rows: int, count: int) -> None:
    draw = np.random.default_rng(6)
    lattice = Lattice.over(draw.uniform(-3.0, 3.0, (count, 3)), np.repeat([0.5, 0.8], count // 2), np.inf, -np.inf)
    amplitude = draw.normal(size=count) + 1j * draw.normal(size=count)
    compiled, by_numpy = both(lambda: lattice.sums(amplitude, np.arange(count) % rows, rows))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=1e-13)


# cast_shadows: kernels of the shadows of other bodies against numpy.
LEAN = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]) @ np.array([[1, 0, 0], [0, 1, -0.003], [0, 0.003, 1]])
IN_LINE = [[2.5, 55.9, -8.3], [-8.7, 65.6, 7.4], [1.3800000000000001, 56.87, -6.73]]  # but for rounding
PICTURE = Picture(np.array([0.0, 0.0, 12.0]), np.inf, False)


def shadows(count: int) -> CastShadows:
    """Of triangles about 50 m away, some of which overlap, one edge-on, and two that share an edge."""
    draw = np.random.default_rng(11)
    corners = draw.uniform([-6.0, 40.0, -11.0], [6.0, 60.0, -2.0], (8, 3, 3))
    corners[1] = np.stack([corners[0, 1], corners[0, 0], corners[1, 2]])
    corners[2] = [[0.0, 50.0, -5.0], [0.0, 55.0, -5.0], [0.0, 55.0, -9.0]]
    return CastShadows(PICTURE, corners[:count])


@pytest.mark.parametrize("casters", [0, 1, 8])
def test_planes_of_shadows_are_those_of_numpy(casters: int) -> None:
    """In the same order; triangles that are seen edge-on, or have no width, cast none, and two share an edge."""
    corners = shadows(8).corners[:casters]
    edge_on = np.array([[[0.0, 50.0, -5.0], [0.0, 55.0, -5.0], [0.0, 55.0, -9.0]], IN_LINE])
    compiled, by_numpy = both(lambda: CastShadows(PICTURE, np.concatenate([corners, edge_on])))
    for name in ("corners", "plane", "offset", "distance"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(by_numpy, name), rtol=1e-12, atol=1e-14)
    assert len(compiled) == len(corners)


class Asked(TriangleClusters):
    """Triangles that keep which hulls of points may concern a question, and answer that none does."""

    def __init__(self, points: Floats) -> None:
        self.points = points

    def chosen(self, concerns: Test) -> Floats:
        self.flags = concerns(self.points)
        return np.zeros((0, 3, 3))


@pytest.mark.parametrize("lean", [None, LEAN], ids=["upright", "leaning"])
@pytest.mark.parametrize("earth", [4 / 3 * 6_371_000.0, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_hulls_that_may_stand_before_a_body_are_those_of_numpy(by_sea: bool, earth: float, lean: np.ndarray | None) -> None:
    """Triangles and boxes all round and about the antenna, below the sea and above it; where they may have moved by 20 m too."""
    draw = np.random.default_rng(17)
    middle = draw.uniform([-3000.0, -3000.0, -9.0], [3000.0, 4000.0, 25.0], (4000, 1, 3))
    middle[:200] = [[[-25.0, 70.0, 0.0]]] + draw.uniform(-3.0, 3.0, (200, 1, 3))  # at the antenna's foot
    pose = BodyPose(np.array([40.0, 60.0, 0.5]), 2.1, lean)
    box = np.array(np.meshgrid([-1500.0, 1500.0], [3600.0, 3620.0], [4.0, 20.0])).reshape(3, 8).T
    pictures = tuple(Picture(PICTURE.antenna, earth, way) for way in (False, True)[: 1 + by_sea])
    for corners in (3, 8):
        asked = Asked(middle + draw.uniform(-4.0, 4.0, (4000, corners, 3)))

        def flags(moved: float, asked: Asked = asked) -> Flags:
            Onlooker(box, pictures).nearest(asked, pose, moved, 2.0)
            return asked.flags

        for moved in (0.0, 20.0):
            compiled, by_numpy = both(lambda moved=moved: flags(moved))
            np.testing.assert_array_equal(compiled, by_numpy)
            assert 5 < by_numpy.sum() < 2000


# skylines: the kernel of skylines against numpy.
AHEAD, TOLERANCE = np.array([0.6, 0.8]), 1e-3


def height(chords: Floats, u: Floats) -> Floats:
    """v at u; NaN where no chord is."""
    over = (chords[:, 0, 0] <= u[:, None]) & (u[:, None] < chords[:, 1, 0])
    v = chords[:, 0, 1] + (u[:, None] - chords[:, 0, 0]) * (np.diff(chords[:, :, 1]) / np.diff(chords[:, :, 0]))[:, 0]
    return np.where(over, v, np.nan).max(axis=1, initial=-np.inf, where=over)


@pytest.mark.parametrize("count", [0, 1, 9, 30])
def test_a_skyline_is_that_of_numpy_within_its_tolerance(count: int) -> None:
    """Triangles about the antenna too, in two groups; chords that find no room are counted."""
    draw = np.random.default_rng(count)
    corners = draw.uniform([-40.0, -5.0, -6.0], [60.0, 90.0, 6.0], (count, 1, 3)) + draw.normal(0.0, 6.0, (count, 3, 3))
    shift = 4.0 * draw.integers(0, 2, count)

    def chords() -> Floats:
        result = np.empty((5000, 2, 2))
        taken = (-0.8, 0.9, -0.3, 0.2, TOLERANCE, AHEAD, corners, shift)
        found = KERNELS.skyline(count, 5000, *taken, result)
        assert KERNELS.skyline(count, 1, *taken, np.empty((1, 2, 2))) == found
        return result[:found]

    compiled, by_numpy = both(chords)
    u = draw.uniform(-0.9, 5.0, 3000)
    found, expected = height(compiled, u), height(by_numpy, u)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(expected))
    some = np.isfinite(expected)
    assert np.abs(found[some] - expected[some]).max(initial=0.0) < TOLERANCE * 1.000001
    assert len(compiled) <= len(by_numpy) and (count < 9 or 0.1 < some.mean() < 0.8)


# gridding: the kernel that spreads points on a grid against numpy.
@pytest.mark.parametrize("by_table", [False, True])
@pytest.mark.parametrize("shape", [(40, 300), (3, 300), (40, 4), (1, 1)])
@pytest.mark.parametrize("count", [0, 1, 3000])
def test_grids_are_those_of_numpy(
    count: int, shape: tuple[int, int], by_table: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Past all edges, also of grids smaller than the kernels, in several calls, with gaps between rows; the grid's own rounding
    is 6e-8 of the peak, in as many parts as numpy has: 20 of them."""
    monkeypatch.setattr("radar_service.receive.gridding.POINTS_PER_CALL", 700)

    rng, kernels = np.random.default_rng(count), (Kernel(4, 3.0), Kernel(6, 1.5))
    weights = tuple(KernelTable(kernel.tables()[0]) for kernel in kernels) if by_table else kernels
    row = np.where(
        rng.random(count) < 0.5, rng.uniform(-3.0, 5.0, count), rng.uniform(shape[0] - 5.0, shape[0] + 3.0, count)
    )
    column = rng.uniform(-5.0, shape[1] + 5.0, count)
    amplitude = rng.normal(size=count) + 1j * rng.normal(size=count)
    compiled, by_numpy = both(lambda: spread(shape, row, column, amplitude, *weights))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=1.2e-6 * np.abs(by_numpy).max(initial=0.0))
    assert compiled.any() == (count > 0)


@pytest.mark.parametrize("migration", [0.0, 0.001, 0.04, 0.3, 9.0])
@pytest.mark.parametrize("rows, size", [(16, 300), (5, 40), (1, 900), (16, 4)])
def test_moving_points_are_those_of_numpy_to_the_bit(rows: int, size: int, migration: float) -> None:
    """Series of one, two and three terms, in one group of rows and in several, past both ends, on rows shorter than the kernel.
    The sums are in numpy's order; only cells that a point meets twice, where the kernel wraps, are rounded otherwise."""
    rng, count, tables = np.random.default_rng(7), 3500, Kernel(6, 1.5).tables()
    column = rng.uniform(-4.0, size + 4.0, count)
    moved = rng.uniform(-migration, migration, (count, rows)).astype(np.float32)
    amplitude = (rng.normal(size=(count, rows)) + 1j * rng.normal(size=(count, rows))).astype(np.complex64)

    def gridded() -> NDArray[np.complex64]:
        grid = np.zeros((rows, size), dtype=np.complex64)
        spread_moving(grid, column, moved, amplitude, tables)
        return grid

    compiled, by_numpy = both(gridded)
    assert compiled.any()
    if size < 6:
        np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=2e-5 * np.abs(by_numpy).max())
    else:
        np.testing.assert_array_equal(compiled, by_numpy)


# lines_of_sight: kernels of lines of sight past many bodies against numpy.
@pytest.mark.parametrize("leaning", [[], [1], [0, 2, 3]], ids=["upright", "one leans", "most lean"])
@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize(("count", "origins"), [(0, 1), (1, 1), (600, 1), (600, 600)])
@pytest.mark.parametrize("passing", [False, True])
def test_lines_of_sight_are_those_of_numpy(
    count: int, origins: int, leaning: list[int], earth: float, passing: bool
) -> None:
    """Four bodies of two meshes, before, about and behind points 5 km off. The tolerance is four roundings of 5 km; the share
    left out rounds by as much over the way."""
    draw, occluders = np.random.default_rng(23), [Occluder(box(30.0, 20.0, height), earth) for height in (10.0, 14.0)]
    rotation = {b: map_from_deck(*draw.uniform(-1.0, 1.0, (3, 1))) for b in leaning}
    poses = PoseArrays(draw.uniform(-3000.0, 3000.0, (1, 4, 3)), draw.uniform(0.0, 6.0, (1, 4)), rotation)
    posed = PosedOccluders(OccluderKinds.of([occluders[k] for k in (0, 1, 1, 0)]), poses, earth)
    body, origin = draw.integers(0, 4, count), draw.uniform(-60.0, 60.0, (origins, 3))
    away = draw.uniform(0.5, 1.7, (count, 1))
    points = away * (poses.position[0][body] + draw.uniform(-25.0, 25.0, (count, 3)))
    if count == 600:
        points[0] = origin[0]  # no way at all
    begins = origin[0] if origins == 1 else origin
    results = both(lambda: posed.lines_of_sight(body, begins, points, passing))
    for one, other in zip(*results, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=4e-12)
    kept = len(results[0].which)
    assert kept == count or (passing and (count == 1 or 100 < kept < 500))


@pytest.mark.parametrize("sloping", [False, True])
@pytest.mark.parametrize("count", [1, 900])
def test_points_behind_bodies_are_those_of_numpy(count: int, sloping: bool) -> None:
    """The same pairs in the same order. One body stands round about the antenna."""
    draw = np.random.default_rng(29)
    sectors = ShadowSectors(draw.uniform(-3.0, 3.0, 40), draw.uniform(0.0, 0.6, 40), draw.uniform(0.0, 4000.0, 40))
    sectors.half[7] = np.pi
    azimuth, distance = draw.uniform(-np.pi, np.pi, count), draw.uniform(3500.0, 5000.0, count)
    slopes = (draw.uniform(-1.0, 1.0, 40), draw.uniform(-1.0, 1.0, count)) if sloping else None
    compiled, by_numpy = both(lambda: list(points_behind(sectors, azimuth, distance, slopes)))
    for one, other in zip(compiled, by_numpy, strict=True):
        np.testing.assert_array_equal(one, other)
    assert count == 1 or sum(len(body) for body, _ in compiled) > 1000


# strata: kernels that sample surfaces against numpy.
SHAPES: dict[str, dict[str, Any]] = {
    "box, whose faces are sampled one by one": {"shape": "box", "length_m": 20, "width_m": 12, "height_m": 9},
    "hull": {"shape": "hull", "length_m": 30, "beam_m": 10, "height_m": 9},
    "hull of a kilometre": {"shape": "hull", "length_m": 1000, "beam_m": 2, "height_m": 2},
    "ball": {"shape": "sphere", "radius_m": 2},
}


def compared(mesh: Mesh, count: int, sea: float) -> Scatterers:
    """Scatterers of a mesh, the same by kernels and numpy: those drawn equal, heights to the rounding of sums of 32."""
    density = np.random.default_rng(2).uniform(1e-6, 3e-6, len(mesh.faces))
    compiled, by_numpy = both(lambda: sample_surface(mesh, density, np.random.default_rng(1), count, sea=sea))
    for name in ("position", "normal", "triangle", "phasor"):
        np.testing.assert_array_equal(getattr(compiled, name), getattr(by_numpy, name))
    for name in ("area", "middle", "span"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(by_numpy, name), rtol=1e-12, atol=1e-13)
    np.testing.assert_array_equal(compiled.span > 0.0, by_numpy.span > 0.0)  # else an echo is that of a point
    return compiled


@pytest.mark.parametrize("sea", [-np.inf, 2.0, 50.0], ids=["no sea", "afloat", "sunk"])
@pytest.mark.parametrize("count", [1, 20, 48, 300, 700])
@pytest.mark.parametrize("shape", SHAPES)
def test_scatterers_are_those_of_numpy(shape: str, count: int, sea: float) -> None:
    """One, a few, those of a body, most strata, and more than these, along the mesh."""
    (body,) = scene([{**SHAPES[shape], "name": "b", "material": "wood", "position_m": [0, 500, 0]}]).bodies
    assert body.mesh is not None
    drawn = compared(body.mesh, count, sea)
    assert len(drawn) >= count


def test_triangles_without_area_and_equal_features_change_nothing() -> None:
    """Two equal squares, one upon the other, and a triangle of one point: points of both have equal features."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float64)
    mesh = Mesh(vertices, np.array([[0, 1, 2], [0, 2, 3], [0, 0, 0], [0, 1, 2], [0, 2, 3]]))
    drawn = compared(mesh, 48, -np.inf)
    assert not (drawn.triangle == 2).any() and {0, 1, 3, 4} == {*drawn.triangle.tolist()}
