"""Nodes of a beam's passage: how far apart they are, and how fields are interpolated between them.

A passage has parts, between which the motion has a corner: no field is interpolated across one. Each part has nodes of its own.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Floats, Indices, Singles
from radar_service.radar import Radar

MAX_PHASE = 0.4  # rad between nodes: on the way from one to the next, cells lose up to theta^2 / 12, 1.3 % or 0.12 dB
CUBIC_PHASE = 0.8  # rad between nodes of these: up to 3 theta^4 / 128 is lost on the way, 1 %, in the outer intervals 1.7 %
ALL_ROUND = 0.5  # of both phases where the full circle of the beam counts: what is lost is a quarter, of cubics a sixteenth
QUADRATIC_PHASE = 0.6  # rad between three nodes: up to theta^3 / 15.6 is lost on the way, 1.4 %
HELD_PHASE = 0.33  # rad times gain, or rms over the beam: up to it a node is held; 3 times as much errs no more (tests)
END_PHASE = HELD_PHASE / 6.0  # rad times gain: no node lies farther out than where one may be held with that
EDGE_PHASE = 0.25  # rad at the edge of the main beam: one node errs by 4 %, at 0.5 rad by 12 % (tests/echo)
MAIN_BEAM = 0.1  # one-way gain: 20 dB of two-way power, down to which each spoke keeps its aspect to 1 dB
CUBIC = 4  # nodes, between which fields are interpolated by cubics
SAMPLES = 17  # offsets on each side of a crossing at which rates are taken
GAINS_PER_BEAMWIDTH = 32  # of the envelope of sidelobes
GAIN_SAMPLES = 1056  # of a part, at which the gain is taken


class Part(NamedTuple):
    """Spokes of a passage from `first` to `last`, inf where the passage goes on; the nodes (M,) between them."""

    first: float
    last: float
    nodes: Indices

    def weights(self, spoke: Floats) -> Singles:
        """Weights (M, K) of the nodes at spokes (K,), 0 outside the part."""
        within = (spoke > self.first - 0.5) & (spoke <= self.last + 0.5)
        if len(self.nodes) == 1:
            return within[None].astype(np.float32)
        before, after = spoke.max() <= self.nodes[0], spoke.min() >= self.nodes[-1]
        if before or after:  # as of `node_weights`, which takes longer
            weights = np.zeros((len(self.nodes), len(spoke)), dtype=np.float32)
            weights[0 if before else -1] = within
            return weights
        return node_weights(self.nodes, spoke) * within


class Stretch(NamedTuple):
    """Offsets from a crossing [spokes] between which a motion is smooth, and whether there is a corner at either end."""

    first: float
    last: float
    begins: bool = False
    ends: bool = False

    @property
    def nearest(self) -> float:
        """The spoke of the stretch nearest to the crossing, counted from it."""
        return min(max(0.0, self.first), self.last)


def stretches(corners: list[int], reach: float) -> list[Stretch]:
    """The stretches of a passage from `-reach` to `reach` spokes. corners: offsets of the spokes that begin after a corner."""
    begins, ends = [-reach, *corners], [*(corner - 1.0 for corner in corners), reach]
    last = len(corners)
    return [Stretch(begins[k], ends[k], k > 0, k < last) for k in range(last + 1)]


class Side(NamedTuple):
    """One side of a stretch, outward from the offset nearest to the crossing.

    away: distances (SAMPLES,) from there [spokes].
    gain: one-way, at each. rate: of the phase, at each [rad per spoke].
    corner: whether it ends at one.
    """

    away: Floats
    gain: Floats
    rate: Floats
    corner: bool

    def spacing(self, phase: float, power: int, longest: float) -> Floats:
        """How far apart nodes may be at each distance [spokes], the farther the less the beam receives, at most `longest`.

        phase: between nodes [rad]; power: of it that the error grows with.
        """
        slack = np.maximum(1.0, MAIN_BEAM / self.gain) ** (1.0 / power)
        return np.asarray(slack * phase / np.maximum(self.rate, phase / longest))

    def nodes(self, spacing: Floats, first: int) -> Indices:
        """Whole distances (M,) of nodes from `first` on; none is beyond a corner."""
        end = self.away[-1]
        nodes = outward_nodes(self.away, spacing, self.rate * (end - self.away) * self.gain, first)
        return np.minimum(nodes, round(end)) if self.corner else nodes


def part_nodes(
    stretch: Stretch, gain: Callable[[Floats], Floats], rate: Callable[[Floats], Floats], all_round: bool
) -> Indices:
    """Offsets of nodes (M,) from a crossing [spokes], rising.

    gain: one-way gain at offsets. rate: of the phase at offsets [rad per spoke]. all_round: whether every offset counts alike.
    """
    near = stretch.nearest
    before, after = (near + np.linspace(0.0, end - near, SAMPLES) for end in (stretch.first, stretch.last))
    offset = np.unique(np.concatenate([before, after]))
    rates = rate(offset) if len(offset) > 1 else np.zeros(1)
    if float(np.max(rates)) * held_spokes(stretch, gain) <= 1.0:
        return np.array([round(near)])
    corners = (stretch.begins, stretch.ends)
    sides = [
        Side(np.abs(side - near), gain(side), np.interp(side, offset, rates), corner)
        for side, corner in zip((before, after), corners, strict=True)
    ]
    finer, longest = ALL_ROUND if all_round else 1.0, stretch.last - stretch.first
    for phase, order in ((QUADRATIC_PHASE, 3), (CUBIC_PHASE, CUBIC)):
        nodes = _nodes_about(sides, [side.spacing(finer * phase, order, longest) for side in sides], all_round)
        if len(nodes) == 3 or len(nodes) >= order == CUBIC:
            return nodes + round(near)
    return _nodes_about(sides, [side.spacing(finer * MAX_PHASE, 2, longest) for side in sides], all_round) + round(near)


def _nodes_about(sides: list[Side], spacing: list[Floats], centred: bool) -> Indices:
    """Distances (M,) of nodes on both sides, negative before. Both begin half an interval away, or with a node between them
    where that takes fewer, where there is one side alone, or where it is `centred`."""
    alone, first = centred or min(side.away[-1] for side in sides) == 0.0, max(1, int(min(s[:2].min() for s in spacing)))

    def about(first: int) -> Indices:
        begins = first // 2, first - first // 2
        before, after = (side.nodes(s, begin) for side, s, begin in zip(sides, spacing, begins, strict=True))
        return np.unique(np.concatenate([-before, after]))

    return min(map(about, (0,) if alone else (0, first)), key=len)


def held_spokes(stretch: Stretch, gain: Callable[[Floats], Floats]) -> float:
    """The inverse of the rate [spokes/rad] up to which one node serves a whole stretch."""
    spoke = np.linspace(stretch.first, stretch.last, GAIN_SAMPLES)
    away, weight = np.abs(spoke - stretch.nearest), gain(spoke)
    spread = np.sqrt(np.sum((away * weight) ** 2) / np.sum(weight**2))
    return float(max(spread / HELD_PHASE, away[weight >= MAIN_BEAM].max(initial=0.0) / EDGE_PHASE))


def outward_nodes(offset: Floats, spacing: Floats, missed: Floats, first: int) -> Indices:
    """Whole offsets (M,) from `first` on [spokes], as far apart as `spacing` (S,) allows at each of `offset` (S,).

    They end past the last offset, or as soon as the last node may be held from there on. missed: phase times gain (S,)
    that the last node is off by at most [rad].
    """
    nodes = [first]
    last = math.ceil(offset[(missed <= END_PHASE) | (offset == offset[-1])][0])
    while nodes[-1] < offset[-1]:
        after = min(int(np.searchsorted(offset, nodes[-1], side="right")), len(offset) - 1)
        if missed[after - 1] <= HELD_PHASE:
            break
        step = max(1, int(min(spacing[after - 1], spacing[after])))
        nodes.append(min(nodes[-1] + step, max(last, nodes[-1] + 1)))
    return np.array(nodes, dtype=np.int64)


def node_weights(nodes: Indices, spoke: Floats) -> Singles:
    """Weights (M, K) of nodes (M,) at spokes (K,), those of the outer nodes beyond them.

    Of four nodes or more they are cubic between the nearest four (Lagrange), of three quadratic, of two linear.
    """
    within = np.clip(spoke, nodes[0], nodes[-1])
    order = min(CUBIC, len(nodes))
    after = np.searchsorted(nodes, within, side="right")
    first = np.clip(after - order // 2, 0, len(nodes) - order)
    near = first + np.arange(order)[:, None]
    gap = within - nodes[near]
    weight = np.zeros((len(nodes), len(spoke)), dtype=np.float32)
    for k in range(order):
        others = [other for other in range(order) if other != k]
        apart = np.prod(nodes[near[k]] - nodes[near[others]], axis=0)
        weight[near[k], np.arange(len(spoke))] = np.prod(gap[others], axis=0) / apart
    return weight


def sidelobe_envelope(radar: Radar) -> Floats:
    """The highest one-way gain from each offset on, evenly from 0 to half a circle."""
    count = int(np.pi / radar.beamwidth * GAINS_PER_BEAMWIDTH) + 2
    gain = radar.azimuth_gain(np.linspace(0.0, np.pi, count))
    return np.asarray(np.maximum.accumulate(gain[::-1])[::-1])
