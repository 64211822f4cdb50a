"""What is known of a scene once its engine is set up: what the plan is written from."""

import math
from dataclasses import dataclass, field

from radar_service.plan.cost_model import Costs, Counts, PerBody
from radar_service.plan.culling import CulledBody
from radar_service.scene.world import Scene


@dataclass(frozen=True)
class EngineStatistics:
    """omissions: bodies left out, by index; idle: relative field error [dB] of the effects left out, by name; counts, bodies,
    costs: of the engine, None before it is set up and for `documented`."""

    culled: dict[int, CulledBody] = field(default_factory=dict)
    idle: dict[str, float] = field(default_factory=dict)
    counts: Counts | None = None
    bodies: PerBody | None = None
    costs: Costs | None = None


def realtime_factor(scene: Scene, costs: Costs) -> float:
    """Simulated seconds per second of one thread."""
    return scene.radar.spoke_period / (costs.total * 1e-6) if costs.total > 0.0 else math.inf
