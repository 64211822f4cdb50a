"""Puts values into the content of a scene file by keys with dots, as `body.ferry.speed_kn`."""

from typing import Any

from radar_service.world import SceneError

EVERY = "*"  # each table of a list
NAMES = ("name", "id")  # by which a table of a list is found: bodies have names, radars have ids


def put(content: dict[str, Any], key: str, value: Any, location: str) -> None:
    """Puts a value where a key with dots says, and makes tables that are absent on the way.

    content: is changed. key: of a list of tables it has the name of one, or EVERY; of other lists the number of a value,
    from 0. location: that an error begins with. Raises SceneError.
    """
    *path, last = key.split(".")
    tables: list[Any] = [content]
    for step in path:
        tables = [below for table in tables for below in _below(table, step, location)]
    for table in tables:
        if isinstance(table, dict):
            table[last] = value
        elif _is_row(table):
            table[_position(table, last, location)] = value
        else:
            raise SceneError(
                f"{location}: {last!r} is a key of each table of a list; write the name of one, or {EVERY}, before it"
            )


def _below(table: Any, step: str, location: str) -> list[Any]:
    """What a step of a key leads to: of a list the tables of this name; of a table its key, which is made where it is absent."""
    if isinstance(table, list):
        if _is_row(table):
            return [_container(table[_position(table, step, location)], step, location)]
        named = [entry for entry in table if step == EVERY or step in (entry.get(name) for name in NAMES)]
        if not named:
            there = ", ".join(str(entry.get("name", entry.get("id"))) for entry in table)
            raise SceneError(f"{location}: there is no {step!r}; there are {there}, or write {EVERY} for each")
        return named
    if table.get(step) is None:
        table[step] = {}
    return [_container(table[step], step, location)]


def _container(value: Any, step: str, location: str) -> Any:
    if not isinstance(value, dict | list):
        raise SceneError(f"{location}: {step!r} is no table; correct the key")
    return value


def _is_row(table: Any) -> bool:
    """Whether a list is one of values, as a position; a list of tables is none."""
    return isinstance(table, list) and bool(table) and not all(isinstance(entry, dict) for entry in table)


def _position(row: list[Any], step: str, location: str) -> int:
    """The position in a list of values that a step names."""
    if not (step.isascii() and step.isdigit() and int(step) < len(row)):
        raise SceneError(f"{location}: {step!r} is no number of a list of {len(row)} values; give 0 to {len(row) - 1}")
    return int(step)
