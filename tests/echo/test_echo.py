"""The short modules of echo, each under its name."""

import math
from typing import Any

import numpy as np
import pytest

from radar_service.echo.beam_paths import Beam, DirectPath, Sights
from radar_service.echo.block_geometry import BlockGeometry, ObservedEchoes, PartGeometry
from radar_service.echo.closest_approach import closest_approach, nearest_and_top
from radar_service.echo.echoes import AzimuthTimes, BeamTable, BeamWeightedEchoes, Echoes, concatenated, received_field
from radar_service.echo.passage_nodes import (
    CUBIC_PHASE,
    Part,
    held_spokes,
    node_weights,
    outward_nodes,
    part_nodes,
    stretches,
)
from radar_service.echo.range_history import parabola
from radar_service.scattering.model import BodyEchoes
from radar_service.stages.registry import changed_pattern
from radar_service.world.poses import BodyPoses
from tests.reference.compressed_pulse import sinc2_beam
from tests.scenes import point, radar, scene
from tests.test_motion import SWAY

# beam_paths: paths to the antenna: the direct one through a beam that structures shadow.
RADAR = radar(structure=[{"bearing_deg": 30, "distance_m": 2, "width_m": 0.3}])
SHADOW = changed_pattern(RADAR, 0.3)


def test_a_shadowed_beam_multiplies_by_the_square_of_its_field() -> None:
    """Two echoes at three azimuths while own ship turns: one behind the mast at the last azimuth, one never."""
    assert SHADOW is not None
    bearing = np.radians([[70.0, 70.0, 71.0], [200.0, 200.0, 200.0]])
    sights = Sights(bearing, np.radians([69.0, 70.0, 71.0]), np.radians([0.0, 20.0, 41.0]))
    amplitude = np.array([[1.0, 2j, 3.0], [1.0, 1.0, 1.0]], dtype=np.complex64)
    echoes = BeamWeightedEchoes(np.array([100.0, 200.0]), np.zeros((2, 3), dtype=np.float32), amplitude, np.array([0, 1]))
    received = DirectPath(Beam(RADAR, SHADOW)).received(echoes, sights)
    field = SHADOW.one_way(np.radians([[70.0, 50.0, 30.0]]), np.radians([[1.0, 0.0, 0.0]]))[0]
    np.testing.assert_allclose(received.amplitude[0], amplitude[0] * field**2, rtol=1e-6)
    assert abs(received.amplitude[0, 2]) < 0.75 * 3.0 and abs(received.amplitude[0, 1]) > 0.9 * 2.0
    assert abs(received.amplitude[1]).max() < 1e-3  # far from the beam
    np.testing.assert_array_equal(received.range, echoes.range)


# echoes: records of echoes: parts of azimuths, and joined parts.
def weighted(count: int, start: float) -> BeamWeightedEchoes:
    """Echoes over four azimuths."""
    value = start + np.arange(count * 4).reshape(count, 4)
    return BeamWeightedEchoes(
        start + np.arange(count),
        value.astype(np.float32),
        value.astype(np.complex64),
        start + np.arange(count, dtype=np.int64),
    )


def test_a_part_keeps_number_boresight_and_time_together() -> None:
    azimuths = AzimuthTimes(np.arange(7), np.arange(7) * 0.1, np.arange(7) * 0.01)
    part = azimuths.part(2, 5)
    assert part.number.tolist() == [2, 3, 4]
    np.testing.assert_allclose(part.boresight / part.time, 10.0)
    assert (azimuths.middle, part.middle, azimuths.part(0, 1).middle) == (0.03, 0.03, 0.0)
    assert azimuths.part(0, 4).middle == 0.02  # the later of two


