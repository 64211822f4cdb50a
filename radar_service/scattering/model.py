"""The interface between the scene and the engine: what a scattering model receives, and what it returns.

To add a model: write a class like `ScatteringModel` in a file of this package, list it in `scattering.models`, and add its name
to `scene.body.Scattering`: scene files then know it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, Self

import numpy as np

from radar_service.fidelity import Fidelity
from radar_service.radar.parameters import Radar
from radar_service.scattering.beam_crossing import BeamCrossing
from radar_service.scene.body import Body
from radar_service.scene.world import Scene
from radar_service.trace.embree import RayCount
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.types import Complexes, Flags, Floats, Indices


@dataclass(frozen=True)
class BodyEchoes:
    """Echoes (M,) of bodies, valid for as long as the aspect hardly changes.

    position: (M, 3) of the phase centre in the body's own frame [m].
    amplitude: (M,) root of the radar cross-section [m], with the phase at that point.
    body: (M,) index of the body among the model's (or the set's) bodies.
    """

    position: Floats
    amplitude: Complexes
    body: Indices

    def __post_init__(self) -> None:
        assert self.position.shape == (len(self.body), 3) and self.amplitude.shape == self.body.shape

    def __len__(self) -> int:
        return len(self.body)


class Sector(NamedTuple):
    """Bearings within `half` of `middle` [rad] from an antenna (3,), and all that is nearer than `near` [m]."""

    antenna: Floats
    middle: float
    half: float
    near: float

    def contains(self, position: Floats, size: Floats | float = 0.0) -> Flags:
        """Which map positions (M, 3) lie in the sector, or have a part of it within `size` (M,) [m]."""
        east, north = position[:, 0] - self.antenna[0], position[:, 1] - self.antenna[1]
        distance = np.sqrt(east * east + north * north)
        ahead = east * np.sin(self.middle) + north * np.cos(self.middle)
        near = distance <= self.near + size
        if self.half >= np.pi:
            return np.ones(len(position), dtype=np.bool_)
        if np.any(size):
            aside = np.arcsin(np.divide(size, distance, out=np.ones_like(distance), where=~near))
            return np.asarray(near | (ahead >= distance * np.cos(np.minimum(self.half + aside, np.pi))))
        return np.asarray(near | (ahead >= distance * np.cos(self.half)))


@dataclass(frozen=True)
class Instant:
    """When and through what bodies are observed.

    time: of the poses of all bodies [s].
    line_of_sight: decides what is visible.
    max_range: beyond it nothing is visible [m].
    movers: whether bodies that move may occlude.
    sector: bearings of interest; a model may return echoes outside of it; None: all.
    """

    time: float
    line_of_sight: OcclusionScene
    max_range: float
    movers: bool = True
    sector: Sector | None = None


@dataclass(frozen=True)
class ScatteringContext:
    """What models are built from, besides their bodies.

    radar, fidelity, seed: of the simulation.
    antenna: (3,) at time 0 on the map [m]: the density of scatterers follows the resolution cell at its distance.
    scene_bodies: all bodies of the scene: rays meet them all.
    earth_radius: effective, inf for flat [m].
    crossing: when the beam crosses bodies, for sets that move; None where everything rests.
    rays: counts the rays cast, where given.
    """

    radar: Radar
    fidelity: Fidelity
    seed: int
    antenna: Floats
    scene_bodies: Sequence[Body]
    earth_radius: float
    crossing: BeamCrossing | None = None
    rays: RayCount | None = None


class ScatteringModel(Protocol):
    """How some bodies (B,) of a scene scatter."""

    @classmethod
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        """The model of `bodies`; key: (B,) the index of each in the scene, rising."""
        ...

    key: Indices  # (B,) index of each body in the scene
    scatterers: Indices  # (B,) how many fixed scatterers each body has; 0 for models without

    def echoes(self, launch: Floats, receive: Floats, instant: Instant) -> BodyEchoes:
        """Echoes of waves launched at one point (3,) and received at another (3,), on the map [m].

        The two differ where the sea's image of the antenna replaces one of them. `body` rises.
        """
        ...

    def clear(self) -> None:
        """Drops cached results, so that the next call can be timed."""
        ...

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """A radar cross-section [m^2] that the body hardly ever exceeds: by it bodies are culled."""
        ...

    @staticmethod
    def description(body: Body, scene: Scene, fidelity: Fidelity, computed: str) -> str:
        """How the body is modelled, for the plan; computed: "computed once" or "computed at each azimuth"."""
        ...

    @staticmethod
    def error_db(body: Body, scene: Scene, fidelity: Fidelity, scatterers: int | None) -> float | None:
        """Predicted error of the body's mean power [dB], None where unknown; scatterers: how many it has, None: not built."""
        ...
