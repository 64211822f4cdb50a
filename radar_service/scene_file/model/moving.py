"""Scene file model of motion: what own ship and bodies that move have in common."""

from typing import Self

from pydantic import Field, model_validator

from radar_service.scene_file.model.fields import Bearing, EastNorth, Flag, Number, Section, Size, Speed
from radar_service.scene_file.model.manoeuvre import TurningSection
from radar_service.scene_file.model.sway import SwaySection


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

    @model_validator(mode="after")
    def _check_motion(self) -> Self:
        kinds = [bool(self.waypoints), self.track is not None, self.speed_kn > 0]
        if sum(kinds) > 1:
            raise ValueError(
                "speed_kn: only one of speed_kn (with course_deg), waypoints (each with its speed_kn) and track is "
                "allowed; remove the rest"
            )
        if self.course_deg is not None and (self.waypoints or self.track is not None):
            route = "waypoints" if self.waypoints else "the track"
            raise ValueError(f"course_deg: {route} already define the course; remove course_deg")
        if self.track is not None and "position_m" in self.model_fields_set:
            raise ValueError("position_m: the track already defines the position; remove position_m")
        if self.loop and not self.waypoints:
            raise ValueError("loop: only a route of waypoints can repeat; add waypoints or remove loop")
        if self.turn_radius_m is not None and not self.waypoints:
            raise ValueError("turn_radius_m: only corners at waypoints are rounded; add waypoints or remove turn_radius_m")
        by = "waypoints" if self.waypoints else "track" if self.track is not None else None
        self.check_turns(self.heading_deg is not None, by, self.turn_radius_m is not None)
        return self
