"""Scene file model of when a body is there: start, end, and fading on a schedule."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from radar_service.scene_file.model.fields import Flag, Section, Whole

MAX_UNITS = 1000  # of a schedule
Instant = Annotated[float, Field(strict=True, ge=0, le=1e9)]  # s of simulated time


class FadingModel(Section):
    """A schedule that repeats: the body is there in `present` of `of` units, at first."""

    present: Whole = Field(ge=1, le=MAX_UNITS, description="units with the body")
    of: Whole = Field(ge=1, le=MAX_UNITS, description="units after which the schedule repeats")
    unit_s: Annotated[float, Field(strict=True, ge=1e-3, le=1e6)] | None = Field(
        None, description="length of a unit; default: one scan of the radar"
    )
    offset_s: Instant = Field(0.0, description="start of a unit; 0 is the beam at north")
    spread: Flag = Field(False, description="spreads the units with the body evenly, instead of all together")

    @model_validator(mode="after")
    def _check_units(self) -> Self:
        if self.present > self.of:
            raise ValueError(f"present: {self.present} units are more than of = {self.of}; lower present or raise of")
        return self

    def pattern(self) -> list[bool]:
        """Returns whether the body is there in each unit of the schedule."""
        if not self.spread:
            return [unit < self.present for unit in range(self.of)]
        return [unit * self.present % self.of < self.present for unit in range(self.of)]
