"""The bodies and answers of REST: names, units, ranges, examples. OpenAPI is derived from them.

The models of the controls are derived from `service.controls.CONTROLS`.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from radar_service.scene_file import (
    AntennaErrorsModel,
    FeedErrorsModel,
    GyroErrorsModel,
    LogErrorsModel,
    PositionErrorsModel,
)
from radar_service.service.controls import CONTROLS, Control, ControlError
from radar_service.stages.fields import Flag, Number, Whole


def problem_lines(errors: Sequence[Any]) -> list[str]:
    """Returns one line for each of pydantic's errors: the key, the value where it is short, the problem."""
    lines = []
    for error in errors[:20]:
        key = ".".join(str(step) for step in error["loc"] if step not in ("body", "query", "path")) or "body"
        value = repr(error.get("input"))
        shown = f" {value};" if len(value) <= 80 else ""
        lines.append(f"{key}:{shown} {error['msg']}")
    return lines


class RequestBody(BaseModel):
    """The body of a request: unknown keys, non-finite numbers and values of another type are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class PaceChange(RequestBody):
    """run, pause, or step: pause after `steps` more spokes; factor: simulated seconds per second, or as fast as possible."""

    state: Literal["run", "pause", "step"] | None = None
    steps: Whole = Field(1, ge=1, le=1_000_000, description="spokes to send, with state = step")
    factor: Annotated[Number, Field(gt=0, le=1e6)] | Literal["max"] | None = None


class PaceState(BaseModel):
    """The pace that is requested of the radar."""

    state: Literal["run", "pause"]
    factor: float | Literal["max"]


CHANGE_TYPES: dict[str, Any] = {"switch": Flag, "number": Number, "pace": PaceChange}  # by kind of control
EXAMPLES: dict[str, Any] = {"switch": True, "pace": {"state": "run", "factor": 1}}
STATE_TYPES: dict[str, Any] = {"switch": bool, "number": float, "pace": PaceState}


def _change_field(control: Control) -> Any:
    """Returns type and field of a control in a change: optional, within its limits."""
    optional = CHANGE_TYPES[control.kind] | None
    return optional, Field(None, ge=control.minimum, le=control.maximum, description=control.description)


_ChangeFields: Any = create_model("_ChangeFields", __base__=RequestBody, **{c.name: _change_field(c) for c in CONTROLS})
_StateFields: Any = create_model("_StateFields", **{c.name: STATE_TYPES[c.kind] for c in CONTROLS})


class ControlsChange(_ChangeFields):  # its fields are those of CONTROLS
    """Changes the given controls and no others. Controls of the display (see `control_definitions`) act on u8 only."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"gain": 60, "sea": 25}, {"range_m": 3000}]})


