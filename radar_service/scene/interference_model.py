"""What a scene file may say about other radars whose pulses are heard."""

from typing import Self

from pydantic import Field, model_validator

from radar_service.scene.fields import Bearing, EastNorth, Number, Section

MAX_INTERFERERS = 100


class InterferenceModel(Section):
    """Another radar of about the same frequency, without modulation, that turns and transmits on its own."""

    bearing_deg: Bearing | None = Field(None, description="where it stands as own ship sees it, for ever")
    position_m: EastNorth | None = Field(None, description="or its place: east, north")
    level_db: Number = Field(
        110.0,  # 25 kW and 30 dBi at either end of 6 km, a receiver of 5 MHz
        ge=0,
        le=150,
        description="its pulse over the receiver's noise while both beams look at each other",
    )
    frequency_offset_hz: Number = Field(0.0, ge=-1e9, le=1e9, description="of its carrier from own; the filter decides")
    pulse_s: Number = Field(0.25e-6, ge=1e-8, le=1e-4)
    prf_hz: Number = Field(1000.0, ge=10, le=50e3, description="pulses per second")
    rpm: Number = Field(24.0, ge=0.01, le=600)
    beamwidth_deg: Number = Field(1.9, ge=0.05, le=90, description="horizontal, half power; Taylor sidelobes of 30 dB")

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.bearing_deg is None) == (self.position_m is None):
            raise ValueError(
                "bearing_deg: exactly one of bearing_deg and position_m says where it stands; add or remove one"
            )
        if self.pulse_s * self.prf_hz >= 0.5:
            raise ValueError(
                f"pulse_s: {self.pulse_s:g} s, {self.prf_hz:g} times a second, is on for half the time or more; "
                "shorten it or lower prf_hz"
            )
        return self
