"""The model of the environment in a scene file, and the checks of effects that need each other."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from radar_service.scene_file.model.moving import SeawayModel
from radar_service.stages.fields import Bearing, Flag, Number, Section
from radar_service.world import sea_state_of


def _form(value: Any) -> str:
    """Which form of `seaway` a value has; the model of that form then says what is wrong with it."""
    return "table" if isinstance(value, Mapping | SeawayModel) else "flag"


SeawayForm = Annotated[Annotated[Flag, Tag("flag")] | Annotated[SeawayModel, Tag("table")], Discriminator(_form)]


class EnvironmentModel(Section):
    """Effects of the environment. All are off by default, except the curvature of the earth."""

    earth: Literal["4/3", "flat"] | Annotated[float, Field(strict=True, gt=0, le=1e6)] = Field(
        "4/3", description="effective earth radius over the earth's radius"
    )
    noise: Flag = False
    multipath: Flag = Field(False, description="the sea reflects, and land where it lies before a target")
    diffraction: Flag = Field(False, description="over the horizon of a smooth sea; needs `multipath`")
    gas_db_per_km: Literal["itu"] | Annotated[float, Field(strict=True, ge=0, le=10)] = Field(0.0, description="one way")
    rain_mm_h: Number = Field(0.0, ge=0, le=300)
    sea_state: Number = Field(0, ge=0, le=9, description="by wave height, 0.04 + 0.1 sea_state^2.1 m; also a fraction")
    wave_height_m: Annotated[float, Field(strict=True, ge=0.05, le=10)] | None = Field(
        None, description="significant wave height, in place of `sea_state`"
    )
    wind_from_deg: Bearing = 0.0
    current_kn: Number = Field(0.0, ge=0, le=20, description="of the tidal stream, everywhere")
    current_to_deg: Bearing | None = Field(None, description="where the stream flows to; needs `current_kn`")
    seaway: SeawayForm = Field(False, description="waves move ships: true, or a table")
    ground_plane: Flag = Field(False, description="a flat reflecting plane at height 0, for the documented fidelity only")

    @property
    def state(self) -> float:
        """The sea state, given or of the wave height; a whole one is an int, which the hashes of scenes have."""
        state = self.sea_state if self.wave_height_m is None else sea_state_of(self.wave_height_m)
        return int(state) if state == int(state) else state

    def problems(self) -> Iterator[str]:
        if self.wave_height_m is not None and "sea_state" in self.model_fields_set:
            yield f"wave_height_m: sea_state is given too; give one, as sea_state = {sea_state_of(self.wave_height_m):.3g}"
        if (self.current_kn > 0.0) != (self.current_to_deg is not None):
            yield "current_to_deg: a stream has current_kn above 0 and current_to_deg; give both or none"
        if self.diffraction and not self.multipath:
            yield "diffraction: true needs the sea's reflection; give multipath = true, or diffraction = false"
        if self.diffraction and self.earth != "4/3" and not (isinstance(self.earth, float) and 0.1 <= self.earth <= 100.0):
            yield f"diffraction: true needs a round earth, not earth = {self.earth}; give 4/3, or 0.1 to 100"
