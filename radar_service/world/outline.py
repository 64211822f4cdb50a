"""A scene as a service knows it: the bodies and their meshes stay with what computes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from radar_service.radar import FIRST_ID, Radar
from radar_service.world.ais import Ais
from radar_service.world.commands import Steerable
from radar_service.world.error_settings import ErrorSettings
from radar_service.world.stream import NO_STREAM, Stream

if TYPE_CHECKING:
    from radar_service.world.scene import Scene

NOT_STEERABLE = Steerable({}, frozenset(), None)


@dataclass(frozen=True)
class SceneOutline:
    """What is known of a scene besides its bodies.

    notes: sentences about its files that need no action; whoever uploads the scene gets them.
    steerable: what commands may steer.
    errors: on purpose, which the serving process adds; None without any.
    radar_id: of the radar; radar_ids: of all radars of its file.
    has_sensors: whether the platform has gyro, log and position sensor.
    stream: of the water over ground, east and north [m/s].
    ais: the transponders of the scene; gnss_offset: as of Scene.
    """

    name: str
    origin: tuple[float, float] | None
    body_count: int
    warnings: tuple[str, ...]
    radar: Radar
    notes: tuple[str, ...] = ()
    steerable: Steerable = NOT_STEERABLE
    errors: ErrorSettings | None = None
    radar_id: str = FIRST_ID
    radar_ids: tuple[str, ...] = (FIRST_ID,)
    has_sensors: bool = True
    stream: Stream = NO_STREAM
    ais: Ais = Ais()
    gnss_offset: tuple[float, float] = (0.0, 0.0)


def outline_of(scene: "Scene") -> SceneOutline:
    """Returns what is known of a scene besides its bodies."""
    return SceneOutline(
        scene.name, scene.origin, scene.body_count, scene.warnings, scene.radar, scene.notes, scene.steerable, scene.errors,
        scene.radar_id, scene.radar_ids, scene.has_sensors, scene.environment.stream,
        scene.ais,
        scene.gnss_offset,
    )  # fmt: skip
