"""Sea and rain clutter in a scene."""

from typing import TYPE_CHECKING, Any

from pydantic import Field

from radar_service.stages.clutter.rain_cell import MAX_CELLS, RainCell, RainCellModel, RainCells
from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import Number

if TYPE_CHECKING:
    from radar_service.world import Scene

SEA, RAIN = 1, 2  # numbers of its sources
TEXTURE_SHAPE = "sea_texture_shape"  # nu of the gamma texture
RAIN_CELL = "rain_cell"


class ClutterEffect(Effect):
    """Echoes of the sea and of rain. Sea state, wind and rain are of the environment, as they act on other echoes too."""

    name = "clutter"
    stage_at = "radar_service.stages.clutter.stage:ClutterStage"
    environment_keys = {
        TEXTURE_SHAPE: (
            Number | None,
            Field(None, ge=0.05, le=1000, description="K distribution: small is spiky; default by grazing angle and cell"),
        ),
        RAIN_CELL: (tuple[RainCellModel, ...], Field((), max_length=MAX_CELLS, description="rain with edges that move")),
    }
    sources = (Source("sea", "clutter", SEA), Source("rain", "clutter", RAIN))

    def environment_value(self, key: str, value: Any) -> Any:
        if key != RAIN_CELL:
            return value
        return RainCells(tuple(map(RainCell.of, value))) if value else ()

    def scene_text(self, scene: "Scene") -> str:
        cells = scene.environment.effect_keys.get(RAIN_CELL)
        return "" if cells is None else cells.text

    def is_in(self, scene: "Scene") -> bool:
        return True  # the plan of every scene says whether it has any
