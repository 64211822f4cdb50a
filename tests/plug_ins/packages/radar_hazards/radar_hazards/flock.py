"""Flocks of birds: the scene key [[flock]]."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import Field

from radar_service.effects import Bearing, EastNorthUp, Effect, Number, Section, Size, Source, Speed, Whole, record_of


class FlockModel(Section):
    """Birds that fly together."""

    position_m: EastNorthUp = Field(description="east, north, height of their middle at time 0")
    birds: Whole = Field(40, ge=1, le=2000)
    radius_m: Size = 30.0
    rcs_dbsm: Number = Field(-20.0, ge=-60, le=40, description="of one bird")
    speed_kn: Speed = 25.0
    course_deg: Bearing = 0.0


@dataclass(frozen=True)
class Flock:
    """A flock in SI units."""

    position: tuple[float, float, float]
    birds: int
    radius: float
    rcs: float
    speed: float
    course: float

    def middle(self, time: Any) -> Any:
        """The middle (K, 3) [m] at times (K,) [s]."""
        direction = np.array([math.sin(self.course), math.cos(self.course), 0.0])
        return self.position + self.speed * np.asarray(time)[:, None] * direction


class FlockEffect(Effect):
    """Flocks of birds."""

    name = "flock"
    stage_at = "radar_hazards.flock_stage:FlockStage"
    scene_keys = {"flock": (tuple[FlockModel, ...], Field((), max_length=100, description="birds that fly together"))}
    sources = (Source("birds", "clutter"),)

    def scene_record(self, given: Mapping[str, Any]) -> tuple[Flock, ...] | None:
        return tuple(record_of(Flock, model) for model in given["flock"]) or None

    def scene_text(self, scene: Any) -> str:
        return f"{len(self.of_scene(scene))} flocks of birds"
