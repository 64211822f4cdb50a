"""JSON whose tables have each key once; of two values for one key a parser would silently take the last."""

import json
from typing import Any


class DuplicateKeyError(ValueError):
    """A key occurs twice in one table. The text names it."""


def parsed(text: str | bytes) -> Any:
    """Returns the content of JSON. Raises DuplicateKeyError, any other ValueError, and RecursionError where it is too deep."""
    return json.loads(text, object_pairs_hook=unique_keys)


def unique_keys(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    """Returns the table of these keys and values. Raises DuplicateKeyError."""
    table = dict(pairs)
    if len(table) < len(pairs):
        raise DuplicateKeyError(f'the key "{str(_duplicate(pairs))[:60]}" occurs twice in one table; remove one')
    return table


def _duplicate(pairs: list[tuple[Any, Any]]) -> Any:
    """The first key that occurs a second time."""
    known = set()
    for key, _ in pairs:
        if key in known:
            return key
        known.add(key)
    raise AssertionError("each key occurs once")
