"""Scene file model of errors on purpose: what sensors, antenna and feed report wrongly. The echoes are computed without them."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from radar_service.stages.fields import Bearing, Number, Section, Whole

MAX_LATENCY_S = 10.0
MAX_PERIODS = 1000  # of lost heading

ErrorAngle = Annotated[float, Field(strict=True, ge=-180, le=180)]  # degrees
SmallAngle = Annotated[float, Field(strict=True, ge=0, le=45)]  # degrees
ErrorSpeed = Annotated[float, Field(strict=True, ge=-100, le=100)]  # knots
ErrorDistance = Annotated[float, Field(strict=True, ge=-100_000, le=100_000)]  # m
CorrelationTime = Annotated[float, Field(strict=True, ge=0, le=86_400)]  # s
Latency = Annotated[float, Field(strict=True, ge=0, le=MAX_LATENCY_S)]  # s
Probability = Annotated[float, Field(strict=True, ge=0, le=1)]
Instant = Annotated[float, Field(strict=True, ge=0, le=1e9)]  # s

SENSORS = ("gyro", "log", "position")  # of a platform; the other tables belong to a radar

_NOISE_TIME = "its correlation falls to 1/e within this time; 0: independent from spoke to spoke"
_LATENCY = "age of a reading, in whole spokes"


class GyroErrorsModel(Section):
    """Errors of the reported heading. They turn the reported course and azimuth with it."""

    bias_deg: ErrorAngle = Field(0.0, description="added to the heading")
    calibration_deg: SmallAngle = Field(0.0, description="amplitude of an error with the sine of the heading")
    calibration_phase_deg: Bearing = Field(0.0, description="heading at which that error is zero and rises")
    noise_deg: SmallAngle = Field(0.0, description="standard deviation")
    noise_time_s: CorrelationTime = Field(1.0, description=_NOISE_TIME)
    latency_s: Latency = Field(0.0, description=_LATENCY)


class LogErrorsModel(Section):
    """Errors of the reported speed. A speed below 0 is astern."""

    bias_kn: ErrorSpeed = Field(0.0, description="added to the speed")
    scale_percent: Number = Field(0.0, ge=-100, le=100, description="of the speed, added to it")
    least_kn: Number = Field(0.0, ge=0, le=100, description="what scale_percent adds or takes is no less than this")
    noise_kn: Number = Field(0.0, ge=0, le=100, description="standard deviation")
    noise_time_s: CorrelationTime = Field(1.0, description=_NOISE_TIME)
    latency_s: Latency = Field(0.0, description=_LATENCY)


class PositionErrorsModel(Section):
    """Errors of own ship's reported position."""

    bias_m: tuple[ErrorDistance, ErrorDistance] = Field((0.0, 0.0), description="east, north; added to the position")
    noise_m: Number = Field(0.0, ge=0, le=100_000, description="standard deviation of each, east and north")
    noise_time_s: CorrelationTime = Field(60.0, description=_NOISE_TIME)
    latency_s: Latency = Field(0.0, description=_LATENCY)


class AntennaErrorsModel(Section):
    """Errors of the angle from the bow that the antenna's encoder reports."""

    misalignment_deg: ErrorAngle = Field(0.0, description="added to the angle from the bow")
    backlash_deg: SmallAngle = Field(0.0, description="play to each side, taken up by wind from ahead; even over a turn")
    encoder_noise_deg: SmallAngle = Field(0.0, description="standard deviation, independent from spoke to spoke")
    encoder_step_deg: SmallAngle = Field(0.0, description="the angle is rounded to whole steps; 0: not rounded")


class FeedErrorsModel(Section):
    """What happens to spokes between radar and client. Rates are probabilities for each spoke."""

    drop_rate: Probability = Field(0.0, description="the spoke is not sent")
    burst_rate: Probability = Field(0.0, description="from this spoke on burst_spokes are not sent")
    burst_spokes: Whole = Field(10, ge=1, le=4096)
    repeat_rate: Probability = Field(0.0, description="the spoke is sent twice")
    late_rate: Probability = Field(0.0, description="the spoke is sent late_s later, after newer ones")
    late_s: Number = Field(0.5, gt=0, le=MAX_LATENCY_S)
    swap_rate: Probability = Field(0.0, description="the spoke is sent after the next one")
    stuck_sector_deg: tuple[Bearing, Bearing] | None = Field(
        None, description="true bearings clockwise: spokes there keep the echoes of the first scan with this error"
    )
    heading_lost_s: tuple[tuple[Instant, Instant], ...] = Field(
        (), max_length=MAX_PERIODS, description="periods of simulated time, from and to: no heading is reported"
    )
    bytes_per_s: Number | None = Field(None, ge=100, le=1e9, description="that each client's connection carries")
    cut_after_s: Number | None = Field(None, ge=0.1, le=1e6, description="each client's connection is cut at that age")

    def problems(self) -> Iterator[str]:
        for k, (start, end) in enumerate(self.heading_lost_s):
            if end <= start:
                yield f"heading_lost_s[{k}]: {end:g} s is not after {start:g} s; give from and to in this order"


class ProfileSection(Section):
    """A table of errors with a profile."""

    profile: Literal["imo-a823", "imo-2004", "msc116-thd"] | None = Field(
        None, description="values of the keys that are not given"
    )


class RadarErrorsModel(ProfileSection):
    """Errors on purpose of one radar: its antenna and its feed."""

    antenna: AntennaErrorsModel | None = None
    feed: FeedErrorsModel | None = None

    @model_validator(mode="before")
    @classmethod
    def _check_owner(cls, given: Any) -> Any:
        return _without(
            given, SENSORS, "is a sensor of the platform; give it in the errors of own_ship or of the body, or in [errors]"
        )


class PlatformErrorsModel(ProfileSection):
    """Errors on purpose of one platform: its gyro, its log and its position sensor."""

    gyro: GyroErrorsModel | None = None
    log: LogErrorsModel | None = None
    position: PositionErrorsModel | None = None

    @model_validator(mode="before")
    @classmethod
    def _check_owner(cls, given: Any) -> Any:
        return _without(given, ("antenna", "feed"), "belongs to a radar; give it in the errors of the radar, or in [errors]")


class ErrorsModel(ProfileSection):
    """Errors on purpose of all radars and platforms. A table that is not given has no errors."""

    gyro: GyroErrorsModel | None = None
    log: LogErrorsModel | None = None
    position: PositionErrorsModel | None = None
    antenna: AntennaErrorsModel | None = None
    feed: FeedErrorsModel | None = None


def _without(given: Any, others: Iterable[str], reason: str) -> Any:
    """Returns a table as it is. Raises ValueError where it has one of the `others`, which belong elsewhere."""
    for name in others:
        if isinstance(given, Mapping) and name in given:
            raise ValueError(f"{name} {reason}")
    return given
