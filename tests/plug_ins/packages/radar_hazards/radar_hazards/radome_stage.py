"""What a damaged radome takes from the beam."""

from typing import Any

import numpy as np

from radar_hazards.radome import Radome
from radar_service.effects import PlanItem, Stage, wrap_angle


class Sector:
    """Takes a share of the field in a sector."""

    def __init__(self, radome: Radome, extent: float) -> None:
        self.radome, self.extent = radome, extent

    def reaches(self, from_bow: Any) -> Any:
        return np.abs(wrap_angle(from_bow - self.radome.bearing)) < self.radome.half

    def subtract(self, field: Any, from_bow: Any, offset: Any) -> None:
        field[self.reaches(from_bow) & (np.abs(offset) < self.extent)] *= 1.0 - self.radome.share


class RadomeStage(Stage):
    """The radome of a radar, which adds nothing of its own."""

    @classmethod
    def field_changes(cls, record: Radome, aperture: Any, wavelength: float, extent: float) -> list[Sector]:
        return [Sector(record, extent)]

    @classmethod
    def plan(cls, scene: Any, fidelity: Any, microseconds: float | None) -> list[PlanItem]:
        return [PlanItem("radome", True, f"{scene.radar.effects['radome'].share:.0%} of the field one way, in its sector")]
