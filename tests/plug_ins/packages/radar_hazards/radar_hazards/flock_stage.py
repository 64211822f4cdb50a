"""Echoes of flocks: each bird with its own range and phase."""

from typing import Any

import numpy as np

from radar_hazards.flock import FlockEffect
from radar_service.effects import Context, EffectTruth, PlanItem, Stage, point_echoes


class FlockTruth(EffectTruth):
    """Where flocks are at the end of a scan."""

    def __init__(self, scene: Any) -> None:
        self._flocks = FlockEffect().of_scene(scene)

    def at_end(self, time: float) -> dict[str, Any]:
        middles = [flock.middle([time])[0].tolist() for flock in self._flocks]
        return {"flocks": [{"birds": f.birds, "position": at} for f, at in zip(self._flocks, middles, strict=True)]}


class FlockStage(Stage):
    """All flocks of a scene."""

    has_echoes = True

    def __init__(self, context: Context) -> None:
        self._context, self._flocks = context, FlockEffect().of_scene(context.scene)
        self._places = [
            flock.radius * np.clip(context.random(k).normal(size=(flock.birds, 3)) * [1.0, 1.0, 0.3], -2.0, 2.0)
            if flock.birds > 1
            else np.zeros((1, 3))
            for k, flock in enumerate(self._flocks)
        ]

    @classmethod
    def of(cls, context: Context) -> "FlockStage":
        return cls(context)

    @classmethod
    def plan(cls, scene: Any, fidelity: Any, microseconds: float | None) -> list[PlanItem]:
        flocks = FlockEffect().of_scene(scene)
        how = f"{sum(flock.birds for flock in flocks)} birds in {len(flocks)} flocks, each with its own range and phase"
        return [PlanItem("flocks", True, how, microseconds=microseconds)]

    @classmethod
    def truth(cls, scene: Any, line_of_sight: Any) -> FlockTruth:
        return FlockTruth(scene)

    def echoes(self, azimuths: Any) -> Any:
        pairs = list(zip(self._flocks, self._places, strict=True))
        position = np.concatenate([flock.middle(azimuths.time) + places[:, None] for flock, places in pairs])
        rcs = np.concatenate([np.full(len(places), flock.rcs) for flock, places in pairs])
        return point_echoes(self._context, "birds", azimuths, position, rcs)
