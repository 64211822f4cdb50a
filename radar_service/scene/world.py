"""The content of a scene in SI units: a world, a radar, and the platform that carries the radar's antenna.

Positions are east, north, up [m] on the map; angles are in radians. `load` builds these records; all are frozen.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import effective_earth_radius
from radar_service.radar.parameters import Radar, horizon
from radar_service.scene.body import Body
from radar_service.scene.commands import Steerable
from radar_service.scene.environment import Environment, Interferer
from radar_service.scene.motion import Motion
from radar_service.scene.platform import Platform
from radar_service.scene.steered_motion import SteeredMotion

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class World:
    """Everything that is independent of a radar.

    name: of the scene.
    origin: latitude, longitude [degrees, WGS 84] of east = north = 0, or None; only input and output use it.
    environment: the earth, the atmosphere and the sea.
    bodies: the objects that a radar can detect.
    """

    name: str
    origin: tuple[float, float] | None
    environment: Environment
    bodies: tuple[Body, ...]


@dataclass(frozen=True)
class Scene:
    """The content of a scene file: a world, a radar and its platform. The other properties are shortcuts to their parts.

    world: the bodies and their environment.
    radar: the parameters of the set.
    platform: the carrier of the antenna, today own ship.
    warnings: sentences about unusual but usable content, in order.
    interference: other radars whose pulses this radar receives.
    notes: sentences about its files that need no action.
    """

    world: World
    radar: Radar
    platform: Platform
    warnings: tuple[str, ...] = ()
    interference: tuple[Interferer, ...] = ()
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        radar, triangles = self.radar, sum(len(body.mesh.faces) for body in self.bodies if body.mesh is not None)
        more = f" and {len(self.bodies) - 6} more" if len(self.bodies) > 6 else ""
        return (
            f"<Scene {self.name!r}: {len(self.bodies)} bodies, {triangles} triangles, {len(self.warnings)} warnings,\n"
            f"  radar of {radar.azimuths} azimuths and {radar.bins} cells to {radar.range_max:g} m, "
            f"{60.0 / radar.rotation_period:g} rpm,\n  bodies {', '.join(body.name for body in self.bodies[:6])}{more}>"
        )

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self.world.name

    @property
    def origin(self) -> tuple[float, float] | None:
        """Latitude, longitude [degrees, WGS 84] of east = north = 0, or None."""
        return self.world.origin

    @property
    def environment(self) -> Environment:
        """The earth, the atmosphere and the sea."""
        return self.world.environment

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The objects that the radar can detect."""
        return self.world.bodies

    @property
    def body_count(self) -> int:
        """Number of bodies."""
        return len(self.world.bodies)

    @property
    def steered(self) -> dict[str | None, SteeredMotion]:
        """The motions that commands may change, by the names of the bodies; None is own ship."""
        motions = {None: self.own_ship} | {body.name: body.motion for body in self.bodies}
        return {name: motion for name, motion in motions.items() if isinstance(motion, SteeredMotion)}

    @property
    def steerable(self) -> Steerable:
        """What commands may steer."""
        limits = {name: motion.limits for name, motion in self.steered.items()}
        return Steerable(limits, frozenset(body.name for body in self.bodies), self.radar.spoke_period)

    @property
    def own_ship(self) -> Motion:
        """Motion of the platform."""
        return self.platform.motion

    def with_world(self, **changes: Any) -> "Scene":
        """Returns the scene with changes to fields of its world."""
        return replace(self, world=replace(self.world, **changes))

    def antenna(self, time: Floats | float) -> Floats:
        """Returns antenna positions (K, 3) east, north, height above the sea [m] at each time (K,) [s]."""
        return self.platform.antenna(time, self.radar.height)

    def upright_from_map(self, time: Floats) -> Floats | None:
        """Returns what Platform.upright_from_map returns."""
        return self.platform.upright_from_map(time)

    def horizon(self, height: float = 0.0) -> float:
        """Returns the ground distance [m] of the horizon for a target `height` [m] above the sea; inf on a flat earth.

        The antenna is as high as its heave lifts it.
        """
        antenna = self.radar.height + (0.0 if self.own_ship.sway is None else self.own_ship.sway.max_heave)
        return float(horizon(height, antenna, effective_earth_radius(self.environment.earth_factor)))

    def blind(self, time: Floats, boresight: Floats) -> NDArray[np.bool_]:
        """Returns whether boresights (K,) [rad from north] are in a blind sector at each time (K,) [s]."""
        return self.radar.is_blind(boresight - self.platform.heading(time))
