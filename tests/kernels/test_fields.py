"""Kernels of legs, of the fields of facets and tubes and of their sums, against numpy; phasors also against exact ones."""

from dataclasses import replace
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_body, map_from_deck
from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.scattering.physical_optics import illumination
from radar_service.scattering.physical_optics.body_facets import welded
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.corner_samples import renumbered
from radar_service.scattering.physical_optics.facet_integral import phasors
from radar_service.scattering.physical_optics.facets import cut_triangles
from radar_service.scattering.physical_optics.lit_facets import Planes
from radar_service.scattering.physical_optics.optical_body import OpticalBody
from radar_service.scattering.physical_optics.own_shadows import OwnShadows
from radar_service.scattering.physical_optics.path_fields import LegPhases, Wave, facet_fields, facet_phases
from radar_service.scattering.physical_optics.scattering_centres import Lattice
from radar_service.trace.occluder import Occluder
from radar_service.world.body import Mesh
from radar_service.world.poses import BodyPose
from tests.kernels.both import both
from tests.scattering.physical_optics.meshes import WAVELENGTH, loaded, optical, trihedral

EARTH = 4 / 3 * 6_371_000.0
MINUS_120_DB = 1e-6
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")
SHIP = trihedral(2.0, 2, True)  # three walls that shade and reflect each other


def legs_of(mesh: Mesh, roll: float, earth: float, by_sea: bool = True) -> tuple[BodyLeg, ...]:
    """The legs to a body 400 m away whose hollow side faces the antenna."""
    rotation = map_from_deck(np.array(2.1), np.array(roll), np.array(0.0))
    pose = BodyPose(np.array([300.0, -200.0, 0.5]), 2.1, rotation if roll else None)
    antenna = map_from_body(np.array([230.0, 230.0, 20.0]), pose.position, pose.heading)
    shadows = [OwnShadows(Occluder(mesh, earth), pose, antenna, earth, way) for way in (False, True)[: 1 + by_sea]]
    return tuple(BodyLeg(own.by_sea, pose, antenna, earth, own.visible, own.edges) for own in shadows)


