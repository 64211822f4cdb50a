"""Which nodes of a passage a shadow needs that moves over a body: those between which what the body scatters changes.

How fast a shadow may move bounds how close nodes must be (`ShadowRates`). But its edge mostly crosses little of what is lit. So
nodes are evaluated first between which it moves by SKIPPED times STEADY. Where one about the middle between two is off what
those so far have there, the halves are divided likewise, down to neighbours.

What is lit up to an edge that moves along a side has a Doppler shift of its own: its phase may turn several times between nodes.
Whole turns from one to the next look like none, so the two halves of a gap have no common divisor.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from radar_service.echo.passage_nodes import node_weights
from radar_service.numerics import Complexes, Floats, Indices, Singles
from radar_service.propagation import two_way_phase
from radar_service.radar import Radar
from radar_service.scattering import NEAREST, BodyEchoes, Caster
from radar_service.world import Body, Scene

STEADY = 0.001  # of a body's diagonal by which the edge of a shadow may move between two nodes,
COHERENT = 1.5  # and wavelengths: lit up to an edge that moves on by 3.4, a cell was off by 0.7 of the largest
SKIPPED = 16  # times STEADY by which the edge of a shadow may move between nodes that are always evaluated
CHANGE = 0.02  # of the field, by which the one in the middle may be off its neighbours: what is between errs by less
GRID = 1e-3  # m: echoes nearer to each other than this are the same scattering centre
BITS = 20  # of a coordinate in steps of GRID


class Fields(NamedTuple):
    """Fields (E,) of a body [m], and a key (E,) for the place of each: those of a key add up."""

    key: Indices
    field: Complexes


Evaluate = Callable[[Sequence[int], int], list[Fields]]  # at nodes, and as they are at one spoke


@dataclass(frozen=True)
class ShadowRates:
    """The shadows on one body.

    scene: with own ship and all bodies. body: the one that is shadowed.
    """

    scene: Scene
    body: Body

    def moving(self, others: Sequence[int], time: Floats) -> list[int]:
        """Other bodies whose shadow may move noticeably over the body between times (K,) [s], at any position of the body."""
        antenna, span = self.scene.antenna(time), float(np.ptp(time))
        moving = []
        for key in others:
            body = self.scene.bodies[key]
            nearest = float(np.hypot(*(body.middles_at(time) - antenna)[:, :2].T).min()) - body.radius
            if float(self.rate([Caster(key, nearest)], time).max()) * span > 1.0:
                moving.append(key)
        return moving

    def rate(self, casters: list[Caster], time: Floats) -> Floats:
        """Speed (K,) of the fastest shadow at times (K,) [s], in steps of STEADY or COHERENT, the smaller one, a second."""
        antenna = self.scene.antenna(time)
        own, spin = self._velocity(self.body, time, antenna)
        position = self.body.middles_at(time) - antenna
        distance = np.maximum(np.linalg.norm(position, axis=1), NEAREST)
        fastest = np.zeros(len(time))
        for caster in casters:
            other, other_spin = self._velocity(self.scene.bodies[caster.key], time, antenna)
            ratio = distance / max(caster.distance, NEAREST)
            edge = ratio[:, None] * other - own
            radial = np.einsum("kx,kx->k", edge, position) / distance
            across = np.sqrt(np.maximum((edge**2).sum(axis=1) - radial**2, 0.0))
            np.maximum(fastest, across + spin + ratio * other_spin, out=fastest)
        return fastest / self._step

    @cached_property
    def _step(self) -> float:
        """By which the edge of a shadow may move between nodes [m]."""
        return min(STEADY * self.body.diagonal, COHERENT * self.scene.radar.wavelength)

    @property
    def skipped(self) -> int:
        """How many steps of `rate` lie between nodes that are always evaluated."""
        return int(SKIPPED * STEADY * self.body.diagonal / self._step)

    def _velocity(self, body: Body, time: Floats, antenna: Floats) -> tuple[Floats, Floats]:
        """Velocities (K, 3) of a body's middle against the antenna, and speeds (K,) of its parts about it [m/s]."""
        velocity = np.gradient(body.middles_at(time) - antenna, time, axis=0)
        turn = np.abs(np.gradient(np.unwrap(body.motion.pose(time).heading), time))
        return velocity, turn * body.radius + (body.top_speed - body.motion.top_speed)


