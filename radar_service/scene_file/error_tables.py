"""Errors on purpose between the tables of a scene file and SI units: profiles, the nearest table first, changes by tables."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from radar_service.scene_file.document import validated
from radar_service.scene_file.model.errors import (
    SENSORS,
    AntennaErrorsModel,
    FeedErrorsModel,
    GyroErrorsModel,
    LogErrorsModel,
    PositionErrorsModel,
    ProfileSection,
)
from radar_service.stages.fields import SCALES, Section, bare, record_of, scaled, unit_of
from radar_service.world import (
    AntennaErrors,
    ErrorSettings,
    FeedErrors,
    GyroErrors,
    LogErrors,
    PositionErrors,
    SceneError,
)

SIGNED = ("bias_deg", "bias_kn", "scale_percent")  # keys of errors that are as likely above 0 as below
DIGITS = 12  # of a value in the units of a scene file: 0.5 degrees there and back is 0.5

TABLES: dict[str, tuple[type[Section], Any]] = {
    "gyro": (GyroErrorsModel, GyroErrors), "log": (LogErrorsModel, LogErrors),
    "position": (PositionErrorsModel, PositionErrors), "antenna": (AntennaErrorsModel, AntennaErrors),
    "feed": (FeedErrorsModel, FeedErrors),
}  # fmt: skip

# imo-a823: IMO resolution A.823(19), appendix 3, "Sensor errors". Of the gyro compass: calibration error 0.5 degrees, normal
# distribution about this with sigma = 0.12 degrees. Of the log: calibration error 0.5 knots, normal distribution about this with
# 3 sigma = 0.2 knots. Of the antenna: backlash rectangular, +-0.05 degrees at most; bearing quantisation rectangular, +-0.1
# degrees at most; encoder normal, sigma = 0.03 degrees. It has no position and no correlation times: those are the defaults.
# What it says of targets, of roll and pitch, and of beam and pulse comes from the scene: the engine computes these.
# imo-2004: the sensors that carriage rules ask for since, in place of these. Of the log: 0.2 knots or 2 % of the speed, whichever
# is more (MSC.96(72)). Of the position: 13 m in 95 % (MSC.112(73)), normal east and north, so that the distance is Rayleigh's.
# msc116-thd: the same with the least heading device that is allowed, MSC.116(73), recalled: static error 1 degree, dynamic error
# 1.5 degrees, here three standard deviations, of periods of 30 s and more.
_ANTENNA = {"backlash_deg": 0.05, "encoder_step_deg": 0.2, "encoder_noise_deg": 0.03}
_LOG_2004 = {"scale_percent": 2.0, "least_kn": 0.2}
_POSITION_2004 = {"noise_m": 13.0 / math.sqrt(-2.0 * math.log(0.05))}
PROFILES: dict[str, dict[str, dict[str, Any]]] = {
    "imo-a823": {
        "gyro": {"bias_deg": 0.5, "noise_deg": 0.12},
        "log": {"bias_kn": 0.5, "noise_kn": 0.2 / 3.0},
        "antenna": _ANTENNA,
    },
    "imo-2004": {
        "gyro": {"bias_deg": 0.5, "noise_deg": 0.12}, "log": _LOG_2004, "position": _POSITION_2004, "antenna": _ANTENNA,
    },
    "msc116-thd": {
        "gyro": {"bias_deg": 1.0, "noise_deg": 0.5, "noise_time_s": 30.0}, "log": _LOG_2004, "position": _POSITION_2004,
        "antenna": _ANTENNA,
    },
}  # fmt: skip


def settings_from_models(*models: ProfileSection | None, has_sensors: bool = True) -> ErrorSettings | None:
    """Returns the errors of one radar; None where it has none. A table of defaults has no errors.

    models: tables of errors of a scene file, where a key of a later one goes before that of an earlier one. has_sensors: whether
    the platform has sensors; errors of sensors that it lacks are left out.
    """
    settings = dict[str, Any]()
    for name, (kind, record) in TABLES.items():
        if name in SENSORS and not has_sensors:
            continue
        keys = {key: value for model in models if model is not None for key, value in _keys(model, name).items()}
        if (table := kind(**keys)) != kind():
            settings[name] = record_of(record, table)
    return ErrorSettings(**settings) if settings else None


def error_tables(settings: ErrorSettings) -> dict[str, dict[str, Any] | None]:
    """Returns the tables as a scene file has them, in its units, with all keys; None where a part has no errors."""
    return {name: _table(kind, getattr(settings, name)) for name, (kind, _) in TABLES.items()}


def changed_errors(
    present: ErrorSettings | None, tables: Mapping[str, Any] | None, has_sensors: bool = True
) -> ErrorSettings | None:
    """Returns errors with some tables changed; None where none are left.

    tables: those of `[errors]` in a scene file. A table replaces the present one whole; None and a table without keys switch it
    off; a profile replaces the tables that it has. None instead of tables switches all off. has_sensors: whether the platform
    has gyro, log and position sensor; otherwise a profile's are left out. Raises SceneError, also for errors of sensors that
    are not there.
    """
    if tables is None:
        return None
    given = validated({"errors": tables}).errors
    wrong = () if has_sensors else tuple(name for name in SENSORS if tables.get(name))
    if wrong:
        raise SceneError(
            f"errors.{wrong[0]}: a fixed site has no gyro, log or position sensor; remove {', '.join(wrong)}, "
            "or turn the picture by antenna.misalignment_deg"
        )
    profile = PROFILES[given.profile] if given and given.profile else {}
    kept = {} if present is None else error_tables(present)
    merged = {name: table for name, table in kept.items() if name not in profile} | dict(tables)
    return settings_from_models(validated({"errors": merged}).errors, has_sensors=has_sensors)


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
    return {
        key: _rounded(scaled(getattr(record, bare(key)), 1.0 / SCALES.get(unit_of(key), 1.0))) for key in kind.model_fields
    }


def _rounded(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_rounded(item) for item in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def drawn_biases(errors: Mapping[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """Returns tables of errors of a scene file whose biases have signs, and whose calibration and position have directions, that
    are drawn: those of a profile or of a table are of one ship among many."""
    profile = PROFILES[errors["profile"]] if errors.get("profile") else {}
    drawn = dict(errors)
    signs = rng.choice((-1.0, 1.0), 2)
    turns = rng.uniform(0.0, 360.0, 2)
    for name, sign in zip(("gyro", "log"), signs.tolist(), strict=True):
        table = dict(profile.get(name, {})) | dict(errors.get(name, {}))
        drawn |= {name: {key: sign * value if key in SIGNED else value for key, value in table.items()}} if table else {}
    if "calibration_deg" in drawn.get("gyro", {}):
        drawn["gyro"]["calibration_phase_deg"] = float(turns[0])
    bias = errors.get("position", {}).get("bias_m")
    if bias:
        length, angle = math.hypot(*bias), math.radians(turns[1])
        drawn["position"] = {**errors["position"], "bias_m": [length * math.sin(angle), length * math.cos(angle)]}
    return drawn
