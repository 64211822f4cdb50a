"""The radar key of multiple echoes, and what a radar keeps of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import Number, Section, record_of


class MultipleEchoesModel(Section):
    """Echoes between own ship and ships near by, at two and more times their range."""

    own_rcs_dbsm: Number = Field(ge=-20, le=80, description="of own ship, towards the other one")
    range_m: Annotated[float, Field(strict=True, gt=0, le=20_000)] = Field(
        2000.0, description="ships within it have such echoes"
    )
    orders: Annotated[int, Field(strict=True, ge=1, le=4)] = Field(
        2, description="how many: 1 is a second trace at twice the range, 2 a third one too"
    )


@dataclass(frozen=True)
class MultipleEchoes:
    """Echoes that own ship throws back to a ship near by.

    own_rcs: of own ship towards the other one [m^2].
    max_range: of the ships that have them [m].
    orders: how many such echoes each has.
    """

    own_rcs: float
    max_range: float
    orders: int


class MultipleEffect(Effect):
    """Multiple echoes, between own ship and ships near by."""

    name = "multiple"
    stage_at = "radar_service.stages.multiple_echoes.stage:MultipleStage"
    radar_keys = {
        "multiple_echoes": (
            MultipleEchoesModel | None,
            Field(None, description="between own ship and ships near by; default: none"),
        )
    }
    sources = (Source("multiple", "clutter", number=8, has_echoes=True),)
    has_paths = True

    def radar_record(self, given: Mapping[str, Any]) -> MultipleEchoes | None:
        model = given["multiple_echoes"]
        return None if model is None else record_of(MultipleEchoes, model, max_range=model.range_m)
