"""The world in SI: what the engine is given. Places are east, north, up [m] on the map; angles in radians.

`load` builds these records from a scene file; nothing here reads files. All records are frozen.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import effective_earth_radius, map_from_body, map_from_deck, wrap_bearing
from radar_service.radar.parameters import Radar, horizon
from radar_service.scene.turns import along_arc

Floats = NDArray[np.float64]
Scattering = Literal["rcs", "diffuse", "optics"]


@dataclass(frozen=True)
class Environment:
    """What lies between the radar and the bodies."""

    earth_factor: float  # effective earth radius over the earth's radius; inf is flat
    noise: bool
    multipath: bool
    gas_db_per_km: float  # one way, already resolved where the scene says "itu"
    rain_mm_h: float
    sea_state: int
    sea_texture_shape: float | None  # nu of the gamma texture everywhere, or None: by grazing angle and cell
    wind_from: float
    ground_plane: bool


class Pose(NamedTuple):
    """State at K instants: position (K, 3) [m], velocity (K, 3) [m/s], heading (K,) [rad] in [0, 2 pi)."""

    position: Floats
    velocity: Floats
    heading: Floats

    @property
    def course(self) -> Floats:
        """Course over ground [rad] in [0, 2 pi); the heading where there is no way on."""
        moving = np.hypot(self.velocity[:, 0], self.velocity[:, 1]) > 0
        return wrap_bearing(np.where(moving, np.arctan2(self.velocity[:, 0], self.velocity[:, 1]), self.heading))

    @property
    def speed(self) -> Floats:
        """Speed over ground [m/s]."""
        return np.hypot(self.velocity[:, 0], self.velocity[:, 1])


@dataclass(frozen=True)
class Sway:
    """A ship in a seaway: angles amplitude x sin(2 pi t / period), (3,) each: roll (starboard side down), pitch (bow up),
    yaw (to starboard) [rad] and [s]. She turns about the point of the sea's surface that her position names."""

    amplitude: Floats
    period: Floats

    def angles(self, time: Floats) -> Floats:
        """Roll, pitch and yaw (K, 3) [rad] at each time (K,) [s]."""
        return np.asarray(self.amplitude * np.sin(2.0 * np.pi / self.period * time[:, None]))


