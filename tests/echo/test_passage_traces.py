"""Runs of nodes that share a trace: by hand, and for drawn passages what they promise."""

from math import ceil

import numpy as np
import pytest

from radar_service.echo.passage_traces import TraceRun, trace_runs

NODES = np.array([100, 103, 106, 109, 112, 115])


def test_a_body_that_turns_little_is_traced_once_in_the_middle_of_the_nodes_that_count() -> None:
    counts = np.array([False, True, True, True, True, False])
    runs = trace_runs(NODES, counts, np.linspace(0.0, 0.05, 6), 0.1)
    assert runs == dict.fromkeys(NODES.tolist(), TraceRun(108, (103, 106, 109, 112)))  # half way between 103 and 112


def test_a_body_that_turns_by_three_steps_has_two_runs_and_faint_nodes_share_those_at_the_ends() -> None:
    counts = np.array([False, True, True, True, True, False])
    runs = trace_runs(NODES, counts, np.array([0.0, 3.0, 4.0, 5.0, 6.0, 9.0]), 1.0)
    early, late = TraceRun(105, (103, 106)), TraceRun(110, (109, 112))  # at turns of 3.75 and 5.25
    assert runs == {100: early, 103: early, 106: early, 109: late, 112: late, 115: late}


def test_a_run_of_one_node_is_none() -> None:
    counts = np.array([False, True, True, True, True, True])
    runs = trace_runs(NODES, counts, np.array([0.0, 0.0, 0.1, 0.2, 5.0, 5.1]), 1.0)
    assert set(runs) == {100, 103, 106, 109, 112, 115}
    assert trace_runs(NODES[:3], np.ones(3, dtype=np.bool_), np.array([0.0, 1.0, 2.0]), 0.4) == {}


def test_where_no_node_counts_all_share_a_trace() -> None:
    runs = trace_runs(NODES, np.zeros(6, dtype=np.bool_), np.linspace(0.0, 9.0, 6), 0.1)
    assert set(runs) == set(NODES.tolist()) and len(set(runs.values())) == 1
    assert next(iter(runs.values())).nodes == ()


@pytest.mark.parametrize("seed", range(5))
def test_no_node_that_counts_is_farther_from_its_trace_than_a_step(seed: int) -> None:
    """Up to half a spoke, to which the place of a trace is rounded; and there are no more runs than that takes."""
    rng = np.random.default_rng(seed)
    nodes = np.cumsum(rng.integers(1, 9, 40))
    turned = np.concatenate([[0.0], np.cumsum(rng.exponential(0.1, 39))])
    counts = np.abs(np.arange(40) - 20) < rng.integers(3, 20)
    runs = trace_runs(nodes, counts, turned, 0.3)
    spoke = 0.5 * np.max(np.diff(turned) / np.diff(nodes))
    for node, turn, count in zip(nodes.tolist(), turned, counts, strict=True):
        if count and node in runs:
            run = runs[node]
            assert abs(float(np.interp(run.spoke, nodes, turned)) - turn) <= 0.3 + spoke
            assert node in run.nodes
    total = np.ptp(turned[counts])
    assert len(set(runs.values())) <= ceil(total / 0.6)
