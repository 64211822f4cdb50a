"""The interface between the scene and the engine: what a scattering model receives, and what it returns.

To add a model: write a class like `ScatteringModel`, here or in another package, and an entry point `radar_service.scattering`:
scene files then know its name. All that readers of scenes, the plan and the truth need to know of a model, they ask it:
also the errors that it predicts of itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol, Self

import numpy as np

from radar_service.numerics import Complexes, Flags, Floats, Indices
from radar_service.radar import Radar
from radar_service.records import Fidelity
from radar_service.trace import OcclusionScene, RayCount
from radar_service.world import Body, Environment, Scene

ALL_PATHS, DIRECT, ONE_WAY, BOTH_WAYS = -1, 0, 1, 2
NEAREST = 16.0  # m: parts of a body are taken as no nearer: no marine antenna observes nearer bodies


@dataclass(frozen=True)
class Conditions:
    """What a prediction depends on, besides the body and its run.

    radar, environment, fidelity: of the simulation.
    antenna: (3,) at time 0 on the map [m].
    scatterers: how many fixed scatterers the body has; None before they are drawn.
    """

    radar: Radar
    environment: Environment
    fidelity: Fidelity
    antenna: Floats
    scatterers: int | None = None

    @classmethod
    def of_scene(cls, scene: Scene, fidelity: Fidelity, scatterers: int | None = None) -> "Conditions":
        """The conditions of a body of a scene with so many scatterers."""
        return cls(scene.radar, scene.environment, fidelity, scene.antenna(0.0)[0], scatterers)


class BodyRun(NamedTuple):
    """What a body does over a run, seen from the antenna.

    nearest: least ground distance of its nearest part [m], at least 0.
    approach: least ground distance of its middle [m].
    time: when its middle is nearest [s].
    turn: highest rate at which its aspect changes [rad/s].
    radial: highest rate of range [m/s].
    sea_turn: highest rate of the angle between the direct ray and the one by the sea [rad/s].
    start: ground distance of its middle at the start [m].
    """

    nearest: float
    approach: float
    time: float
    turn: float
    radial: float
    sea_turn: float
    start: float


class RunError(NamedTuple):
    """What a run adds to the error of a body's mean power [dB], and sentences about it."""

    power_db: float = 0.0
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class BodyEchoes:
    """Echoes (M,) of bodies, valid for as long as the aspect hardly changes.

    position: (M, 3) of the phase centre in the body's own frame [m].
    amplitude: (M,) root of the radar cross-section [m], with the phase at that point.
    body: (M,) index of the body among the model's (or the set's) bodies.
    path: (M,) how many of the two ways go by the sea: DIRECT, ONE_WAY or BOTH_WAYS; ALL_PATHS for points that stand for all
        of them at once, by the two-ray factor F^2.
    height_span: (M,) vertical extent of what the echo stands for [m], over which |F|^4 is averaged; 0 for a point.
    """

    position: Floats
    amplitude: Complexes
    body: Indices
    path: Indices
    height_span: Floats

    def __post_init__(self) -> None:
        assert self.position.shape == (len(self.body), 3) and self.amplitude.shape == self.body.shape
        assert self.path.shape == self.height_span.shape == self.body.shape

    @classmethod
    def of_points(cls, position: Floats, amplitude: Complexes, body: Indices) -> "BodyEchoes":
        """Echoes of points (M,), each standing for all paths."""
        return cls(position, amplitude, body, np.full(len(body), ALL_PATHS, dtype=np.int64), np.zeros(len(body)))

    @classmethod
    def joined(cls, parts: "Sequence[BodyEchoes]") -> "BodyEchoes":
        """All echoes of several parts, in their order."""
        if len(parts) == 1:
            return parts[0]
        none = cls.of_points(np.zeros((0, 3)), np.zeros(0, dtype=np.complex128), np.zeros(0, dtype=np.int64))
        names = cls.__dataclass_fields__
        return cls(*(np.concatenate([getattr(part, name) for part in (none, *parts)]) for name in names))

    def chosen(self, which: Indices) -> "BodyEchoes":
        """The echoes `which` (N,)."""
        return BodyEchoes(*(getattr(self, name).take(which, axis=0) for name in self.__dataclass_fields__))

    def __len__(self) -> int:
        return len(self.body)


