"""The content of a scene in SI units: a world, one of its radars, and the platform that carries the radar's antenna.

Positions are east, north, up [m] on the map; angles are in radians. `load` builds these records; all are frozen. A service knows
the outline of a scene: the bodies and their meshes stay with what computes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from radar_service.numerics import STEADY, Flags, Floats, Revision, effective_earth_radius, map_from_deck, name_key
from radar_service.radar import FIRST_ID, Radar, horizon, max_rpm
from radar_service.records import ShipStates
from radar_service.world.body import Body
from radar_service.world.commands import Steerable
from radar_service.world.environment import Environment
from radar_service.world.error import SceneError
from radar_service.world.motion import Motion
from radar_service.world.reporting import Ais, ErrorSettings
from radar_service.world.seaway import NO_STREAM, Stream
from radar_service.world.steered_motion import SteeredMotion


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
    """The content of a scene file as one of its radars has it. The other properties are shortcuts to their parts.

    world: the bodies and their environment.
    radar: the parameters of the set.
    platform: the carrier of the antenna.
    warnings: sentences about unusual but usable content, in order.
    effects: what the scene keeps of the keys of effects, by their names (`stages`).
    notes: sentences about its files that need no action.
    errors: what sensors, antenna and feed of this radar report wrongly; None without any.
    radar_id: of this radar, "0" where the file has a single one without an id.
    radars: all radars of the file, in its order; `for_radar` gives the scene as another one has it.
    ais: its transponders, which change no spoke.
    gnss_offset: of own ship's antenna of satellite navigation, starboard and forward of its position [m].
    revision: of the motions and presences that commands change; own_revision: of own ship's.
    """

    world: World
    radar: Radar
    platform: Platform
    warnings: tuple[str, ...] = ()
    effects: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    errors: ErrorSettings | None = None
    radar_id: str = FIRST_ID
    radars: tuple[Installation, ...] = ()
    ais: Ais = Ais()
    gnss_offset: tuple[float, float] = (0.0, 0.0)
    revision: Revision = field(default=STEADY, compare=False)
    own_revision: Revision = field(default=STEADY, compare=False)

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

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The objects that the radar can detect: all of the world but its own platform."""
        return tuple(body for body in self.world.bodies if body.name != self.platform.body)

    @property
    def body_count(self) -> int:
        """Number of bodies."""
        return len(self.bodies)

    @property
    def steered(self) -> dict[str | None, SteeredMotion]:
        """The motions that commands may change, by the names of the bodies; None is own ship that is no body."""
        motions: dict[str | None, Motion] = {body.name: body.motion for body in self.world.bodies}
        if self.platform.body is None:
            motions[None] = self.own_ship
        return {name: motion for name, motion in motions.items() if isinstance(motion, SteeredMotion)}

    @property
    def steerable(self) -> Steerable:
        """What commands may steer."""
        limits = {name: motion.limits for name, motion in self.steered.items()}
        if self.platform.body in limits:  # own ship is this body
            limits[None] = limits[self.platform.body]
        return Steerable(limits, frozenset(body.name for body in self.world.bodies), self.radar, self.platform.body)

    @property
    def own_ship(self) -> Motion:
        """Motion of the platform."""
        return self.platform.motion

    def ship_states(self, times: Sequence[float], names: Sequence[str | None]) -> list[ShipStates]:
        """Returns the states at times (K,) [s] of bodies by name, of own ship for None. Raises KeyError for an unknown name."""
        bodies, time = {body.name: body for body in self.world.bodies}, np.asarray(times, dtype=np.float64)
        states = []
        for name in names:
            motion = self.own_ship if name is None else bodies[name].motion
            present = np.ones(len(time), dtype=np.bool_) if name is None else bodies[name].presence.at(time)
            pose = motion.pose(time)
            states.append(ShipStates(time, pose.position, pose.velocity, pose.heading, motion.turn_rate(time), present))
        return states

    @property
    def radar_ids(self) -> tuple[str, ...]:
        """The ids of all radars of the file."""
        return tuple(installation.id for installation in self.radars) or (self.radar_id,)

    @property
    def has_sensors(self) -> bool:
        """Whether the platform has gyro, log and position sensor: a fixed site has none."""
        return next((installation.has_sensors for installation in self.radars if installation.id == self.radar_id), True)

    @property
    def own_id(self) -> str:
        """The id of the radar where the file gives it one of its own; "" for the id "0"."""
        return "" if self.radar_id == FIRST_ID else self.radar_id

    @property
    def random_key(self) -> tuple[int, ...]:
        """What keeps the noise and the speckle of this radar apart from those of others: of its `own_id`, nothing for ""."""
        return (name_key(self.own_id),) if self.own_id else ()

    def for_radar(self, radar_id: str | None) -> "Scene":
        """Returns the same world as another radar of the file has it; None stands for this radar.

        Raises SceneError, which is a ValueError, where there is none of that id.
        """
        if radar_id in (None, self.radar_id):
            return self
        known = known_radar(radar_id, self.radar_ids)
        installation = next(installation for installation in self.radars if installation.id == known)
        own = {name: getattr(installation, name) for name in ("radar", "platform", "errors", "ais", "gnss_offset")}
        return replace(
            self, world=replace(self.world, environment=installation.environment), radar_id=installation.id, **own
        )

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

    def blind(self, time: Floats, boresight: Floats) -> Flags:
        """Returns whether boresights (K,) [rad from north] are in a blind sector at each time (K,) [s]."""
        if not self.radar.blind_sectors:
            return np.zeros(np.broadcast_shapes(time.shape, boresight.shape), dtype=np.bool_)
        return self.radar.is_blind(boresight - self.platform.heading(time))


def known_radar(radar_id: str | None, ids: Sequence[str]) -> str:
    """Returns the id of a radar among those of a scene; None stands for the first. Raises SceneError, which lists them."""
    if radar_id is None:
        return ids[0]
    if radar_id not in ids:
        raise SceneError(
            f'radar: "{str(radar_id)[:40]}" is not a radar of this scene; it has {", ".join(ids)}: give one of them'
        )
    return radar_id


def scene_at_rpm(scene: Scene, rpm: float) -> Scene:
    """Returns the scene with another rotation rate of its radar.

    Raises SceneError if a spoke then has no pulse of its own, the only rule of the loader that depends on the rate.
    """
    radar = scene.radar
    if radar.prf is not None and rpm > max_rpm(radar.prf, radar.azimuths):
        raise SceneError(
            f"rpm: {rpm:g} gives {radar.azimuths * rpm / 60.0:g} spokes a second, more than the {radar.prf:g} pulses of the "
            f"scene's prf_hz; give at most {60.0 * radar.prf / radar.azimuths:g}, or use a scene with a higher prf_hz"
        )
    return replace(scene, radar=replace(radar, rotation_period=60.0 / rpm))


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
    of_scene = {field.name: getattr(scene, field.name) for field in fields(SceneOutline) if field.name != "stream"}
    return SceneOutline(**of_scene, stream=scene.environment.stream)