@pytest.mark.parametrize("counts", [(), (3,), (0, 2), (2, 0, 3)])
def test_joined_parts_hold_all_echoes_in_order(counts: tuple[int, ...]) -> None:
    parts = [weighted(count, 100.0 * k) for k, count in enumerate(counts)]
    whole = concatenated(parts, 4)
    assert whole.range.shape == (sum(counts),) and whole.amplitude.shape == whole.range_migration.shape == (sum(counts), 4)
    assert (whole.range_migration.dtype, whole.amplitude.dtype) == (np.float32, np.complex64)
    expected = [value for part in parts for value in part.range]
    assert whole.body.tolist() == expected
    if sum(counts) == 5:
        assert [column[0].tolist() for column in whole.chosen(np.array([3]))] == [column[3].tolist() for column in whole]
    assert whole.range.tolist() == expected and whole.amplitude[:, 0].real.tolist() == expected[:0] + [
        float(row[0].real) for part in parts for row in part.amplitude
    ]


def test_echoes_of_unlike_lengths_are_refused() -> None:
    with pytest.raises(AssertionError):
        Echoes(np.zeros(2), np.zeros(2), np.zeros(3, dtype=np.complex128))


# block_geometry: positions of echoes over a block: moving bodies at their poses of each instant, resting ones where they are.
EARTH = 4 / 3 * 6_371_000.0


def block_of(**own_ship: object) -> tuple[BlockGeometry, ObservedEchoes]:
    """A resting and a moving body with an echo each, the second 2 m off its origin, over four azimuths from t = 10 s."""
    bodies = [point("rests", 300, 400, 5), point("moves", 0, 900, 5, speed_kn=20, course_deg=90)]
    made = scene(bodies, own_ship=own_ship)
    time = 10.0 + 0.01 * np.arange(4)
    azimuths = AzimuthTimes(np.arange(4), np.zeros(4), time)
    over = parabola(time)
    every = np.concatenate([over.nodes, time])
    poses = BodyPoses(made.bodies)
    moves = np.array([False, True])
    geometry = BlockGeometry(
        azimuths, over, poses.at(every), made.antenna(every), made.upright_from_map(every), ~moves, moves
    )
    echoes = BodyEchoes.of_points(np.array([[0.0, 0, 0], [0, 2, 1]]), np.ones(2, dtype=complex), np.array([0, 1]))
    return geometry, ObservedEchoes(echoes, np.array([[300.0, 400, 5], [np.nan, np.nan, np.nan]]))


def test_positions_are_those_of_the_instant() -> None:
    """The body heads east, so 2 m ahead is 2 m east; 20 kn for 10 s and more."""
    geometry, observed = block_of()
    speed = 20 * 1852 / 3600
    for n, time in enumerate([10.0, 10.015, 10.03, 10.0, 10.01, 10.02, 10.03]):
        (position,) = geometry.positions(observed, np.array([0, 1]), [n])
        np.testing.assert_allclose(position, [[300, 400, -10], [speed * time + 2, 900, -9]], atol=1e-9)


def test_a_part_has_its_middle_as_the_antenna_observes_it() -> None:
    geometry, observed = block_of()
    part = PartGeometry.of(observed, np.array([0]), geometry, np.inf)
    assert part.polar.range[0] == pytest.approx(np.sqrt(250_000 + 100))
    assert part.azimuth[0] == part.polar.azimuth[0] == pytest.approx(np.arctan2(3, 4))
    assert len(part.elevations()) == 3 and part.elevation[0] == pytest.approx(np.arctan2(-10, 500))
    swaying, observed = block_of(heading_deg=40, **SWAY)
    tilted = PartGeometry.of(observed, np.array([0]), swaying, EARTH)
    assert abs(tilted.elevation[0] - tilted.polar.elevation[0]) > 0.01
    assert len({float(e[0]) for e in tilted.elevations()}) == 3


# echoes: the table of the beam against the pattern itself, and received fields against complex128.
WIDTH = np.deg2rad(2.0)


def table(extent: float, oversampling: int = 1) -> BeamTable:
    return BeamTable(lambda offset: sinc2_beam(offset, WIDTH), WIDTH, extent, 0.05, oversampling)


