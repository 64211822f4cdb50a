"""Echoes of a body at all nodes of a passage, where they are those of the same scattering centres: a table of amplitudes.

Nodes share the range histories of their centres. So each centre is computed once at an azimuth, with the amplitude that it has
between the nodes, however many these are.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from radar_service.echo.block_geometry import ObservedEchoes
from radar_service.numerics.types import Complexes, Floats, Profiles, Singles
from radar_service.scattering.model import BodyEchoes


class PassageTable(NamedTuple):
    """Echoes (M,) of one body with amplitude 1, their position (M, 3) on the map at the middle node [m], and amplitudes (M, N) at
    the nodes (N,) of a part of a passage [m]."""

    echoes: BodyEchoes
    position: Floats
    amplitude: Profiles

    @classmethod
    def of(cls, echoes: BodyEchoes, amplitude: Complexes, body: int, position: Floats) -> "PassageTable":
        """Of echoes (M,) of a body, an index of the set, whose amplitudes (M, N) at nodes are `amplitude`."""
        ones = np.ones(len(echoes), dtype=np.complex128)
        echoes = replace(echoes, amplitude=ones, body=np.full(len(echoes), body))
        return cls(echoes, position, amplitude.astype(np.complex64))

    def observed(self, weights: Singles) -> ObservedEchoes:
        """The echoes at azimuths (K,), by the weights (N, K) of the nodes there."""
        some = np.flatnonzero(weights.any(axis=1))
        fade = self.amplitude.take(some, axis=1) @ weights[some].astype(np.complex64)
        return ObservedEchoes(self.echoes, self.position, fade)


def joined(parts: list[ObservedEchoes]) -> list[ObservedEchoes]:
    """The echoes of several parts as one; none of none. Their fades are of one kind."""
    if len(parts) < 2:
        return parts
    fades: list[Any] = [part.fade for part in parts if part.fade is not None]
    position = np.concatenate([part.position for part in parts])
    return [ObservedEchoes(BodyEchoes.joined([part.echoes for part in parts]), position, np.concatenate(fades))]
