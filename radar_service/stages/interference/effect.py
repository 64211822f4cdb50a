"""The scene key of other radars that transmit, and what a scene keeps of it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic import Field

from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import Bearing, EastNorth, Number, Section, record_of

if TYPE_CHECKING:
    from radar_service.world import Scene

MAX_INTERFERERS = 100


class InterferenceModel(Section):
    """Another radar at nearly the same frequency, without modulation, that rotates and transmits independently."""

    bearing_deg: Bearing | None = Field(None, description="constant bearing from own ship")
    position_m: EastNorth | None = Field(None, description="or its position: east, north")
    level_db: Number = Field(
        110.0,  # 25 kW and 30 dBi at both ends of 6 km, receiver bandwidth 5 MHz
        ge=0,
        le=150,
        description="its pulse over the receiver's noise when both beams point at each other",
    )
    frequency_offset_hz: Number = Field(0.0, ge=-1e9, le=1e9, description="of its carrier from own frequency")
    pulse_s: Number = Field(0.25e-6, ge=1e-8, le=1e-4)
    prf_hz: Number = Field(1000.0, ge=10, le=50e3, description="pulses per second")
    rpm: Number = Field(24.0, ge=0.01, le=600)
    beamwidth_deg: Number = Field(1.9, ge=0.05, le=90, description="horizontal, half power; Taylor sidelobes of 30 dB")

    def problems(self) -> Iterator[str]:
        if (self.bearing_deg is None) == (self.position_m is None):
            yield "bearing_deg: an interfering radar needs exactly one of bearing_deg and position_m; add or remove one"
        if self.pulse_s * self.prf_hz >= 0.5:
            yield (
                f"pulse_s: {self.pulse_s:g} s at {self.prf_hz:g} pulses a second transmits half the time or more; "
                "shorten it or lower prf_hz"
            )


@dataclass(frozen=True)
class Interferer:
    """Another radar whose pulses the receiver picks up; see InterferenceModel."""

    bearing: float  # rad from own ship, used if position is None
    position: tuple[float, float] | None  # east, north [m]
    level: float  # power ratio to the receiver's noise when both beams point at each other
    frequency_offset: float
    pulse: float
    prf: float
    rotation_period: float
    beamwidth: float


def _interferer(model: InterferenceModel) -> Interferer:
    bearing = math.radians(model.bearing_deg or 0.0)
    return record_of(Interferer, model, bearing=bearing, rotation_period=60.0 / model.rpm)


class InterferenceEffect(Effect):
    """Other radars."""

    name = "interference"
    stage_at = "radar_service.stages.interference.stage:InterferenceStage"
    scene_keys = {"interference": (tuple[InterferenceModel, ...], Field((), max_length=MAX_INTERFERERS))}
    sources = (Source("interference", number=3),)

    def scene_record(self, given: Mapping[str, Any]) -> tuple[Interferer, ...] | None:
        return tuple(map(_interferer, given["interference"])) or None

    def scene_text(self, scene: "Scene") -> str:
        return f"{len(self.of_scene(scene))} interfering radars"

    def sources_of(self, scene: "Scene") -> Sequence[Source]:
        return self.sources  # the table of every scene has it, as from the first