@pytest.mark.parametrize("oversampling", [1, 8])
def test_the_table_errs_by_half_an_entry(oversampling: int) -> None:
    """Half an entry of 4096 to a beamwidth on the steepest slope, -74.8 dB of boresight; oversampled by eight, 18 dB less.
    A tenth more for float32, which places an offset to 0.03 entries. Both sides alike."""
    slope = np.abs(np.gradient(sinc2_beam(np.linspace(0, WIDTH, 10_001), WIDTH), WIDTH / 10_000)).max() * WIDTH
    offset = np.random.default_rng(1).uniform(-0.3, 0.3, 20_000).astype(np.float32)
    beam = table(0.4, oversampling)
    error = np.abs(beam(offset) - sinc2_beam(offset.astype(np.float64), WIDTH)).max()
    assert 0.9 < error / (slope / 2 / 4096 / oversampling) < 1.1
    np.testing.assert_array_equal(beam(offset), beam(-offset))


def test_boresight_is_one_and_beyond_the_reach_the_gain_stays() -> None:
    beam = table(0.1)
    assert beam(np.zeros(1, np.float32))[0] == 1.0
    far = beam(np.array([0.1 + 2 * 0.05 + 0.01, 1.0, -2.0], np.float32))
    assert (far == far[0]).all()


def test_an_extent_of_half_a_turn_wraps() -> None:
    """Beyond half a turn the offset is the shorter one the other way round."""
    beam = table(np.pi)
    offset = np.array([np.pi + 0.02, 2 * np.pi - 0.01], np.float32)[:1]
    assert beam(offset)[0] == pytest.approx(beam(np.float32([np.pi - 0.02]))[0], abs=10 ** (-75 / 20))


def test_fields_turn_with_range_and_its_change() -> None:
    """20 km, 8e6 rad, and up to 3 m of migration, 1200 rad: float32 phases leave 1e-4 rad; the weight multiplies."""
    rng = np.random.default_rng(2)
    middle = rng.normal(size=50) + 1j * rng.normal(size=50)
    weight, migration = rng.uniform(size=(50, 16)).astype(np.float32), rng.uniform(-3, 3, (50, 16)).astype(np.float32)
    distance = rng.uniform(10.0, 20_000.0, 50)
    way = distance[:, None] + migration.astype(np.float64)
    result = received_field(middle, distance, weight, migration, 0.0319)
    exact = middle[:, None] * weight * np.exp(-4j * np.pi / 0.0319 * way)
    assert result.dtype == np.complex64
    assert (np.abs(result - exact) <= 3e-4 * np.abs(middle)[:, None]).all()


# closest_approach: the closest approach of two motions against hand arithmetic and sampled positions.
@pytest.mark.parametrize(
    ("own", "other", "apart"),
    [
        ({}, {"position_m": [3000, 4000, 0]}, 5000.0),
        ({}, {"position_m": [3000, 4000, 0], "steerable": {}}, 0.0),  # commands may bring it anywhere
        ({"steerable": {}}, {"position_m": [3000, 4000, 0]}, 0.0),
        ({}, {"position_m": [-9000, 2000, 0], "speed_kn": 10, "course_deg": 90}, 2000.0),  # passes abeam
        ({}, {"position_m": [3000, 4000, 0], "speed_kn": 10, "course_deg": 0}, 5000.0),  # goes away
        (
            {"speed_kn": 10, "course_deg": 90},
            {"position_m": [500, 700, 0], "speed_kn": 10, "course_deg": 180},
            0.0,
        ),  # crosses
        ({"speed_kn": 10, "course_deg": 0}, {"position_m": [800, -900, 0], "speed_kn": 20, "course_deg": 0}, 800.0),
        ({}, {"position_m": [100, 0, 0], "waypoints": [{"position_m": [100, 300], "speed_kn": 9}]}, 100.0),
    ],
)
def test_closest_approach_of_two_paths(own: dict[str, Any], other: dict[str, Any], apart: float) -> None:
    """By hand; lines are compared, not times. Rounding of a leg of 1e8 m: 1e-8 m."""
    made = scene([point("t", 0, 0) | other], own_ship=own)
    assert closest_approach(made.own_ship, made.bodies[0].motion) == pytest.approx(apart, abs=1e-5)