def telling_nodes(
    nodes: Indices, unshaded: Indices, slack: Callable[[Indices], Floats], evaluate: Evaluate, skipped: int = SKIPPED
) -> Indices:
    """The nodes (M,) that are needed [spokes, rising], the first and the last one always.

    unshaded: nodes (U,) that the motion needs without a shadow. slack: how many times CHANGE the field at spokes (K,) may be off.
    evaluate: the fields at nodes, as they are at one spoke. skipped: nodes from one that is always evaluated to the next.
    """
    moving = np.abs(nodes - unshaded[:, None]).argmin(axis=1).tolist() if len(unshaded) > 1 else ()
    ends = np.unique([0, *moving, len(nodes) - 1])
    firm = np.unique(
        [round(k) for low, high in pairwise(ends) for k in np.linspace(low, high, -(-(high - low) // skipped) + 1)]
    ).tolist()
    size = max(float(np.linalg.norm(evaluate([int(nodes[row])], int(nodes[row]))[0].field)) for row in firm)
    allowed = CHANGE * size * slack(nodes)
    chosen, gaps = firm, list(pairwise(firm))
    while gaps:
        halved = [(begin, _middle(nodes, begin, end), end) for begin, end in gaps if end - begin > 1]
        gaps, known, off = [], nodes[chosen], np.zeros(len(halved) + 2, dtype=np.bool_)
        for k, (_, middle, _) in enumerate(halved):
            weight = node_weights(known, nodes[[middle]].astype(np.float64))[:, 0]
            near = np.flatnonzero(weight)
            exact, *others = evaluate([int(nodes[middle]), *known[near].tolist()], int(nodes[middle]))
            error = _difference(exact, others, weight[near])
            off[k + 1] = error > allowed[middle]
            chosen = chosen if error <= allowed[middle] / 2.0 else sorted([*chosen, middle])
        for k, (begin, middle, end) in enumerate(halved):  # one beside such a gap may be right by chance
            gaps += [(begin, middle), (middle, end)] if off[k : k + 3].any() else []
        chosen = sorted({*chosen, *(end for _, end in gaps[:-1])})
    return nodes[_graded(chosen)]


def _middle(nodes: Indices, begin: int, end: int) -> int:
    """The node next to the middle between two others whose distances from these, in spokes, have no common divisor; the nearest
    one where all have."""
    between = np.arange(begin + 1, end)
    before, after = nodes[between] - nodes[begin], nodes[end] - nodes[between]
    order = np.lexsort((np.abs(before - after), np.gcd(before, after) > 1))
    return int(between[order[0]])


def _graded(chosen: Sequence[int]) -> Indices:
    """Rising numbers, and so many between them that no gap is over twice the one beside it, as cubics need."""
    every = list(chosen)
    at = 0
    while at < len(every) - 1:
        gap = every[at + 1] - every[at]
        beside = [every[k + 1] - every[k] for k in (at - 1, at + 1) if 0 <= k < len(every) - 1]
        if gap > 2 * min(beside, default=gap):
            every.insert(at + 1, every[at] + gap // 2)
            at = max(at - 1, 0)
        else:
            at += 1
    return np.array(every, dtype=np.int64)


def _difference(exact: Fields, others: Sequence[Fields], weights: Singles) -> float:
    """By how much a field is off the weighted sum of others (N,), key by key; a root of powers."""
    weighted = [other.field * weight for other, weight in zip(others, weights, strict=True)]
    field = np.concatenate([-exact.field, *weighted])
    _, place = np.unique(np.concatenate([exact.key, *(other.key for other in others)]), return_inverse=True)
    return float(np.linalg.norm(np.bincount(place, field.real) + 1j * np.bincount(place, field.imag)))


def by_centre(echoes: BodyEchoes) -> Fields:
    """The fields of scattering centres, which a body that does not sway has in the same places at each node."""
    x, y, z = (np.rint(axis / GRID).astype(np.int64) & (2**BITS - 1) for axis in echoes.position.T)
    return Fields(np.asarray((((x << BITS | y) << BITS | z) << 2) | (echoes.path & 3)), echoes.amplitude)


def by_range(echoes: BodyEchoes, distance: Floats, radar: Radar) -> Fields:
    """The fields in range cells, shared linearly between two, as echoes are at distances (E,) [m]."""
    cell = distance / radar.range_resolution
    share, key = cell % 1.0, (cell.astype(np.int64) << 2) | (echoes.path & 3)
    field = echoes.amplitude * two_way_phase(distance, radar.wavelength)
    return Fields(np.concatenate([key, key + 4]), np.concatenate([field * (1.0 - share), field * share]))
