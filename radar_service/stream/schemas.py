"""The bodies and answers of the REST interface: names, units, ranges, examples. OpenAPI is made of these."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Percent = Annotated[float, Field(ge=0, le=100)]


class Body(BaseModel):
    """Something a client sends: unknown keys and non-finite numbers are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class PaceChange(Body):
    """run, pause, or step: pause after so many spokes more; factor: simulated seconds per second, or as fast as possible."""

    state: Literal["run", "pause", "step"] | None = None
    steps: int = Field(1, ge=1, le=1_000_000, description="spokes to send, with state = step")
    factor: Annotated[float, Field(gt=0, le=1e6)] | Literal["max"] | None = None


class ControlsChange(Body):
    """What is named changes, the rest stays. gain, sea and rain act on u8 only."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"gain": 60, "sea": 25}, {"range_m": 3000}]})

    transmit: bool | None = Field(None, description="false is standby: no spokes, time goes on")
    range_m: float | None = Field(None, ge=10, description="display range, at most the scene's; opens a new epoch")
    gain: Percent | None = Field(None, description="1 dB per percent; 50: noise shows with probability 1e-4")
    sea: Percent | None = Field(None, description="STC, 0 is off")
    rain: Percent | None = Field(None, description="FTC, 0 is off")
    rpm: float | None = Field(None, ge=0.01, le=600, description="starts the scene anew when the running scan ends")
    pace: PaceChange | None = None


class PaceState(BaseModel):
    """How fast the radar is asked to go."""

    state: Literal["run", "pause"]
    factor: float | Literal["max"]


class ControlsState(BaseModel):
    """All controls of a radar."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"transmit": True, "range_m": 5000, "gain": 50, "sea": 0, "rain": 0, "rpm": 24,
                 "pace": {"state": "run", "factor": 1}}
            ]
        }
    )  # fmt: skip

    transmit: bool
    range_m: float
    gain: float
    sea: float
    rain: float
    rpm: float
    pace: PaceState


class SceneChoice(Body):
    """The scene that a radar shall run: the name of one on the list, or a whole scene (without files)."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"scene": "harbour"}]})

    scene: str | dict[str, Any]


class SceneUpload(Body):
    """A scene to keep on the list under a name; with meshes send multipart/form-data instead."""

    name: str
    scene: dict[str, Any]


class SceneAnswer(BaseModel):
    """A scene that was taken. epoch: of the feed once it runs, null for one that is only kept; plan: what is modelled of it."""

    name: str
    bodies: int
    warnings: list[str]
    epoch: str | None = None
    plan: dict[str, Any]


class SceneOffer(BaseModel):
    """A scene on the list; problems: why it cannot be read."""

    name: str
    title: str
    summary: str
    origin: Literal["packaged", "folder", "uploaded"]
    problems: list[str]


class GeographicOrigin(BaseModel):
    """Where east = north = 0 lies (WGS 84)."""

    latitude_deg: float
    longitude_deg: float


class RunningScene(BaseModel):
    """The scene that a radar runs."""

    name: str
    origin: GeographicOrigin | None
    bodies: int
    warnings: list[str]


class RadarState(BaseModel):
    """One radar: what it is, what it runs, how it does."""

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
    height_m: float
    blind_sectors_deg: list[tuple[float, float]]
    scene: RunningScene
    seed: int
    fidelity: str
    plan: dict[str, Any]
    controls: ControlsState
    state: Literal["running", "behind", "paused", "standby", "restarting", "failed"]
    epoch: str
    feed: str = Field(description="address of the native feed, relative to the server")
    encodings: list[str]


class RadarHealth(BaseModel):
    """How one radar does. slips: times the engine was so late that the schedule started afresh."""

    id: str
    state: Literal["running", "behind", "paused", "standby", "restarting", "failed"]
    fault: str | None
    pace: PaceState
    factor_reached: float | None = Field(description="simulated seconds per second over the last seconds")
    restarts: int = Field(description="times the engine died and was started again")
    lag_s: float = Field(description="how late the newest spokes went out")
    slips: int
    simulated_s: float
    epoch: str
    next: int = Field(description="sequence number of the next spoke")
    spokes_sent: int
    spokes_lost: int = Field(description="by slow clients, all together")
    clients: int
    views: int


class Health(BaseModel):
    """How the server does: failed or restarting when any radar is (status 503), behind when any cannot keep its pace."""

    status: Literal["ok", "behind", "restarting", "failed"]
    version: str
    radars: list[RadarHealth]


class Yes(BaseModel):
    """The answer to a probe."""

    yes: bool


class BodyState(BaseModel):
    """True state of a body, SI and radians; see records.BodyTruth."""

    name: str
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    heading: float
    course: float
    speed: float
    range: float
    azimuth: float
    elevation: float
    visible: bool
    reason: str
    latitude_deg: float | None
    longitude_deg: float | None
    mmsi: int | None


class TruthState(BaseModel):
    """The true state of everything at `time` [s of simulation]."""

    time: float
    own_ship: BodyState
    bodies: list[BodyState]


class Ticket(BaseModel):
    """What opens one websocket (its parameter `ticket`), for so many seconds."""

    ticket: str
    seconds: float


class Problem(BaseModel):
    """Why a request was refused: a line per fault, each naming the place, the value, what is allowed."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"detail": ["gain: 140; less than or equal to 100 is allowed"]}]}
    )

    detail: list[str]
