"""Scattering centres by path: what legs weigh fields by where they are, over what the nodes of their lattice have."""

from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Complexes, Floats
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.plane_echoes import PlaneEchoes
from radar_service.scattering.physical_optics.scattering_centres import Lattice
from radar_service.scattering.physical_optics.sea_field import FLATTEST

DIVERGING = 0.99  # of the field: what the curved sea lowers less is shared linearly
NO_FIELD = 1e-9  # beyond the horizon
PATHS = ((0, 0), (0, 1), (1, 1))  # legs out and back of the direct path, the mixed ones, and both ways by the sea
Factors = Floats | Complexes | float


class PathCentres(NamedTuple):
    """Scattering centres (C,) of one path: how many of its ways go by the sea, position (C, 3) [m] in the body's frame, and
    amplitude (C,) [m]. A mixed path holds the sum of both orders."""

    path: int
    position: Floats
    amplitude: Complexes


def over_nodes(legs: tuple[BodyLeg, ...], lattice: Lattice, echoes: PlaneEchoes) -> list[Factors]:
    """What legs weigh echoes by where they are, over what the nodes of their lattice next to them have, by the number of ways by
    the sea; where a leg stands for all paths, at both ends of bounces."""
    nodes = legs[-1].weight(lattice.nodes)
    if len(legs) == 1:
        if legs[0].sea is None:
            return [1.0]
        both_ends = legs[0].sea.at(echoes.ends + float(legs[0].pose.position[2])).prod(axis=1)
        return [_ratio(both_ends, lattice.between(nodes**2))]
    if np.abs(nodes).min(initial=1.0) > DIVERGING:
        return [1.0] * 3
    at_points = legs[-1].weight(echoes.place)
    return [_ratio(at_points**ways, lattice.between(nodes**ways)) for ways in range(3)]


def _ratio(values: Floats | Complexes, shared: Floats | Complexes) -> Floats | Complexes:
    """Values (M,) over shared ones, 0 where there is no field."""
    return np.asarray(np.divide(values, shared, out=np.zeros_like(values), where=np.abs(shared) > NO_FIELD))


def flattest(legs: tuple[BodyLeg, ...]) -> float:
    """The height that cells may have [m]."""
    if legs[0].sea is not None:
        return legs[0].sea.flattest
    return FLATTEST if len(legs) > 1 else np.inf
