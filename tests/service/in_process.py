"""A simulator that a station of the test's own process runs."""

from dataclasses import replace
from typing import Any

from radar_service.radar.parameters import Origin
from radar_service.service.radio.world_process import scene_of
from radar_service.service.source import SceneOrder
from radar_service.simulator import Simulator


class InProcess(Simulator):
    """The simulator of the scene of an order; further arguments are those of a Simulator."""

    def __init__(self, order: SceneOrder, *arguments: Any, **options: Any) -> None:
        super().__init__(scene_of(order), *arguments, **options)
        self.order = order

    def begin_at(self, origin: Origin) -> None:
        super().begin_at(origin)
        self.order = replace(self.order, origin=origin)