def checked_change(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the values of some controls, checked as a PATCH of them. Raises ControlError."""
    try:
        return dict(ControlsChange.model_validate(values).model_dump(exclude_none=True))
    except ValidationError as error:
        raise ControlError("; ".join(problem_lines(error.errors()))) from None


class ControlsState(_StateFields):  # its fields are those of CONTROLS
    """The state of all controls of a radar."""

    model_config = ConfigDict(json_schema_extra={"examples": [{c.name: EXAMPLES.get(c.kind, c.example) for c in CONTROLS}]})


class ControlDefinition(BaseModel):
    """A control that can be changed. acts_on: display (u8 only), transmitter, or engine (the scene is restarted)."""

    name: str = Field(description="its key in `controls`")
    kind: Literal["switch", "number", "pace"]
    unit: str
    minimum: float | None
    maximum: float | None
    step: float | None = Field(description="of a slider; null for a number that is typed")
    acts_on: Literal["display", "transmitter", "engine"]
    label: str = Field(description="its name for people")
    label_off: str = Field(description="of a switch that is off; empty where it is the same")
    description: str


class ErrorsState(BaseModel):
    """The errors on purpose in force, as `[errors]` of a scene file; null where a part has none."""

    gyro: GyroErrorsModel | None
    log: LogErrorsModel | None
    position: PositionErrorsModel | None
    antenna: AntennaErrorsModel | None
    feed: FeedErrorsModel | None


class SceneChoice(RequestBody):
    """The scene that a radar is to run: the name of a listed scene, or a whole scene (without files)."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"scene": "harbour"}]})

    scene: str | dict[str, Any]


class SceneUpload(RequestBody):
    """A scene to keep under a name; a scene with meshes is sent as multipart/form-data instead."""

    name: str
    scene: dict[str, Any]


class SceneAnswer(BaseModel):
    """A scene that was accepted. epoch: of the feed once it runs, null where it is only kept; plan: what is modelled of it.

    warnings: of the scene; for an upload also notes on its files; radars: their ids, once it runs those on the air.
    """

    name: str
    bodies: int
    warnings: list[str]
    epoch: str | None = None
    plan: dict[str, Any]
    radars: list[str]


class JobState(BaseModel):
    """Work that takes long: a scene that is prepared, an upload that is checked, a body that is read."""

    id: str
    kind: Literal["scene", "upload", "body"]
    state: Literal["waiting", "running", "done", "failed", "cancelled"]
    doing: str = Field(description="the present stage; empty after the end")
    seconds: float = Field(description="since the request, until the end")


class SceneListing(BaseModel):
    """A scene that can be run by name; problems: why it cannot be read."""

    name: str
    title: str
    summary: str
    origin: Literal["packaged", "folder", "uploaded"]
    problems: list[str]


class GeographicOrigin(BaseModel):
    """The position of east = north = 0 (WGS 84)."""

    latitude_deg: float
    longitude_deg: float


class RunningScene(BaseModel):
    """The scene that a radar runs."""

    name: str
    origin: GeographicOrigin | None
    bodies: int
    warnings: list[str]
    stream: tuple[float, float] | None = Field(None, description="of the water over ground, east and north [m/s]")


class RadarState(BaseModel):
    """One radar: its parameters, its scene, its controls and its state."""

    id: str
    name: str
    azimuths: int
    rpm: float
    bins: int
    range_step_m: float
    range_max_m: float
    beamwidth_deg: float
    beamwidth_el_deg: float
    frequency_hz: float
    modulation: Literal["lfm", "nlfm", "none"] = Field(
        description="lfm, nlfm: a linear, a nonlinear chirp; none: a plain pulse"
    )
    bandwidth_hz: float = Field(description="of the chirp, or of the receiver of a plain pulse")
    pulse_s: float
    prf_hz: float | None = Field(description="pulses per second; null where it has no effect")
    power_w: float
    height_m: float
    blind_sectors_deg: list[tuple[float, float]]
    scene: RunningScene
    seed: int
    fidelity: str
    plan: dict[str, Any]
    controls: ControlsState
    control_definitions: list[ControlDefinition]
    state: Literal["running", "behind", "paused", "standby", "waiting", "restarting", "failed"]
    epoch: str
    feed: str = Field(description="address of the native feed, relative to the server")
    encodings: list[str]


class RadarHealth(BaseModel):
    """The health of one radar. slips: times that the engine was so late that the schedule started anew."""

    id: str
    state: Literal["running", "behind", "paused", "standby", "waiting", "restarting", "failed"]
    fault: str | None
    pace: PaceState
    factor_reached: float | None = Field(description="simulated seconds per second over the last seconds")
    restarts: int = Field(description="times that the engine failed and was started again")
    lag_s: float = Field(description="how late the newest spokes were sent")
    slips: int
    simulated_s: float
    epoch: str
    next: int = Field(description="sequence number of the next spoke")
    spokes_sent: int
    spokes_lost: int = Field(description="by slow clients, all together")
    clients: int
    views: int


class Health(BaseModel):
    """The health of the server: failed or restarting when any radar is (status 503), behind when any cannot keep its pace."""

    status: Literal["ok", "behind", "restarting", "failed"]
    version: str
    radars: list[RadarHealth]


class ReadyState(BaseModel):
    """The answer to a probe; `problems` of the server only where there are some."""

    yes: bool
    problems: list[str] = []


class Ticket(BaseModel):
    """A one-time text that opens one websocket (its parameter `ticket`), within `seconds`."""

    ticket: str
    seconds: float


class Problem(BaseModel):
    """Why a request was refused: one line for each problem, with the key, the value and what is allowed."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"detail": ["gain: 140; less than or equal to 100 is allowed"]}]}
    )

    detail: list[str]
