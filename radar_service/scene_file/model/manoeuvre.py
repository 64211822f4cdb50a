"""Scene file model of manoeuvres: changes of course, speed and turn rate at given times."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from radar_service.scene_file.model.fields import Bearing, Section, Speed

MAX_MANOEUVRES = 1000
TurnRate = Annotated[float, Field(strict=True, ge=-60, le=60)]  # degrees a second; fast craft reach 20


class ManoeuvreModel(Section):
    """A change of course, of speed, or of both, at a time."""

    time_s: Annotated[float, Field(strict=True, ge=0, le=1e9)] = Field(description="when it begins")
    course_deg: Bearing | None = Field(None, description="the new course, reached at turn_rate_deg_s by the shorter way")
    speed_kn: Speed | None = Field(None, description="the new speed, at once")
    turn_rate_deg_s: TurnRate | None = Field(
        None, description="to starboard; without course_deg the turn goes on; default: a new course is taken at once"
    )

    @model_validator(mode="after")
    def _check_change(self) -> Self:
        if self.course_deg is None and self.speed_kn is None and self.turn_rate_deg_s is None:
            raise ValueError("time_s: nothing changes then; add course_deg, speed_kn or turn_rate_deg_s")
        if self.course_deg is not None and self.turn_rate_deg_s is not None and self.turn_rate_deg_s <= 0.0:
            raise ValueError(
                f"turn_rate_deg_s: {self.turn_rate_deg_s:g} to a course, which is reached by the shorter way; give a rate above 0"
            )
        return self


class TurningSection(Section):
    """How a moving body turns, and how it sets."""

    turn_rate_deg_s: TurnRate | None = Field(
        None, description="turns all the time, to starboard; with waypoints rounds their corners at this rate, above 0"
    )
    manoeuvre: tuple[ManoeuvreModel, ...] = Field(
        (), max_length=MAX_MANOEUVRES, description="changes of course and speed, by rising time"
    )
    drift_deg: Annotated[float, Field(strict=True, ge=-180, le=180)] = Field(
        0.0, description="course over ground minus heading: above 0 she sets to starboard"
    )

    def check_turns(self, fixed_heading: bool, route: str | None, rounded: bool) -> None:
        """Raises ValueError where turns contradict other keys.

        fixed_heading: whether heading_deg is given; route: the key that defines the course, or None; rounded: whether
        turn_radius_m is given.
        """
        for key in ("turn_rate_deg_s", "manoeuvre", "drift_deg"):
            follows = route is None or key == "drift_deg"
            if fixed_heading and getattr(self, key) and follows:
                raise ValueError(
                    f"heading_deg: with {key} the heading follows the course; give course_deg, and drift_deg if they differ"
                )
        if route == "track" and self.turn_rate_deg_s is not None:
            raise ValueError("turn_rate_deg_s: the track already defines the course; remove turn_rate_deg_s")
        if route is not None and self.manoeuvre:
            raise ValueError(f"manoeuvre: {route} already defines the course; remove one of the two")
        if route is not None and self.turn_rate_deg_s is not None and rounded:
            raise ValueError("turn_rate_deg_s: turn_radius_m already rounds the corners; remove one of the two")
        if route is not None and self.turn_rate_deg_s is not None and self.turn_rate_deg_s <= 0.0:
            raise ValueError(
                f"turn_rate_deg_s: {self.turn_rate_deg_s:g}, where waypoints say which way to turn; give a rate above 0"
            )
        for k, (before, after) in enumerate(zip(self.manoeuvre, self.manoeuvre[1:], strict=False)):
            if after.time_s <= before.time_s:
                raise ValueError(
                    f"manoeuvre[{k + 1}].time_s: {after.time_s:g} is not after {before.time_s:g} of the one before; sort them"
                )
