"""The models of a seaway and of the hulls that it moves."""

from typing import Annotated

from pydantic import Field

from radar_service.stages.fields import Bearing, Flag, Number, Section, Size, Whole

Coefficient = Annotated[float, Field(strict=True, ge=0.2, le=1.0)]


class SeawayModel(Section):
    """Waves that move ships."""

    height_m: Annotated[float, Field(strict=True, gt=0, le=20)] | None = Field(
        None, description="significant wave height; default: that of the sea, which then has one"
    )
    period_s: Annotated[float, Field(strict=True, ge=1.5, le=30)] | None = Field(
        None, description="of the spectrum's peak; default: most probable at this height on the open North Atlantic"
    )
    from_deg: Bearing | None = Field(None, description="where waves come from; default: `wind_from_deg`")
    spread: Annotated[float, Field(strict=True, ge=0.5, le=1000)] = Field(
        1.0, description="s of their directions, cos^(2 s): a large one makes all crests parallel"
    )
    seed: Whole = Field(0, ge=0, le=2**32 - 1, description="of the waves, lists and trims")
    list_deg: Number = Field(0.5, ge=0, le=10, description="standard deviation of the lists that are drawn for ships")
    trim_deg: Number = Field(0.2, ge=0, le=5, description="standard deviation of the trims that are drawn for ships")


class HullModel(Section):
    """What a seaway needs to know of a hull."""

    floats: Flag | None = Field(None, description="whether a seaway moves it; default: vessels, and bodies with this table")
    length_m: Size | None = Field(None, description="in the water; default: of its mesh")
    beam_m: Size | None = Field(None, description="default: of its mesh")
    draught_m: Annotated[float, Field(strict=True, gt=0, le=100)] | None = Field(
        None, description="default: `draught_m` of the body, how deep its mesh reaches, or 0.4 of its beam"
    )
    block: Coefficient = Field(0.7, description="displaced volume over length x beam x draught")
    waterplane: Coefficient | None = Field(None, description="its area over length x beam; default: a third of 1 + 2 block")
    roll_period_s: Annotated[float, Field(strict=True, ge=1, le=60)] | None = Field(
        None, description="default: of a metacentric height of a tenth of the beam, by the IMO's weather criterion"
    )
    roll_damping: Annotated[float, Field(strict=True, ge=0.02, le=1)] = Field(0.1, description="over critical damping")
