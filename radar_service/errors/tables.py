"""Changes errors on purpose by tables of a scene file, as the simulator and REST take them."""

from collections.abc import Mapping
from typing import Any

from radar_service.scene.error_profiles import PROFILES
from radar_service.scene.error_settings import ErrorSettings, settings_from_model
from radar_service.scene.files.scene_file import validated


def changed_errors(present: ErrorSettings | None, tables: Mapping[str, Any] | None) -> ErrorSettings | None:
    """Returns errors with some tables changed; None where none are left.

    tables: those of `[errors]` in a scene file. A table replaces the present one whole; None and a table without keys switch it
    off; a profile replaces the tables that it has. None instead of tables switches all off. Raises SceneError.
    """
    if tables is None:
        return None
    given = validated({"errors": tables}).errors
    profile = PROFILES[given.profile] if given and given.profile else {}
    kept = {} if present is None else present.as_tables()
    merged = {name: table for name, table in kept.items() if name not in profile} | dict(tables)
    return settings_from_model(validated({"errors": merged}).errors)