@dataclass(frozen=True)
class Motion:
    """Piecewise linear motion through knots; beyond the last knot it goes on with `final_velocity`.

    time: (M,) rising [s], first knot at or before which the body stands; position: (M, 3) [m]; heading: (M,) [rad], the
    heading on the leg that begins at that knot (or, with `turning`, at that knot, interpolated the short way round).
    period: after which a closed track starts again [s], or None. arcs: (M, 3) where legs bend: course at the knot [rad],
    speed [m/s] and turn rate [rad/s, 0: straight] of the leg that begins there; the heading turns along unless `fixed`.
    sway: adds its yaw to the heading; its roll and pitch are `Scene`'s.
    """

    time: Floats
    position: Floats
    heading: Floats
    final_velocity: Floats = field(default_factory=lambda: np.zeros(3))
    turning: bool = False
    period: float | None = None
    arcs: Floats | None = None
    fixed: bool = False
    sway: Sway | None = None

    def __post_init__(self) -> None:
        assert self.time.ndim == 1 and self.position.shape == (self.time.size, 3) and self.heading.shape == self.time.shape

    @cached_property
    def at_rest(self) -> bool:
        """Whether position and heading never change."""
        still = bool(np.all(self.position == self.position[0]) and not self.final_velocity.any())
        return still and bool(np.all(self.heading == self.heading[0])) and self.sway is None

    @cached_property
    def top_speed(self) -> float:
        """The highest speed [m/s] on any leg or arc, and beyond the last knot; sway not counted."""
        legs = np.linalg.norm(self._leg_velocity, axis=1).max()
        arcs = 0.0 if self.arcs is None else self.arcs[:, 1].max()
        return float(max(legs, arcs))

    def pose(self, time: Floats | float) -> Pose:
        """The state at each `time` (K,) [s]."""
        t = np.atleast_1d(np.asarray(time, dtype=np.float64))
        if len(self.time) == 1 and self.sway is None:
            return self._straight(t)
        if self.period is not None:
            t = t % self.period
        leg = np.searchsorted(self.time[1:], t, side="right")
        velocity = self._leg_velocity[leg]
        if t.size and t.min() < self.time[0]:
            velocity[t < self.time[0]] = 0.0
        since = np.maximum(t - self.time[leg], 0.0)
        heading = self.heading[leg]
        if self.turning:
            heading = heading + self._leg_turn[leg] * since
        made = velocity * since[:, None]
        if self.arcs is not None:
            bent = np.flatnonzero(self.arcs[leg, 2])
            course, speed, rate = self.arcs[leg[bent]].T
            made[bent], velocity[bent] = along_arc(course, speed, rate, since[bent])
            heading = heading if self.fixed else heading + self.arcs[leg, 2] * since
        if self.sway is not None:
            heading = heading + self.sway.angles(np.broadcast_to(time, t.shape))[:, 2]
        return Pose(self.position[leg] + made, velocity, wrap_bearing(heading))

    @cached_property
    def _leg_velocity(self) -> Floats:
        """Velocity (M, 3) [m/s] on the leg that begins at each knot; 0 on one that takes no time."""
        span, steps = np.diff(self.time)[:, None], np.diff(self.position, axis=0)
        made = np.divide(steps, span, out=np.zeros_like(steps), where=span > 0)
        return np.concatenate([made, self.final_velocity[None]])

    @cached_property
    def _leg_turn(self) -> Floats:
        """Rate (M,) [rad/s] at which the heading goes the short way round to that of the next knot."""
        span, turn = np.diff(self.time), (np.diff(self.heading) + np.pi) % (2 * np.pi) - np.pi
        return np.append(np.divide(turn, span, out=np.zeros_like(turn), where=span > 0), 0.0)

    def _straight(self, t: Floats) -> Pose:
        """The state at each t (K,) of a body that knows one leg only: most of them, and most of these at rest."""
        since = np.maximum(t - self.time[0], 0.0)[:, None]
        velocity = np.where(t[:, None] >= self.time[0], self.final_velocity, 0.0)
        heading = np.full(len(t), wrap_bearing(self.heading[0]))
        return Pose(self.position[0] + since * self.final_velocity, velocity, heading)


@dataclass(frozen=True)
class Material:
    """How a surface scatters at X band."""

    name: str
    gamma: float  # sigma0 = gamma cos(incidence), power ratio
    scattering: Scattering  # the default for bodies made of it


@dataclass(frozen=True)
class Mesh:
    """Triangles in a body's own frame: vertices (V, 3) float64 [m], faces (F, 3) int64, every index in range."""

    vertices: Floats
    faces: NDArray[np.int64]

    def __post_init__(self) -> None:
        assert self.vertices.ndim == 2 and self.vertices.shape[1] == 3 and self.faces.shape[1:] == (3,)


@dataclass(frozen=True)
class Body:
    """Anything the radar can see. mesh is None for a point. rcs: declared cross-section [m^2], or None."""

    name: str
    mesh: Mesh | None
    motion: Motion
    material: Material
    scattering: Scattering
    rcs: float | None
    swerling: int
    mmsi: int | None
    length: float  # m, horizontal extents of the body in its own frame, 0 for a point
    beam: float

    @property
    def middle(self) -> Floats:
        """Middle (3,) of its plan in its own frame [m], at the height of its origin, which may lie far from its mesh."""
        return self._plan[0]

    @property
    def radius(self) -> float:
        """Of the circle about `middle` that holds its plan [m]; 0 for a point."""
        return self._plan[1]

    @property
    def arm(self) -> float:
        """How far its plan reaches from its origin [m], about which it turns."""
        return self._plan[2]

    def middle_at(self, time: float) -> Floats:
        """Where `middle` (3,) is on the map [m] at `time` [s]."""
        pose = self.motion.pose(time)
        return map_from_body(self.middle, pose.position[0], float(pose.heading[0]))

    @cached_property
    def _plan(self) -> tuple[Floats, float, float]:
        """Middle, radius and arm."""
        if self.mesh is None:
            return np.zeros(3), 0.0, 0.0
        used = np.zeros(len(self.mesh.vertices), dtype=np.bool_)
        used[self.mesh.faces] = True
        east, north = self.mesh.vertices[used, :2].T
        middle = np.array([east.min() + east.max(), north.min() + north.max(), 0.0]) / 2.0
        radius = np.hypot(east - middle[0], north - middle[1]).max()
        return middle, float(radius), float(np.hypot(east, north).max())