def test_no_pair_of_random_courses_ever_comes_nearer_than_the_bound() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        courses = [{"position_m": rng.uniform(-5000, 5000, 2).tolist() + [0.0], "speed_kn": float(rng.uniform(0, 30)),
                 "course_deg": float(rng.uniform(0, 360))} for _ in range(2)]  # fmt: skip
        own = {"position_m": courses[0].pop("position_m")[:2]} | courses[0]  # type: ignore[index]
        made = scene(
            [{"name": "b", "shape": "box", "length_m": 80, "width_m": 30, "height_m": 9} | courses[1]], own_ship=own
        )
        nearest, top = nearest_and_top(made.bodies[0], made)
        time = np.linspace(0, 4000, 2000)
        gap = made.bodies[0].motion.pose(time).position - made.antenna(time)
        assert np.hypot(gap[:, 0], gap[:, 1]).min() - math.hypot(40, 15) >= nearest - 1e-6
        assert top == 9.0


def test_a_turning_ship_keeps_its_distance() -> None:
    """Waypoints with a turn radius: the arc comes 200 m nearer than the chord between its ends, and no more than it is long."""
    track = [{"position_m": [x, y], "speed_kn": 10} for x, y in ((3000, 3000), (1000, 0), (3000, -3000))]
    made = scene([point("t", 3000, 0, waypoints=track, turn_radius_m=900, loop=True)])
    time = np.linspace(0, 20_000, 20_000)
    position = made.bodies[0].motion.pose(time).position
    nearest = np.hypot(position[:, 0], position[:, 1]).min()
    assert closest_approach(made.own_ship, made.bodies[0].motion) <= nearest
    assert closest_approach(made.bodies[0].motion, made.own_ship) <= nearest


# passage_nodes: where nodes lie, and what they weigh between them.
def test_nodes_are_at_whole_spokes_as_far_apart_as_allowed() -> None:
    offset, never = np.linspace(0.0, 100.0, 11), np.ones(11)
    np.testing.assert_array_equal(outward_nodes(offset, np.full(11, 30.0), never, 15), [15, 45, 75, 100])
    np.testing.assert_array_equal(outward_nodes(np.array([0.0, 2.0, 4.0]), np.full(3, 0.2), never[:3], 1), [1, 2, 3, 4])
    assert outward_nodes(offset, np.where(offset > 45, 50.0, 10.0), never, 10).tolist() == [10, 20, 30, 40, 50, 100]
    assert outward_nodes(offset, np.full(11, 300.0), never, 150).tolist() == [150]
    assert outward_nodes(offset, np.full(11, 30.0), np.where(offset > 35, 0.0, 1.0), 15).tolist() == [15, 40]


def test_fields_fade_linearly_between_two_nodes_quadratically_between_three_and_stay_beyond() -> None:
    nodes, spoke = np.array([10, 20, 24]), np.array([5.0, 10.0, 12.5, 20.0, 23.0, 30.0])
    np.testing.assert_allclose(node_weights(nodes[:2], spoke)[:, [0, 2, 5]], [[1, 0.75, 0], [0, 0.25, 1]])
    weights = node_weights(nodes, spoke)
    for power in range(3):
        np.testing.assert_allclose((nodes - 16.0) ** power @ weights[:, 1:5], (spoke[1:5] - 16.0) ** power, atol=1e-5)
    np.testing.assert_allclose(weights[:, [0, 5]], [[1, 0], [0, 0], [0, 1]])
    np.testing.assert_array_equal(node_weights(np.array([7]), np.array([3.0, 9.0])), [[1, 1]])