@pytest.fixture(params=[(0.0, EARTH), (0.0, np.inf), (0.2, EARTH)], ids=["upright", "flat earth", "rolled"])
def seen(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[OpticalBody, tuple[BodyLeg, ...]]:
    """A body and the legs that light it."""
    roll, earth = request.param
    body = optical(loaded(tmp_path, SHIP))
    legs = legs_of(body.mesh, roll, earth)
    return (body if legs[0].pose.lean is None else body.leaning(legs[0].pose.lean)), legs


def test_phasors_are_exact_up_to_1e8_rad() -> None:
    """Within 4 units in the last place of 1, after the phase is reduced with 60 digits; at 0, quarter turns, and tiny phases."""
    draw = np.random.default_rng(1)
    phase = np.concatenate([draw.uniform(-1e8, 1e8, 2000), draw.uniform(-4.0, 4.0, 2000), np.arange(-9, 10) * np.pi / 4])
    phase = np.append(phase, [0.0, -0.0, 1e-300, 1e-9, 1e8])
    with localcontext(prec=60):
        reduced = np.array([float(Decimal(float(x)) % (2 * PI)) for x in phase])
    compiled, by_numpy = both(lambda: phasors(phase))
    for result in (compiled, by_numpy):
        np.testing.assert_allclose(result, np.cos(reduced) + 1j * np.sin(reduced), rtol=0.0, atol=4 * 2.3e-16)
    assert phasors(np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("count", [0, 1, 500])
@pytest.mark.parametrize("earth", [EARTH, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_rays_and_lengths_of_legs(by_sea: bool, earth: float, count: int) -> None:
    """Also at the foot of the antenna, below the sea and beyond the horizon. Positions on the map of 30 km round to 4e-12 m."""
    pose = BodyPose(np.array([300.0, -200.0, 0.5]), 2.1, None)
    antenna = map_from_body(np.array([30.0, 40.0, 20.0]), pose.position, pose.heading)
    leg = BodyLeg(by_sea, pose, antenna, earth, lambda points, _: np.ones(len(points), dtype=np.bool_))
    points = np.random.default_rng(2).uniform([-100, -100, -2], [100, 100, 40], (500, 3))
    points[:3] = [30.0, 40.0, 3.0], [40_000.0, 0.0, 2.0], [0.0, 0.0, -5.0]
    points = points[:count]
    for one, other in zip(*both(lambda: leg.rays(points)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(*both(lambda: leg.length(points)), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize(("out", "back"), [(0, 0), (0, 1), (1, 1)])
def test_fields_of_facets(seen: tuple[OpticalBody, tuple[BodyLeg, ...]], out: int, back: int, polarization: str) -> None:
    body, legs = seen
    wave = Wave(body.wave.wavelength, polarization)
    _, lit = body.lit_facets(legs, 0.1)
    assert (lit.share > 0.0).any(axis=0).all()
    compiled, by_numpy = both(lambda: facet_fields(lit, facet_phases(lit, wave), out, back, wave))
    assert np.abs(compiled - by_numpy).max() < MINUS_120_DB * np.abs(by_numpy).max()


def test_fields_of_facets_whose_phases_hardly_differ_bend_much_or_are_equal() -> None:
    """Branches of the means over triangles: corners drawn so that spans and bends lie on both sides of their limits, and ties."""
    draw = np.random.default_rng(5)
    count = 400
    spread = np.repeat([0.0, 1e-3, 0.04, 0.3, 1.0, 30.0], count // 6 + 1)[:count, None]
    points = (draw.uniform(-0.5, 0.5, (count, 3, 3)) * WAVELENGTH * spread[:, None] + [0.0, 0.0, 4.0]).reshape(-1, 3)
    points[:9] = points[0]  # no area, equal phases
    leg = legs_of(Mesh(SHIP.reshape(-1, 3), np.arange(SHIP.size // 3).reshape(-1, 3)), 0.0, EARTH, by_sea=False)[0]
    near = replace(leg, antenna=leg.on_map(np.array([6.0, 8.0, 4.0])))  # where wavefronts bend
    normal = np.array([0.6, 0.8, 0.0])
    planes = Planes(np.zeros((1, 3)), normal[None], np.zeros((1, 2), dtype=np.bool_), np.zeros(1, dtype=np.int64), 1.0)
    nothing, ones = np.zeros(count, dtype=np.int64), np.ones(count)
    side = np.ones((count, 1), dtype=np.int8)
    corner = np.arange(3 * count).reshape(-1, 3).T
    wave = Wave(WAVELENGTH, "v")

    def field() -> Complexes:
        lit = illumination.lit_facets(points, corner, nothing, ones, side, np.ones((count, 1)), planes, (near,))
        return facet_fields(lit, facet_phases(lit, wave), 0, 0, wave)

    compiled, by_numpy = both(field)
    large = np.abs(by_numpy) > 0.0
    assert large.sum() > 3 * count // 2
    assert np.abs(compiled - by_numpy).max() < MINUS_120_DB * np.abs(by_numpy).max()
    np.testing.assert_allclose(compiled[large], by_numpy[large], rtol=1e-8)  # phases of 4e3 rad, rounded to 1e-12


def test_whole_aspects(seen: tuple[OpticalBody, tuple[BodyLeg, ...]]) -> None:
    """Shadows, tubes, fields and sums: the same centres on every path, within -120 dB of the strongest."""
    body, legs = seen
    compiled, by_numpy = both(lambda: body.echoes(legs, 0.1))
    for one, other in zip(compiled, by_numpy, strict=True):
        assert len(one.amplitude) > 3
        np.testing.assert_allclose(one.position, other.position, rtol=0.0, atol=1e-9)
        assert np.abs(one.amplitude - other.amplitude).max() < MINUS_120_DB * np.abs(other.amplitude).max()


def test_nothing_lit_scatters_nothing(seen: tuple[OpticalBody, tuple[BodyLeg, ...]]) -> None:
    body, legs = seen
    compiled, by_numpy = both(lambda: body.echoes(legs, 50.0))
    assert [len(one.amplitude) for one in compiled] == [len(one.amplitude) for one in by_numpy] == [0, 0, 0]


@pytest.mark.parametrize("begin", [0, 7])
@pytest.mark.parametrize("count", [0, 1, 40])
def test_sums_on_a_lattice(begin: int, count: int) -> None:
    draw = np.random.default_rng(6)
    lattice = Lattice.over(draw.uniform(-3.0, 3.0, (60, 3)), np.repeat([0.5, 0.8], 30), np.inf, -np.inf)
    amplitude = draw.normal(size=count) + 1j * draw.normal(size=count)
    compiled, by_numpy = both(lambda: lattice.sums(slice(begin, begin + count), amplitude))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=1e-13)


def in_order(parts: Floats, origin: Indices) -> Floats:
    """Triangles (N, 3, 3) with the number of their origin, in an order that does not depend on that of the parts."""
    rows = np.column_stack([origin, parts.reshape(-1, 9)])
    return rows[np.lexsort(rows.T[::-1])]


@pytest.mark.parametrize("count", [0, 1, 40])
def test_triangles_are_cut_into_the_same_parts(count: int) -> None:
    """Among them one without area, one that fits as a whole, and isosceles ones, whose edges tie."""
    corners = np.random.default_rng(7).uniform(-2.0, 2.0, (40, 3, 3))
    corners[1], corners[2], corners[3] = 0.5, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [2, 0, 0], [1, np.sqrt(3), 0]]
    corners = corners[:count]
    longest = np.full(count, 0.3)
    longest[2:3] = 2.0
    (parts, origin), (others, of_others) = both(lambda: cut_triangles(corners, longest))
    np.testing.assert_array_equal(origin, of_others)
    np.testing.assert_array_equal(in_order(parts, origin), in_order(others, of_others))


@pytest.mark.parametrize("count", [0, 1, 300])
def test_corners_that_are_the_same_are_one_point(count: int) -> None:
    """Of a mesh whose triangles share corners; 0 and -0 are the same, neighbouring numbers are not."""
    corners = np.concatenate([trihedral(1.0, 7, True), np.random.default_rng(8).uniform(-1.0, 1.0, (6, 3, 3))])[:count]
    corners[:1] = [[0.0, -0.0, 0.0], [0.0, 0.0, 0.0], [np.nextafter(0.0, 1.0), 0.0, 0.0]]
    (number, points), (of_others, others) = both(lambda: welded(corners))
    assert points.shape == others.shape
    assert len(np.unique(points.view(np.uint64), axis=0)) == len(points)
    np.testing.assert_array_equal(points[number], others[of_others])
    np.testing.assert_array_equal(points[number], corners.transpose(1, 0, 2))


@pytest.mark.parametrize("index", [[], [3], [7, 0, 7, 2, 9], list(range(10))])
def test_numbers_that_occur_are_numbered_anew(index: list[int]) -> None:
    (used, number), (of_others, others) = both(lambda: renumbered(np.array([index, index], dtype=np.int64), 10))
    np.testing.assert_array_equal(used, of_others)
    np.testing.assert_array_equal(number, others)


@pytest.mark.parametrize("bend", [0.0, 0.3, 2.0], ids=["straight", "gentle", "bent"])
@pytest.mark.parametrize("spread", [0.0, 0.01, 0.4, 3.0], ids=["equal", "flat", "short", "steep"])
def test_fields_of_drawn_phases(seen: tuple[OpticalBody, tuple[BodyLeg, ...]], spread: float, bend: float) -> None:
    """Each branch of the means over triangles by itself: phases at corners and bends of edges drawn, equal ones too."""
    body, legs = seen
    _, lit = body.lit_facets(legs, 0.1)
    draw = np.random.default_rng(10)
    corner = spread * draw.normal(size=len(lit.points))
    phases = LegPhases(corner, np.exp(1j * corner), bend * draw.uniform(-1.0, 1.0, lit.corner.shape))
    compiled, by_numpy = both(lambda: facet_fields(lit, [phases, phases], 0, 1, body.wave))
    assert np.abs(compiled - by_numpy).max() < 1e-9 * np.abs(by_numpy).max()  # the series err by 1e-9 on either side
