"""Noise jammers: the scene key [[jammer]], a strobe in the direction of each."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from pydantic import Field

from radar_service.effects import Bearing, Effect, Number, Section, Source


class JammerModel(Section):
    """A transmitter of noise over the whole band."""

    bearing_deg: Bearing
    level_db: Number = Field(40.0, ge=0, le=120, description="over the receiver's noise when the beam points at it")


class Jammer(NamedTuple):
    """Bearing [rad] and power over that of the receiver's noise."""

    bearing: float
    level: float


class JammerEffect(Effect):
    """Noise jammers."""

    name = "jammer"
    stage_at = "radar_hazards.jammer_stage:JammerStage"
    scene_keys = {"jammer": (tuple[JammerModel, ...], Field((), max_length=20))}
    sources = (Source("jammer"),)

    def scene_record(self, given: Mapping[str, Any]) -> tuple[Jammer, ...] | None:
        jammers = (Jammer(math.radians(model.bearing_deg), 10 ** (model.level_db / 10)) for model in given["jammer"])
        return tuple(jammers) or None