def test_between_four_nodes_and_more_fields_follow_cubics() -> None:
    """Exact at unlike gaps for any cubic of time, to single precision; a phase that runs by theta from node to node is lost by
    3 theta^4 / 128 in inner intervals and theta^4 / 24 in outer ones, at most."""
    nodes, spoke = np.array([10, 14, 20, 29, 33]), np.linspace(10, 33, 70)
    weights = node_weights(nodes, spoke)
    for power in range(4):
        np.testing.assert_allclose(((nodes - 20.0) ** power) @ weights, (spoke - 20.0) ** power, atol=5e-6 * 13.0**power)
    np.testing.assert_allclose(node_weights(nodes, np.array([3.0, 50.0])).T, np.eye(5)[[0, 4]], atol=1e-7)
    nodes, theta = np.arange(0, 60, 10), CUBIC_PHASE
    spoke = np.linspace(0, 50, 101)
    gap = np.abs(np.exp(1j * theta * nodes / 10) @ node_weights(nodes, spoke) - np.exp(1j * theta * spoke / 10))
    inner = (spoke > 10) & (spoke < 40)
    assert 0.8 < gap[inner].max() / (3 * theta**4 / 128) < 1.1 and gap.max() < theta**4 / 24


def test_a_passage_has_a_part_between_each_two_corners() -> None:
    """Each spoke has weights of one part alone, whose nodes lie on its side of all corners."""
    parts = stretches([-4, 9], 50.0)
    assert [part[:2] for part in parts] == [(-50.0, -5.0), (-4.0, 8.0), (9.0, 50.0)]
    assert [part.nearest for part in parts] == [-5.0, 0.0, 9.0]
    rate = 0.2  # rad per spoke, and beyond the part none: nodes are 4 apart
    nodes = [
        part_nodes(part, np.ones_like, lambda at, part=part: rate * ((at >= part.first) & (at <= part.last)), False)
        for part in parts
    ]
    assert [np.diff(each).max() for each in nodes] == [4, 4, 4]
    assert nodes[0].max() == -5 and (nodes[1].min(), nodes[1].max()) == (-4, 8) and nodes[2].min() == 9
    assert nodes[0].min() <= -50 and nodes[2].max() >= 50  # the passage goes on there
    spoke = np.arange(-60.0, 60.0)
    made = [
        Part(first, last, each) for (first, last), each in zip(((-np.inf, -5), (-4, 8), (9, np.inf)), nodes, strict=True)
    ]
    weights = [part.weights(spoke) for part in made]
    np.testing.assert_allclose(np.sum([each.sum(axis=0) for each in weights], axis=0), 1.0, atol=1e-6)
    assert all((np.abs(one).sum(axis=0) * np.abs(other).sum(axis=0) == 0).all() for one, other in (weights[:2], weights[1:]))


def test_a_part_of_one_spoke_or_that_hardly_changes_has_one_node_next_to_the_crossing() -> None:
    for corners, expected in (([3, 4], [0, 3, 4]), ([-9, -2], [-10, -3, 0])):
        nodes = [
            part_nodes(part, np.ones_like, lambda offset: np.full(len(offset), 1e-6), False)
            for part in stretches(corners, 40.0)
        ]
        assert [each.tolist() for each in nodes] == [[node] for node in expected]
    (whole,) = stretches([], 40.0)
    faint, fainter, most = (held_spokes(whole, lambda at, gain=gain: np.full(len(at), gain)) for gain in (0.05, 0.04, 1.0))
    assert faint == pytest.approx(fainter)
    one, more = (part_nodes(whole, np.ones_like, lambda at, k=k: np.full(len(at), k / most), False) for k in (0.99, 1.5))
    assert len(one) == 1 < len(more)


def test_all_round_the_crossing_is_a_node_and_nodes_are_twice_as_close() -> None:
    """Else a body is weakest where the beam points at it."""
    (whole,) = stretches([], 100.0)
    nodes = [part_nodes(whole, np.ones_like, lambda offset: np.full(len(offset), 0.08), every) for every in (False, True)]
    assert np.diff(nodes[0]).min() == CUBIC_PHASE / 0.08
    assert 0 in nodes[1] and set(np.diff(nodes[1]).tolist()) == {CUBIC_PHASE / 0.08 / 2}
