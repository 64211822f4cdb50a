"""The platform that carries an antenna: its motion and its sway, and the radar on it."""

from dataclasses import dataclass, field

import numpy as np

from radar_service.numerics import Floats, map_from_deck
from radar_service.radar import Radar
from radar_service.world.ais import Ais
from radar_service.world.environment import Environment
from radar_service.world.error_settings import ErrorSettings
from radar_service.world.motion import Motion


@dataclass(frozen=True)
class Platform:
    """The carrier of an antenna: own ship, a body of the scene or a fixed site.

    motion: of the point on the sea surface below the antenna, with sway.
    body: name of the body that it is, which its own radar does not see; None where it is no body of the scene.
    """

    motion: Motion
    body: str | None = field(default=None, metadata={"added": 1})  # see truth.truth_file.scene_hash

    @property
    def text(self) -> str:
        """What `check` says of it."""
        east, north, _ = self.motion.pose(0.0).position[0]
        return f"at east {east:.1f}, north {north:.1f} m" if self.body is None else f"on {self.body}"

    def heading(self, time: Floats) -> Floats:
        """Returns the heading (K,) [rad] at each time (K,) [s]."""
        return self.motion.pose(time).heading

    def antenna(self, time: Floats | float, height: float) -> Floats:
        """Returns positions (K, 3) east, north, height above the sea [m] at each time (K,) [s] of an antenna at the top of
        an upright mast of `height` [m]; sway tilts and heaves the mast."""
        pose = self.motion.pose(time)
        position = pose.position.copy()
        position[:, 2] = 0.0 if pose.heave is None else pose.heave
        if pose.rotation is None:
            position[:, 2] += height
            return position
        return position + height * pose.rotation[:, :, 2]

    def upright_from_map(self, time: Floats) -> Floats | None:
        """Returns matrices (K, 3, 3) from map directions to directions relative to the swaying mast, at each time (K,) [s].

        The result is the direction in which an upright mast on the same heading has the target. None without sway.
        """
        if self.motion.sway is None:
            return None
        pose = self.motion.pose(time)
        level = map_from_deck(pose.heading, np.zeros(len(time)), np.zeros(len(time)))
        return np.asarray(level @ (level if pose.rotation is None else pose.rotation).transpose(0, 2, 1))


@dataclass(frozen=True)
class Installation:
    """A radar of a scene file, and where it stands.

    id: unique in the scene.
    radar: the parameters of the set.
    platform: the carrier of its antenna.
    environment: of the scene, with the attenuation at the radar's frequency.
    errors: on purpose, of the radar and of its platform; None without any.
    has_sensors: whether the platform has gyro, log and position sensor: a fixed site has none.
    ais: the transponders around it, and that of its platform: own ship that is no body is in the world of its own radars alone.
    gnss_offset: of the platform's antenna of satellite navigation, starboard and forward of its position [m].
    """

    id: str
    radar: Radar
    platform: Platform
    environment: Environment
    errors: ErrorSettings | None
    has_sensors: bool
    ais: Ais = Ais()
    gnss_offset: tuple[float, float] = (0.0, 0.0)
