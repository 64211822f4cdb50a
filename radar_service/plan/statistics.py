"""What an engine computes, and what that costs: the figures that a plan reports."""

import math
from dataclasses import dataclass, field

from radar_service.plan.culling import Culling
from radar_service.scene.world import Scene
from radar_service.types import Indices


@dataclass(frozen=True)
class Counts:
    """What the engine computes.

    resting_echoes: once.
    moving_echoes, shadowed_echoes: in the first visibility update.
    scatterers: on the modelled bodies.
    set_up_rays: cast once.
    look_rays: cast by the first visibility update.
    looks_per_scan: visibility updates per scan.
    transform_samples: of all Fourier transforms of one profile with moving echoes.
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

    looks: of visibility updates.
    moving: of moving echoes and their gridding.
    receiver: of transforms and noise.
    clutter: of sea and rain.
    interference: of other radars.
    profiles: of handing profiles over.
    """

    looks: float
    moving: float
    receiver: float
    clutter: float
    interference: float
    profiles: float

    @property
    def total(self) -> float:
        """All of it [us]."""
        return self.looks + self.moving + self.receiver + self.clutter + self.interference + self.profiles


@dataclass(frozen=True)
class PerBody:
    """Of each body (B,) of the scene: its scatterers, and its echoes, at rest or all round in the first visibility step."""

    scatterers: Indices
    echoes: Indices


@dataclass(frozen=True)
class EngineStatistics:
    """What is known of a scene. culling: what is left out; counts, bodies, costs: of the engine, None before it is prepared,
    and for `documented`."""

    culling: Culling = field(default_factory=Culling)
    counts: Counts | None = None
    bodies: PerBody | None = None
    costs: Costs | None = None


def realtime_factor(scene: Scene, costs: Costs) -> float:
    """Simulated seconds per second of one thread."""
    return scene.radar.spoke_period / (costs.total * 1e-6) if costs.total > 0.0 else math.inf
