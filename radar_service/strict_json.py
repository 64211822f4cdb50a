"""JSON whose tables have each key once; of two values for one key a parser would silently take the last."""

import json
from collections import Counter
from collections.abc import Mapping
from typing import Any


class DuplicateKeyError(ValueError):
    """A key occurs twice in one table. The text names it."""


def parsed(text: str | bytes) -> Any:
    """Returns the content of JSON. Raises DuplicateKeyError, any other ValueError, and RecursionError where it is too deep."""
    return json.loads(text, object_pairs_hook=unique_keys)


def tupled(table: Mapping[str, Any]) -> dict[str, Any]:
    """Returns a table for a record, whose lists are tuples."""
    return {key: tuple(value) if isinstance(value, list) else value for key, value in table.items()}


def unique_keys(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    """Returns the table of these keys and values. Raises DuplicateKeyError."""
    table = dict(pairs)
    if len(table) < len(pairs):
        twice = next(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        raise DuplicateKeyError(f'the key "{str(twice)[:60]}" occurs twice in one table; remove one')
    return table
