"""The strobe of a jammer: noise in all cells while the beam, or a sidelobe, points at it."""

from typing import Any

import numpy as np

from radar_hazards.jammer import JammerEffect
from radar_service.effects import Context, PlanItem, Stage, Tile, wrap_angle

MIN_TO_NOISE = 1e-2


class JammerStage(Stage):
    """All jammers of a scene."""

    def __init__(self, context: Context) -> None:
        self._context, self._jammers = context, JammerEffect().of_scene(context.scene)

    @classmethod
    def of(cls, context: Context) -> "JammerStage":
        return cls(context)

    @classmethod
    def plan(cls, scene: Any, fidelity: Any, microseconds: float | None) -> list[PlanItem]:
        how = f"{len(JammerEffect().of_scene(scene))}, white over the band, by the one-way pattern"
        return [PlanItem("jammers", True, how, microseconds=microseconds)]

    def add(self, tile: Tile) -> None:
        radar = self._context.scene.radar
        for k, jammer in enumerate(self._jammers):
            level = jammer.level * radar.azimuth_gain(wrap_angle(tile.azimuths.boresight - jammer.bearing))
            for row in np.flatnonzero(level > MIN_TO_NOISE).tolist():
                noise = self._context.random(k, int(tile.azimuths.number[row])).normal(size=(2, radar.bins))
                scale = np.sqrt(0.5 * self._context.noise_power * level[row])
                tile.add(self._context.numbers["jammer"], row, scale * (noise[0] + 1j * noise[1]))
