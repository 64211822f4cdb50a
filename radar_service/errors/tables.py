"""Changes errors on purpose by tables of a scene file, as the simulator and REST take them."""

from collections.abc import Mapping
from typing import Any

from radar_service.scene.error import SceneError
from radar_service.scene.error_profiles import PROFILES
from radar_service.scene.error_settings import ErrorSettings, settings_from_models
from radar_service.scene.errors_model import SENSORS
from radar_service.scene.files.scene_file import validated


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
    kept = {} if present is None else present.as_tables()
    merged = {name: table for name, table in kept.items() if name not in profile} | dict(tables)
    return settings_from_models(validated({"errors": merged}).errors, has_sensors=has_sensors)
