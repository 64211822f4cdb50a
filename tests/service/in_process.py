"""A simulator that a station of the test's own process runs."""

from typing import Any

from radar_service.service.radio.scene_process_main import scene_of
from radar_service.service.scene_request import SceneRequest
from radar_service.simulator import Simulator


class InProcess(Simulator):
    """The simulator of the scene of an order; further arguments are those of a Simulator."""

    def __init__(self, order: SceneRequest, *arguments: Any, **options: Any) -> None:
        super().__init__(scene_of(order), *arguments, **options)
        self.scene_request = order
