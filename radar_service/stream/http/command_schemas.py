"""The bodies and answers of REST about commands."""

from pydantic import BaseModel, ConfigDict, Field

from radar_service.scene.fields import Flag, Number
from radar_service.stream.http.schemas import Body


class CommandChange(Body):
    """A command to own ship or a body, from the first spoke that is not sent yet; what is left out does not change.

    Limits of speed and turn rate are those of the scene.
    """

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"course_deg": 90, "speed_kn": 12}, {"position_m": [500, 800], "present": True}]}
    )

    course_deg: Number | None = Field(
        None, ge=-360, le=360, description="reached at turn_rate_deg_s, or at the highest rate"
    )
    speed_kn: Number | None = Field(None, ge=0, description="over the ground, at once")
    turn_rate_deg_s: Number | None = Field(None, description="positive to starboard; without course_deg it goes on")
    heading_deg: Number | None = Field(
        None, ge=-360, le=360, description="of the bow, at once; keeps its angle to the course"
    )
    position_m: tuple[Number, Number] | None = Field(None, description="east, north, at once")
    present: Flag | None = Field(None, description="of a body: whether it is there")
    at_once: Flag | None = Field(None, description="the course jumps to course_deg, and turn_rate_deg_s goes on from there")


class CommandState(BaseModel):
    """A command as it is carried out. body: null for own ship; spoke: the first one that shows it; time: of that spoke [s]."""

    body: str | None
    spoke: int
    time: float
    course_deg: float | None = None
    speed_kn: float | None = None
    turn_rate_deg_s: float | None = None
    heading_deg: float | None = None
    position_m: tuple[float, float] | None = None
    present: bool | None = None
    at_once: bool | None = None


class SteerableState(BaseModel):
    """What may be commanded, and the latest command; null before the first one."""

    body: str | None
    max_speed_kn: float
    max_turn_rate_deg_s: float
    latest: CommandState | None
