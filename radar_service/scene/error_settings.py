"""Errors on purpose in SI units and radians; see `errors_model` for each value."""

import math
from dataclasses import dataclass
from typing import Any

from radar_service.numerics.constants import KNOT
from radar_service.scene.error_profiles import PROFILES
from radar_service.scene.errors_model import (
    SENSORS,
    AntennaErrorsModel,
    FeedErrorsModel,
    GyroErrorsModel,
    LogErrorsModel,
    PositionErrorsModel,
    ProfileSection,
)
from radar_service.scene.fields import Section

SCALES = {"_deg": math.pi / 180.0, "_kn": KNOT, "_percent": 0.01, "_m": 1.0, "_s": 1.0, "_per_s": 1.0}
DIGITS = 12  # of a value in the units of a scene file: 0.5 degrees there and back is 0.5


@dataclass(frozen=True)
class GyroErrors:
    """Errors of the reported heading."""

    bias: float
    calibration: float
    calibration_phase: float
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class LogErrors:
    """Errors of the reported speed. scale: share of the speed."""

    bias: float
    scale: float
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class PositionErrors:
    """Errors of the reported position. bias: east, north."""

    bias: tuple[float, float]
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class AntennaErrors:
    """Errors of the reported angle from the bow."""

    misalignment: float
    backlash: float
    encoder_noise: float
    encoder_step: float


@dataclass(frozen=True)
class FeedErrors:
    """What happens to spokes between radar and client. bytes: per second; cut_after: age of a connection [s]."""

    drop_rate: float
    burst_rate: float
    burst_spokes: int
    repeat_rate: float
    late_rate: float
    late: float
    swap_rate: float
    stuck_sector: tuple[float, float] | None
    heading_lost: tuple[tuple[float, float], ...]
    bytes: float | None
    cut_after: float | None


@dataclass(frozen=True)
class ErrorSettings:
    """The errors in force; None where a part has none."""

    gyro: GyroErrors | None = None
    log: LogErrors | None = None
    position: PositionErrors | None = None
    antenna: AntennaErrors | None = None
    feed: FeedErrors | None = None

    def as_tables(self) -> dict[str, dict[str, Any] | None]:
        """The tables as a scene file has them, in its units, with all keys."""
        return {name: _table(kind, getattr(self, name)) for name, (kind, _) in TABLES.items()}


TABLES: dict[str, tuple[type[Section], Any]] = {
    "gyro": (GyroErrorsModel, GyroErrors), "log": (LogErrorsModel, LogErrors),
    "position": (PositionErrorsModel, PositionErrors), "antenna": (AntennaErrorsModel, AntennaErrors),
    "feed": (FeedErrorsModel, FeedErrors),
}  # fmt: skip


def settings_from_models(*models: ProfileSection | None, has_sensors: bool = True) -> ErrorSettings | None:
    """Returns the errors of one radar; None where it has none. A table of defaults has no errors.

    models: tables of errors of a scene file, where a key of a later one goes before that of an earlier one. has_sensors: whether
    the platform has sensors; errors of sensors that it lacks are left out.
    """
    made = dict[str, Any]()
    for name, (kind, record) in TABLES.items():
        if name in SENSORS and not has_sensors:
            continue
        keys = {key: value for model in models if model is not None for key, value in _keys(model, name).items()}
        table = dict(kind(**keys))
        if table != dict(kind()):
            made[name] = record(**{_bare(key): _scaled(value, _scale(key)) for key, value in table.items()})
    return ErrorSettings(**made) if made else None


def _keys(model: ProfileSection, name: str) -> dict[str, Any]:
    """The keys that one of the tables of errors gives, by itself or by its profile, if it may have a table of that name."""
    if name not in type(model).model_fields:
        return {}
    profile, given = PROFILES[model.profile] if model.profile else {}, getattr(model, name)
    return profile.get(name, {}) | ({} if given is None else given.model_dump(exclude_unset=True))


def _table(kind: type[Section], record: Any) -> dict[str, Any] | None:
    """The table of a record, in the units of a scene file; None without a record."""
    if record is None:
        return None
    return {key: _rounded(_scaled(getattr(record, _bare(key)), 1.0 / _scale(key))) for key in kind.model_fields}


def _suffix(key: str) -> str:
    """The unit at the end of a key; "" for none."""
    return max((ending for ending in SCALES if key.endswith(ending)), key=len, default="")


def _bare(key: str) -> str:
    return key.removesuffix(_suffix(key))


def _scale(key: str) -> float:
    return SCALES.get(_suffix(key), 1.0)


def _scaled(value: Any, scale: float) -> Any:
    """A number, or numbers in tuples, times `scale`; whole numbers and None stay."""
    if isinstance(value, tuple):
        return tuple(_scaled(item, scale) for item in value)
    return value * scale if isinstance(value, float) else value


def _rounded(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_rounded(item) for item in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