@dataclass(frozen=True)
class Interferer:
    """Another radar whose pulses are heard; see InterferenceModel."""

    bearing: float  # rad from own ship, where there is no position
    position: tuple[float, float] | None  # east, north [m]
    level: float  # power ratio to the receiver's noise, beam to beam
    frequency_offset: float
    pulse: float
    prf: float
    rotation_period: float
    beamwidth: float


@dataclass(frozen=True)
class Scene:
    """A loaded scene. warnings: what was found odd but usable, a sentence each, in order."""

    name: str
    origin: tuple[float, float] | None  # latitude, longitude [degrees], WGS 84: only edges use it
    radar: Radar
    environment: Environment
    own_ship: Motion  # the antenna stands radar.height above the sea at this place
    bodies: tuple[Body, ...]
    warnings: tuple[str, ...] = ()
    interference: tuple[Interferer, ...] = ()

    def __repr__(self) -> str:
        radar, triangles = self.radar, sum(len(body.mesh.faces) for body in self.bodies if body.mesh is not None)
        more = f" and {len(self.bodies) - 6} more" if len(self.bodies) > 6 else ""
        return (
            f"<Scene {self.name!r}: {len(self.bodies)} bodies, {triangles} triangles, {len(self.warnings)} warnings,\n"
            f"  radar of {radar.azimuths} azimuths and {radar.bins} cells to {radar.range_max:g} m, "
            f"{60.0 / radar.rotation_period:g} rpm,\n  bodies {', '.join(body.name for body in self.bodies[:6])}{more}>"
        )

    def antenna(self, time: Floats | float) -> Floats:
        """Antenna places (K, 3) east, north, height above the sea [m] at each time (K,)."""
        pose = self.own_ship.pose(time)
        place = pose.position
        if self.own_ship.sway is None:
            place[:, 2] = self.radar.height
            return place
        roll, pitch, _ = self.own_ship.sway.angles(np.atleast_1d(np.asarray(time, dtype=np.float64))).T
        place[:, 2] = 0.0
        return place + self.radar.height * map_from_deck(pose.heading, roll, pitch)[:, :, 2]

    def upright_from_map(self, time: Floats) -> Floats | None:
        """Matrices (K, 3, 3) that turn directions on the map into those that the antenna, turning about a mast that sways,
        takes them for: as they would be if the ship stood upright on the same heading. None where she always does."""
        if self.own_ship.sway is None:
            return None
        roll, pitch, _ = self.own_ship.sway.angles(time).T
        heading = self.own_ship.pose(time).heading
        level = map_from_deck(heading, np.zeros(len(time)), np.zeros(len(time)))
        return np.asarray(level @ map_from_deck(heading, roll, pitch).transpose(0, 2, 1))

    def horizon(self, height: float = 0.0) -> float:
        """Ground distance [m] beyond which the sea hides a target `height` [m] above it; inf on a flat earth."""
        return float(horizon(height, self.radar.height, effective_earth_radius(self.environment.earth_factor)))

    def blind(self, time: Floats, boresight: Floats) -> NDArray[np.bool_]:
        """Whether the radar is silent (K,): boresights (K,) [rad from north] in a blind sector at each time (K,) [s]."""
        return self.radar.is_blind(boresight - self.own_ship.pose(time).heading)
