"""A damaged radome: the key of the radar [radar.radome], a sector in which it takes from the field."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from pydantic import Field

from radar_service.effects import Bearing, Effect, Number, Section


class RadomeModel(Section):
    """A sector of a radome."""

    bearing_deg: Bearing = Field(description="of its middle, clockwise from the bow")
    width_deg: Number = Field(ge=1, le=180)
    loss_db: Number = Field(ge=0, le=40, description="one way")


class Radome(NamedTuple):
    """A sector [rad], and the share of the field that it takes."""

    bearing: float
    half: float
    share: float


class RadomeEffect(Effect):
    """A damaged radome."""

    name = "radome"
    stage_at = "radar_hazards.radome_stage:RadomeStage"
    radar_keys = {"radome": (RadomeModel | None, Field(None, description="where it is damaged; default: nowhere"))}

    def check_radar(self, given: Mapping[str, Any], pattern: Any, beamwidth: float, wavelength: float) -> None:
        model = given["radome"]
        if model is not None and math.radians(model.width_deg) < beamwidth:
            raise ValueError(f"radome.width_deg: {model.width_deg:g} is less than a beamwidth; widen it")

    def radar_record(self, given: Mapping[str, Any]) -> Radome | None:
        model = given["radome"]
        if model is None:
            return None
        return Radome(math.radians(model.bearing_deg), math.radians(model.width_deg) / 2, 1 - 10 ** (-model.loss_db / 20))
