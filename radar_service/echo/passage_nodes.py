"""Nodes of a beam's passage: how far apart they are, and how fields are interpolated between them."""

import numpy as np

from radar_service.scene.body import Body
from radar_service.types import Flags, Floats, Indices, Singles

CUBIC = 4  # nodes, between which fields are interpolated by cubics


def waterline_rise(body: Body) -> float:
    """The highest speed [m/s] at which a swaying body rises through the sea at its waterline; 0 where it has none.

    The waterline stays at the sea: its echoes leave those of the body by 2 k z sin(elevation). Twice that is counted: else a
    heaving hull errs by up to -7 dB between nodes, and now by -23 dB (tests/test_sway_of_bodies.py).
    """
    sway = body.motion.sway
    assert sway is not None and body.mesh is not None
    lowest = float(body.motion.position[:, 2].min() + body.mesh.vertices[:, 2].min())
    if lowest > sway.max_heave + body.arm * np.sin(sway.max_tilt):
        return 0.0
    aside, ahead = np.abs(body.mesh.vertices[:, :2]).max(axis=0)
    roll, pitch, _, heave = sway.max_rates
    return float(heave + aside * roll + ahead * pitch)


def outward_nodes(offset: Floats, spacing: Floats, held: Flags, first: int) -> Indices:
    """Whole offsets (M,) from `first` on [spokes], as far apart as `spacing` (S,) allows at each of `offset` (S,).

    They end past the last offset, or where the last node may be held (S,) from there on.
    """
    nodes = [first]
    while nodes[-1] < offset[-1]:
        after = min(int(np.searchsorted(offset, nodes[-1], side="right")), len(offset) - 1)
        if held[after - 1]:
            break
        nodes.append(nodes[-1] + max(1, int(min(spacing[after - 1], spacing[after]))))
    return np.array(nodes, dtype=np.int64)


def node_weights(nodes: Indices, spoke: Floats) -> Singles:
    """Weights (M, K) of nodes (M,) at spokes (K,), those of the outer nodes beyond them.

    Of four nodes or more they are cubic between the nearest four (Lagrange), of fewer linear between neighbours.
    """
    within = np.clip(spoke, nodes[0], nodes[-1])
    order = CUBIC if len(nodes) >= CUBIC else min(2, len(nodes))
    after = np.searchsorted(nodes, within, side="right")
    first = np.clip(after - order // 2, 0, len(nodes) - order)
    near = first + np.arange(order)[:, None]
    gap = within - nodes[near]
    weight = np.zeros((len(nodes), len(spoke)), dtype=np.float32)
    for one in range(order):
        others = [other for other in range(order) if other != one]
        apart = np.prod(nodes[near[one]] - nodes[near[others]], axis=0)
        weight[near[one], np.arange(len(spoke))] = np.prod(gap[others], axis=0) / apart
    return weight
