"""The scene as its radar has it at another rate of rotation, or from another origin on."""

from dataclasses import replace

from radar_service.radar.parameters import START, Origin, max_rpm
from radar_service.world.error import SceneError
from radar_service.world.scene import Scene


def scene_at_rpm(scene: Scene, rpm: float, origin: Origin = START) -> Scene:
    """Returns the scene with another rotation rate of its radar, from an origin on.

    Raises SceneError if a spoke then has no pulse of its own, the only rule of the loader that depends on the rate.
    """
    radar = scene.radar
    if radar.prf is not None and rpm > max_rpm(radar.prf, radar.azimuths):
        raise SceneError(
            f"rpm: {rpm:g} gives {radar.azimuths * rpm / 60.0:g} spokes a second, more than the {radar.prf:g} pulses of the "
            f"scene's prf_hz; give at most {60.0 * radar.prf / radar.azimuths:g}, or use a scene with a higher prf_hz"
        )
    return replace(scene, radar=replace(radar, rotation_period=60.0 / rpm, origin=origin))


def scene_at_origin(scene: Scene, origin: Origin) -> Scene:
    """Returns the scene with another origin of the rotation of its radar."""
    return replace(scene, radar=replace(scene.radar, origin=origin))
