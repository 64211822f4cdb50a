"""Scene file models of motion, which own ship and bodies that move have in common: routes, manoeuvres, sway, seaway and hulls."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from radar_service.stages.fields import Bearing, EastNorth, Flag, Number, Section, Size, Speed, Whole

MAX_MANOEUVRES = 1000
TurnRate = Annotated[float, Field(strict=True, ge=-60, le=60)]  # degrees a second; fast craft reach 20

Coefficient = Annotated[float, Field(strict=True, ge=0.2, le=1.0)]


class SeawayModel(Section):
    """Waves that move ships."""

    height_m: Annotated[float, Field(strict=True, gt=0, le=20)] | None = Field(
        None, description="significant wave height; default: that of the sea, which then has one"
    )
    period_s: Annotated[float, Field(strict=True, ge=1.5, le=30)] | None = Field(
        None, description="of the spectrum's peak; default: most probable at this height on the open North Atlantic"
    )
    from_deg: Bearing | None = Field(None, description="where waves come from; default: `wind_from_deg`")
    spread: Annotated[float, Field(strict=True, ge=0.5, le=1000)] = Field(
        1.0, description="s of their directions, cos^(2 s): a large one makes all crests parallel"
    )
    seed: Whole = Field(0, ge=0, le=2**32 - 1, description="of the waves, lists and trims")
    list_deg: Number = Field(0.5, ge=0, le=10, description="standard deviation of the lists that are drawn for ships")
    trim_deg: Number = Field(0.2, ge=0, le=5, description="standard deviation of the trims that are drawn for ships")


class HullModel(Section):
    """What a seaway needs to know of a hull."""

    floats: Flag | None = Field(None, description="whether a seaway moves it; default: vessels, and bodies with this table")
    length_m: Size | None = Field(None, description="in the water; default: of its mesh")
    beam_m: Size | None = Field(None, description="default: of its mesh")
    draught_m: Annotated[float, Field(strict=True, gt=0, le=100)] | None = Field(
        None, description="default: `draught_m` of the body, how deep its mesh reaches, or 0.4 of its beam"
    )
    block: Coefficient = Field(0.7, description="displaced volume over length x beam x draught")
    waterplane: Coefficient | None = Field(None, description="its area over length x beam; default: a third of 1 + 2 block")
    roll_period_s: Annotated[float, Field(strict=True, ge=1, le=60)] | None = Field(
        None, description="default: of a metacentric height of a tenth of the beam, by the IMO's weather criterion"
    )
    roll_damping: Annotated[float, Field(strict=True, ge=0.02, le=1)] = Field(0.1, description="over critical damping")


class ManoeuvreModel(Section):
    """A change of course, of speed, or of both, at a time."""

    time_s: Annotated[float, Field(strict=True, ge=0, le=1e9)] = Field(description="when it begins")
    course_deg: Bearing | None = Field(None, description="the new course, reached at turn_rate_deg_s by the shorter way")
    speed_kn: Speed | None = Field(None, description="the new speed, at once")
    turn_rate_deg_s: TurnRate | None = Field(
        None, description="to starboard; without course_deg the turn goes on; default: a new course is taken at once"
    )

    def problems(self) -> Iterator[str]:
        if self.course_deg is None and self.speed_kn is None and self.turn_rate_deg_s is None:
            yield "time_s: nothing changes then; add course_deg, speed_kn or turn_rate_deg_s"
        if self.course_deg is not None and self.turn_rate_deg_s is not None and self.turn_rate_deg_s <= 0.0:
            yield (
                f"turn_rate_deg_s: {self.turn_rate_deg_s:g} to a course, which is reached by the shorter way; give a rate above 0"
            )


class TurningSection(Section):
    """How a moving body turns, and how it sets."""

    turn_rate_deg_s: TurnRate | None = Field(
        None, description="turns all the time, to starboard; with waypoints rounds their corners at this rate, above 0"
    )
    manoeuvre: tuple[ManoeuvreModel, ...] = Field(
        (), max_length=MAX_MANOEUVRES, description="changes of course and speed, by rising time"
    )
    drift_deg: Annotated[float, Field(strict=True, ge=-180, le=180)] = Field(
        0.0, description="course over ground minus heading: above 0 it sets to starboard"
    )


SwayAngle = Annotated[float, Field(strict=True, ge=0, le=45)]  # degrees
Period = Annotated[float, Field(strict=True, ge=1, le=3600)]  # s; ships roll in 4 to 30
AMPLITUDES = {"roll": "roll_deg", "pitch": "pitch_deg", "yaw": "yaw_deg", "heave": "heave_m"}  # key of each amplitude


class SwaySection(Section):
    """Each angle, and the heave, is amplitude x sin(2 pi t / period + phase). Any amplitude replaces what a seaway does."""

    roll_deg: SwayAngle = Field(0.0, description="amplitude; first with the starboard side down")
    roll_period_s: Period = 10.0
    roll_phase_deg: Bearing = 0.0
    pitch_deg: SwayAngle = Field(0.0, description="amplitude; first with the bow up")
    pitch_period_s: Period = 7.0
    pitch_phase_deg: Bearing = 0.0
    yaw_deg: SwayAngle = Field(0.0, description="amplitude about the heading; first to starboard")
    yaw_period_s: Period = 20.0
    yaw_phase_deg: Bearing = 0.0
    heave_m: Annotated[float, Field(strict=True, ge=0, le=20)] = Field(0.0, description="amplitude; first up")
    heave_period_s: Period = 8.0
    heave_phase_deg: Bearing = 0.0
    list_deg: Annotated[float, Field(strict=True, ge=-45, le=45)] | None = Field(
        None, description="added to roll: to starboard above 0; default: 0, or drawn by `seaway`"
    )
    trim_deg: Annotated[float, Field(strict=True, ge=-45, le=45)] | None = Field(
        None, description="added to pitch: bow up above 0; default: 0, or drawn by `seaway`"
    )
    hull: HullModel | None = Field(None, description="how `seaway` moves it; a table, {} for the defaults")

    def problems(self) -> Iterator[str]:
        for name, amplitude in AMPLITUDES.items():
            for key in (f"{name}_period_s", f"{name}_phase_deg"):
                if key in self.model_fields_set and not getattr(self, amplitude):
                    yield f"{key}: it needs an amplitude; add {amplitude} or remove {key}"


class WaypointModel(Section):
    """A position on a route, and the speed on the leg to it."""

    position_m: EastNorth
    speed_kn: Number = Field(gt=0, le=2000)


class SteerableModel(Section):
    """What commands may order while the radar runs: see docs/commands.md."""

    max_speed_kn: Number = Field(30.0, ge=0, le=2000)
    max_turn_rate_deg_s: Number = Field(5.0, gt=0, le=90, description="also the rate of turns to a course")


class RouteSection(Section):
    """A constant course and speed, or waypoints, or a track from a file."""

    heading_deg: Bearing | None = Field(None, description="default: the course")
    course_deg: Bearing | None = Field(None, description="default: the heading")
    speed_kn: Speed = 0.0
    waypoints: tuple[WaypointModel, ...] = Field((), max_length=1000)
    loop: Flag = Field(False, description="returns to the start after the last waypoint, and repeats")
    turn_radius_m: Size | None = Field(None, description="rounds the corners at waypoints; the heading follows the arc")
    track: str | None = Field(
        None,
        min_length=1,
        max_length=500,
        description="CSV with time_s and east_m, north_m (or latitude_deg, longitude_deg), optional up_m, heading_deg",
    )
    steerable: SteerableModel | None = Field(None, description="a table: commands may steer it; {} for the defaults")


class MovingSection(SwaySection, TurningSection, RouteSection):
    """Motion that own ship and bodies share: a route, turns and manoeuvres, and sway."""

    def problems(self) -> Iterator[str]:
        yield from super().problems()
        kinds = [bool(self.waypoints), self.track is not None, self.speed_kn > 0]
        if sum(kinds) > 1:
            yield (
                "speed_kn: only one of speed_kn (with course_deg), waypoints (each with its speed_kn) and track is "
                "allowed; remove the rest"
            )
        if self.course_deg is not None and (self.waypoints or self.track is not None):
            route = "waypoints" if self.waypoints else "the track"
            yield f"course_deg: {route} already define the course; remove course_deg"
        if self.track is not None and "position_m" in self.model_fields_set:
            yield "position_m: the track already defines the position; remove position_m"
        if self.loop and not self.waypoints:
            yield "loop: only a route of waypoints can repeat; add waypoints or remove loop"
        if self.turn_radius_m is not None and not self.waypoints:
            yield "turn_radius_m: only corners at waypoints are rounded; add waypoints or remove turn_radius_m"
        yield from self._turn_problems("waypoints" if self.waypoints else "track" if self.track is not None else None)

    def _turn_problems(self, route: str | None) -> Iterator[str]:
        """Yields where turns contradict other keys. route: the key that defines the course, or None."""
        for key in ("turn_rate_deg_s", "manoeuvre", "drift_deg"):
            follows = route is None or key == "drift_deg"
            if self.heading_deg is not None and getattr(self, key) and follows:
                yield (
                    f"heading_deg: with {key} the heading follows the course; give course_deg, and drift_deg if they differ"
                )
        if route == "track" and self.turn_rate_deg_s is not None:
            yield "turn_rate_deg_s: the track already defines the course; remove turn_rate_deg_s"
        if route is not None and self.manoeuvre:
            yield f"manoeuvre: {route} already defines the course; remove one of the two"
        if route is not None and self.turn_rate_deg_s is not None and self.turn_radius_m is not None:
            yield "turn_rate_deg_s: turn_radius_m already rounds the corners; remove one of the two"
        if route is not None and self.turn_rate_deg_s is not None and self.turn_rate_deg_s <= 0.0:
            yield f"turn_rate_deg_s: {self.turn_rate_deg_s:g}, where waypoints say which way to turn; give a rate above 0"
        for k, (before, after) in enumerate(zip(self.manoeuvre, self.manoeuvre[1:], strict=False)):
            if after.time_s <= before.time_s:
                yield (
                    f"manoeuvre[{k + 1}].time_s: {after.time_s:g} is not after {before.time_s:g} of the one before; sort them"
                )
