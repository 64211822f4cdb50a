"""Echoes of flocks: each bird with its own range and phase."""

from typing import Any

import numpy as np

from radar_hazards.flock import FlockEffect
from radar_service.effects import Context, EffectTruth, PlanItem, Stage, crossing_search, in_sight, point_echoes


class FlockTruth(EffectTruth):
    """Where flocks are at the end of a scan, and when the beam crossed them in it."""

    def __init__(self, scene: Any, line_of_sight: Any) -> None:
        self._scene, self._line_of_sight, self._flocks = scene, line_of_sight, FlockEffect().of_scene(scene)
        self._search = crossing_search(scene, self._middles, len(self._flocks))

    def _middles(self, flocks: Any, time: Any) -> Any:
        """The middles (E, 3) [m] of flocks (E,) at times (E,) [s]."""
        return np.array([flock.middle(time) for flock in self._flocks])[flocks, np.arange(len(time))]

    def at_end(self, time: float) -> dict[str, Any]:
        found = self._search.within(round(self._scene.radar.turns_at(time)) - 1)
        crossings: list[list[Any]] = [[] for _ in self._flocks]
        for flock, when in zip(found.point.tolist(), found.time.tolist(), strict=True):
            visible = in_sight(self._scene, self._line_of_sight, self._middles([flock], [when]), when)
            crossings[flock].append({"time": when, "visible": bool(visible[0])})
        middles = [flock.middle([time])[0].tolist() for flock in self._flocks]
        rows = zip(self._flocks, middles, crossings, strict=True)
        return {"flocks": [{"birds": f.birds, "position": at, "crossings": crossed} for f, at, crossed in rows]}


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
        return FlockTruth(scene, line_of_sight)

    def echoes(self, azimuths: Any) -> Any:
        pairs = list(zip(self._flocks, self._places, strict=True))
        position = np.concatenate([flock.middle(azimuths.time) + places[:, None] for flock, places in pairs])
        rcs = np.concatenate([np.full(len(places), flock.rcs) for flock, places in pairs])
        return point_echoes(self._context, "birds", azimuths, position, rcs)