class BearingWedge(NamedTuple):
    """Bearings within `half` of `middle` [rad] from an antenna (3,), and all that is nearer than `near` [m]."""

    antenna: Floats
    middle: float
    half: float
    near: float

    def contains(self, position: Floats, size: Floats | float = 0.0) -> Flags:
        """Which map positions (M, 3) lie in the wedge, or have a part of it within `size` (M,) [m]."""
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
    wedge: bearings of interest; a model may return echoes outside of it; None: all.
    """

    time: float
    line_of_sight: OcclusionScene
    max_range: float
    movers: bool = True
    wedge: BearingWedge | None = None


class Caster(NamedTuple):
    """A body that may cast a shadow on another: its index in the scene, and the distance of what may cast it [m]."""

    key: int
    distance: float


@dataclass(frozen=True)
class ScatteringContext:
    """What models are built from, besides their bodies.

    radar, fidelity, seed: of the simulation.
    antenna: (3,) at time 0 on the map [m]: the density of scatterers follows the resolution cell at its distance.
    environment: of the scene: whether the sea reflects.
    scene_bodies: all bodies of the scene: rays meet them all.
    earth_radius: effective, inf for flat [m].
    rays: counts the rays cast, where given.
    scene_name: with the body's name it keys the scatterers, which the other bodies then do not change.
    """

    radar: Radar
    fidelity: Fidelity
    seed: int
    antenna: Floats
    environment: Environment
    scene_bodies: Sequence[Body]
    earth_radius: float
    rays: RayCount | None = None
    scene_name: str = ""


class ScatteringModel(Protocol):
    """How some bodies (B,) of a scene scatter.

    by_aspect: whether it is an `AspectModel`.
    diffracts: whether echoes reach beyond the horizon by diffraction.
    lit_by_sea: whether parts that only the path by the sea reaches have echoes.
    tells_sea_delay: whether the plan tells how much longer the path by the sea is than the direct range that echoes keep.
    has_resting_points: whether it is a `resting_points.RestingModel`.
    """

    by_aspect: ClassVar[bool] = False
    diffracts: ClassVar[bool] = False
    lit_by_sea: ClassVar[bool] = False
    tells_sea_delay: ClassVar[bool] = False
    has_resting_points: ClassVar[bool] = False

    def __init__(self, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> None: ...

    @classmethod
    def build(cls, bodies: Sequence[Body], key: Indices, context: ScatteringContext) -> Self:
        """The model of `bodies`; key: (B,) the index of each in the scene, rising."""
        return cls(bodies, key, context)

    key: Indices  # (B,) index of each body in the scene
    scatterers: Indices  # (B,) how many fixed scatterers each body has; 0 for models without

    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        """Echoes as the antenna (3,) on the map [m] observes them, by all paths that the environment has. `body` rises."""
        ...

    @staticmethod
    def max_rcs(body: Body, radar: Radar, fidelity: Fidelity) -> float:
        """A radar cross-section [m^2] that the body hardly ever exceeds: by it bodies are culled."""
        ...

    @staticmethod
    def description(body: Body, conditions: Conditions, computed: str) -> str:
        """How the body is modelled, for the plan; computed: how often, as "computed once"."""
        ...

    @staticmethod
    def sampling_db(scatterers: int, multipath: bool) -> float:
        """Predicted error of the mean power of a surface with so many scatterers [dB]; 0 for models without."""
        return 0.0

    @classmethod
    def error_db(cls, body: Body, conditions: Conditions) -> float | None:
        """Predicted error of the body's mean power at the start of a run [dB], None where unknown."""
        ...

    @staticmethod
    def run_error(body: Body, conditions: Conditions, run: BodyRun) -> RunError:
        """What the error of a body with a mesh grows by over a run."""
        return RunError()

    @staticmethod
    def coherence_at(body: Body, radar: Radar, nearest: float) -> float:
        """Size [m] over which phases are summed into one echo of a body whose nearest part is so far away [m]; 0 where echoes do
        not depend on aspect."""
        return 0.0

    @staticmethod
    def shape_sag(shape: str, wavelength: float) -> float | None:
        """How far facets of a built-in shape may be off its curves at a wavelength [m]; None: as far as `world.shapes` has it."""
        return None

    @staticmethod
    def mesh_remarks(body: Body, conditions: Conditions, nearest: float) -> list[str]:
        """What `check` says of the body's mesh at its `nearest` distance [m]: whether it is fine enough for this model."""
        return []


class AspectModel(ScatteringModel, Protocol):
    """A model whose echoes hold for one aspect alone: each body is evaluated at instants at which the beam passes it."""

    def body_echoes(self, b: int, antenna: Floats, instant: Instant) -> BodyEchoes:
        """Echoes of body b alone, as the antenna (3,) observes it at the instant."""
        ...

    def casters(
        self, b: int, among: Mapping[int, float], antenna: Floats, instant: Instant, own_moved: float
    ) -> list[Caster]:
        """Other bodies that may cast a shadow on body b about an instant; none is missing.

        among: by their index in the scene, how far each may be from where it is, present or not, against the antenna (3,) [m];
        own_moved: how far body b may be.
        """
        ...

    def coherence(self, b: int, distance: float) -> float:
        """Size [m] over which phases are summed into one echo of body b at `distance` [m]."""
        ...

    def upright(self, b: int, distance: float) -> float:
        """The height [m] of what `coherence` is the length of."""
        ...
