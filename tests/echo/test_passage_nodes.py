"""Where nodes lie, and what they weigh between them."""

import numpy as np

from radar_service.echo.beam_passage import CUBIC_PHASE
from radar_service.echo.passage_nodes import node_weights, outward_nodes, waterline_rise
from tests.scenes import scene


def test_nodes_are_at_whole_spokes_as_far_apart_as_allowed() -> None:
    offset, never = np.linspace(0.0, 100.0, 11), np.zeros(11, dtype=bool)
    np.testing.assert_array_equal(outward_nodes(offset, np.full(11, 30.0), never, 15), [15, 45, 75, 105])
    np.testing.assert_array_equal(outward_nodes(np.array([0.0, 2.0, 4.0]), np.full(3, 0.2), never[:3], 1), [1, 2, 3, 4])
    assert outward_nodes(offset, np.where(offset > 45, 50.0, 10.0), never, 10).tolist() == [10, 20, 30, 40, 50, 100]
    assert outward_nodes(offset, np.full(11, 300.0), never, 150).tolist() == [150]
    assert outward_nodes(offset, np.full(11, 30.0), offset > 35, 15).tolist() == [15, 45]


def test_fields_fade_linearly_between_few_nodes_and_stay_beyond() -> None:
    weights = node_weights(np.array([10, 20, 24]), np.array([5.0, 10.0, 12.5, 20.0, 23.0, 30.0]))
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)
    np.testing.assert_allclose(weights[:, 2], [0.75, 0.25, 0.0])
    np.testing.assert_allclose(weights[:, 4], [0.0, 0.25, 0.75])
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


def test_a_waterline_rises_by_heave_and_by_what_roll_lifts_a_side() -> None:
    """2 pi amplitude / period each: a box 8 m wide lifts its side at 4 m; one that never touches the sea has no waterline."""
    box = {"name": "b", "shape": "box", "length_m": 20, "width_m": 8, "height_m": 4, "scattering": "optics"}
    sway = {"heave_m": 0.5, "heave_period_s": 4, "roll_deg": 3, "roll_period_s": 5}
    afloat, aloft = scene([box | sway | {"name": str(up), "position_m": [0, 300, up]} for up in (-1, 50)]).bodies
    expected = 2 * np.pi * (0.5 / 4 + 4 * np.deg2rad(3) / 5)
    np.testing.assert_allclose(waterline_rise(afloat), expected, rtol=1e-12)
    assert waterline_rise(aloft) == 0.0
