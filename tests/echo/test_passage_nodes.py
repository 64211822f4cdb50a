"""Where nodes lie, and what they weigh between them."""

import numpy as np
import pytest

from radar_service.echo.passage_nodes import (
    CUBIC_PHASE,
    EDGE_PHASE,
    HELD_PHASE,
    Part,
    held_spokes,
    node_weights,
    outward_nodes,
    part_nodes,
    stretches,
)


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
    rms = 40.0 / np.sqrt(3.0)  # of offsets, sampled within 0.1 %
    assert held_spokes(whole, lambda at: np.full(len(at), 0.05)) == pytest.approx(rms / HELD_PHASE, rel=2e-3)
    one, more = (
        part_nodes(whole, np.ones_like, lambda at, most=most: np.full(len(at), most / 40.0), False)
        for most in (0.99 * EDGE_PHASE, 1.5 * EDGE_PHASE)
    )
    assert len(one) == 1 < len(more)


def test_all_round_the_crossing_is_a_node_and_nodes_are_twice_as_close() -> None:
    """Else a body is weakest where the beam points at it."""
    (whole,) = stretches([], 100.0)
    nodes = [part_nodes(whole, np.ones_like, lambda offset: np.full(len(offset), 0.08), every) for every in (False, True)]
    assert np.diff(nodes[0]).min() == CUBIC_PHASE / 0.08
    assert 0 in nodes[1] and set(np.diff(nodes[1]).tolist()) == {CUBIC_PHASE / 0.08 / 2}
