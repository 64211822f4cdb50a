"""What the author of an effect needs (docs/effects.md). Each name is imported when it is first used: declarations stay light.

>>> from radar_service.effects import Effect, Section, Source
"""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes
    from radar_service.numerics.frames import effective_earth_radius, polar_from_map, wrap_angle
    from radar_service.records.plan_item import PlanItem
    from radar_service.stages.effect import Effect, EffectTruth, Source
    from radar_service.stages.fields import (
        Bearing,
        EastNorth,
        EastNorthUp,
        Flag,
        Height,
        Number,
        Section,
        Size,
        Speed,
        Whole,
        record_of,
    )
    from radar_service.stages.points import crossing_search, in_sight, point_echoes
    from radar_service.stages.stage import Context, RandomField, Stage, Tile
    from radar_service.world.environment import Attenuator, SightLines
    from radar_service.world.error import SceneError

__all__ = [
    "Attenuator", "AzimuthTimes", "BeamWeightedEchoes", "Bearing", "Context", "EastNorth", "EastNorthUp", "Effect",
    "EffectTruth", "Flag", "Height", "Number", "PlanItem", "RandomField", "SceneError", "Section", "SightLines", "Size",
    "Source", "Speed", "Stage", "Tile", "Whole", "crossing_search", "effective_earth_radius", "in_sight", "point_echoes",
    "polar_from_map", "record_of", "wrap_angle",
]  # fmt: skip

__getattr__, __dir__ = lazily(__name__)
