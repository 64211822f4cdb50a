"""Counts and costs of an engine, as a plan reports them."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

from radar_service.numerics import Indices
from radar_service.plan.culling import CulledBody
from radar_service.world import Scene


@dataclass(frozen=True)
class Counts:
    """Counts of what the engine computes.

    resting_echoes: echoes of bodies at rest, computed once.
    moving_echoes: echoes of moving bodies in the first visibility update.
    shadowed_echoes: resting echoes that moving bodies occlude in the first visibility update.
    scatterers: fixed scatterers of all modelled bodies.
    set_up_rays: rays cast once, by preparation.
    look_rays: rays cast by the first visibility update.
    looks_per_scan: visibility updates per scan.
    transform_samples: samples of all Fourier transforms of one profile with moving echoes.
    """

    resting_echoes: int
    moving_echoes: int
    shadowed_echoes: int
    scatterers: int
    set_up_rays: int
    look_rays: int
    looks_per_scan: float
    transform_samples: int


@dataclass(frozen=True)
class Costs:
    """CPU time of one thread per azimuth [us], on average over a scan.

    looks: visibility updates.
    moving: moving echoes and their gridding.
    receiver: Fourier transforms and noise.
    profiles: schedule, resting profiles, detection and hand-over.
    aspects: physical optics as the beam passes; the gridding of its echoes is in `moving`.
    effects: of the effects of `stages`, by their names.
    """

    looks: float
    moving: float
    receiver: float
    profiles: float
    aspects: float = 0.0
    effects: Mapping[str, float] = field(default_factory=dict)

    @property
    def total(self) -> float:
        """The sum of all stages [us]."""
        return sum(self.by_stage().values())

    def by_stage(self) -> dict[str, float]:
        """All costs [us] by their names."""
        costs = asdict(self)
        return {**costs.pop("effects"), **costs}


@dataclass(frozen=True)
class PerBody:
    """Scatterers and echoes of each body (B,) of the scene.

    Echoes of moving bodies are those in all directions in the first visibility step.
    """

    scatterers: Indices
    echoes: Indices


@dataclass(frozen=True)
class EngineStatistics:
    """What is known of a scene.

    culled: bodies that are not modelled, by index.
    counts, bodies, costs: of the engine; None before it is prepared, and for `documented`.
    land_border: distance [m] from which on land under way is evaluated once a passage at the start; None where none is.
    """

    culled: Mapping[int, CulledBody] = field(default_factory=dict)
    counts: Counts | None = None
    bodies: PerBody | None = None
    costs: Costs | None = None
    land_border: float | None = None


def realtime_factor(scene: Scene, costs: Costs) -> float:
    """Simulated seconds per second of one thread."""
    return scene.radar.spoke_period / (costs.total * 1e-6) if costs.total > 0.0 else math.inf
