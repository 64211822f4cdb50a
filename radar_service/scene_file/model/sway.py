"""Scene file model of how ships roll, pitch, yaw and heave in a seaway."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from radar_service.scene_file.model.fields import Bearing, Section

SwayAngle = Annotated[float, Field(strict=True, ge=0, le=45)]  # degrees
Period = Annotated[float, Field(strict=True, ge=1, le=3600)]  # s; ships roll in 4 to 30
AMPLITUDES = {"roll": "roll_deg", "pitch": "pitch_deg", "yaw": "yaw_deg", "heave": "heave_m"}  # key of each amplitude


class SwaySection(Section):
    """Each angle, and the heave, is amplitude x sin(2 pi t / period + phase)."""

    roll_deg: SwayAngle = Field(0.0, description="amplitude; first with the starboard side down")
    roll_period_s: Period = 10.0
    roll_phase_deg: Bearing = 0.0
    pitch_deg: SwayAngle = Field(0.0, description="amplitude; first with the bow up")
    pitch_period_s: Period = 7.0
    pitch_phase_deg: Bearing = 0.0
    yaw_deg: SwayAngle = Field(0.0, description="amplitude about the heading; first to starboard")
    yaw_period_s: Period = 20.0
    yaw_phase_deg: Bearing = 0.0
    heave_m: Annotated[float, Field(strict=True, ge=0, le=20)] = Field(0.0, description="amplitude; first up")
    heave_period_s: Period = 8.0
    heave_phase_deg: Bearing = 0.0

    @model_validator(mode="after")
    def _check_periods(self) -> Self:
        for name, amplitude in AMPLITUDES.items():
            for key in (f"{name}_period_s", f"{name}_phase_deg"):
                if key in self.model_fields_set and not getattr(self, amplitude):
                    raise ValueError(f"{key}: it needs an amplitude; add {amplitude} or remove {key}")
        return self
