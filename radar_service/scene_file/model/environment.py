"""The model of the environment in a scene file, and the checks of effects that need each other."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from radar_service.scene_file.model.fields import Bearing, Flag, Number, Section, Whole


class EnvironmentModel(Section):
    """Effects of the environment. All are off by default, except the curvature of the earth."""

    earth: Literal["4/3", "flat"] | Annotated[float, Field(strict=True, gt=0, le=1e6)] = Field(
        "4/3", description="effective earth radius over the earth's radius"
    )
    noise: Flag = False
    multipath: Flag = False
    diffraction: Flag = Field(False, description="over the horizon of a smooth sea; needs `multipath`")
    gas_db_per_km: Literal["itu"] | Annotated[float, Field(strict=True, ge=0, le=10)] = Field(0.0, description="one way")
    rain_mm_h: Number = Field(0.0, ge=0, le=300)
    sea_state: Whole = Field(0, ge=0, le=9, description="Douglas scale")
    sea_texture_shape: Number | None = Field(
        None, ge=0.05, le=1000, description="K distribution: small is spiky; default by grazing angle and cell"
    )
    wind_from_deg: Bearing = 0.0
    ground_plane: Flag = Field(False, description="a flat reflecting plane at height 0, for the documented fidelity only")

    @model_validator(mode="after")
    def _check_diffraction(self) -> Self:
        if self.diffraction and not self.multipath:
            raise ValueError("diffraction: true needs the sea's reflection; give multipath = true, or diffraction = false")
        if self.diffraction and self.earth != "4/3" and not (isinstance(self.earth, float) and 0.1 <= self.earth <= 100.0):
            raise ValueError(f"diffraction: true needs a round earth, not earth = {self.earth}; give 4/3, or 0.1 to 100")
        return self
