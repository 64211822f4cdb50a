"""What is wrong with a scene, a line per fault: place, value, what is allowed, what to do.

pydantic finds the faults; what is allowed is read from the model's own JSON Schema, so that no range is written twice.
"""

import difflib
import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from radar_service.scene.error import SceneError
from radar_service.scene.model import SceneModel

MAX_PROBLEMS = 20  # shown; more are counted
MAX_DEPTH = 24  # a scene needs six
MAX_VALUES = 5_000_000

Schema = dict[str, Any]


def plain_data(source: Any) -> Any:
    """`source` as dicts with text keys, tuples, scalars; no numpy. SceneError where too deep or large."""
    left = [MAX_VALUES]

    def plain(value: Any, depth: int) -> Any:
        left[0] -= 1
        if depth > MAX_DEPTH:
            raise SceneError(f"scene: nested more than {MAX_DEPTH} deep; a scene needs six levels: flatten it")
        if left[0] < 0:
            raise SceneError(f"scene: more than {MAX_VALUES} values; put large data into mesh or track files")
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        if isinstance(value, Mapping):
            return {str(key)[:200]: plain(item, depth + 1) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return tuple(plain(item, depth + 1) for item in value)
        return value

    return plain(source, 0)


def limited(problems: Iterable[str]) -> SceneError:
    """One error of many lines: the first twenty, and how many more there are."""
    lines = list(problems)
    more = len(lines) - MAX_PROBLEMS
    return SceneError(*lines[:MAX_PROBLEMS], *([f"... and {more} more problems"] if more > 0 else []))


def problems_from_validation(fault: ValidationError) -> list[str]:
    """A line for each thing that is wrong, in the order of the scene."""
    found: dict[tuple[str | int, ...], tuple[ErrorDetails, Schema]] = {}
    for error in fault.errors(include_url=False):
        place, node = _walk(error["loc"])
        known = found.get(place)
        if known is None or _weight(error) > _weight(known[0]):
            found[place] = (error, node)
    inner = {place[:n] for place in found for n in range(len(place))}
    unions = {place for place in found if place in inner and "anyOf" in found[place][1]}
    return [_line(place, *found[place]) for place in found if place not in unions]


def _weight(error: ErrorDetails) -> int:
    """Of several faults of one value (each branch of a union has its own), the range says more than the type."""
    return {"finite_number": 2, "greater_than": 1, "greater_than_equal": 1, "less_than": 1, "less_than_equal": 1}.get(
        error["type"], 0
    )


@cache
def _schema() -> Schema:
    return SceneModel.model_json_schema()


def _resolved(node: Schema) -> Schema:
    while "$ref" in node:
        node = {**_schema()["$defs"][node["$ref"].rsplit("/", 1)[1]], **{k: v for k, v in node.items() if k != "$ref"}}
    options = [option for option in node.get("anyOf", ()) if option.get("type") != "null"]
    if len(options) == 1:
        return _resolved({**{k: v for k, v in node.items() if k != "anyOf"}, **options[0]})
    return {**node, "anyOf": options} if options else node


def _walk(loc: tuple[str | int, ...]) -> tuple[tuple[str | int, ...], Schema]:
    """The place without pydantic's names for branches of unions, and its node of the schema."""
    place: list[str | int] = []
    node = _resolved(_schema())
    for n, step in enumerate(loc):
        if "anyOf" in node:
            if isinstance(step, str):
                continue  # the name of a branch
            node = next((option for option in node["anyOf"] if option.get("type") == "array"), {})
        place.append(step)
        following = _child(node, step)
        if following is None and n < len(loc) - 1:
            return tuple(place), {}
        node = _resolved(following or {})
    return tuple(place), node


def _child(node: Schema, step: str | int) -> Schema | None:
    if isinstance(step, str):
        found: Schema | None = node.get("properties", {}).get(step)
        return found
    prefix = node.get("prefixItems", [])
    return prefix[step] if step < len(prefix) else node.get("items") or None


def place_text(place: tuple[str | int, ...]) -> str:
    """`body[3].position_m[1]` for ("body", 3, "position_m", 1)."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{_shown_key(step)}" for step in place)
    return text.removeprefix(".")


def _shown_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]{1,60}", key) else shown(key)


def shown(value: Any) -> str:
    """A value as a scene file would write it, cut to a readable length."""
    if isinstance(value, str):
        return f'"{value[:60].encode("unicode_escape").decode()}{"..." if len(value) > 60 else ""}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int) and abs(value) >= 10**20:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, Mapping):
        return f"a table of {len(value)} keys"
    if isinstance(value, tuple):
        return f"[{', '.join(map(shown, value))}]" if len(value) <= 4 else f"a list of {len(value)} values"
    return str(value)[:60]


def _line(place: tuple[str | int, ...], error: ErrorDetails, node: Schema) -> str:
    kind, value = error["type"], error["input"]
    where = place_text(place) or "scene"
    if kind == "value_error":
        return _from_validator(place, str(error["ctx"]["error"]), node)
    if kind in ("extra_forbidden", "invalid_key"):
        return _unknown_key(place)
    if kind == "missing":
        return f"{where}: missing; {_allowed(node)}; add it"
    return f"{where}: {shown(value)} is not allowed; {_allowed(node)}; {_remedy(error)}"


def _from_validator(place: tuple[str | int, ...], text: str, node: Schema) -> str:
    """A message of the model's validators, put under the key that it starts with."""
    key = re.match(r"([a-z_]+)(\[\d+\])*(\.[a-z_]+|\[\d+\])*: ", text)
    if key and key[1] in node.get("properties", {}):
        return f"{place_text(place)}.{text}".removeprefix(".")
    return f"{place_text(place) or 'scene'}: {text}"


def _unknown_key(place: tuple[str | int, ...]) -> str:
    node = _walk(place[:-1])[1]
    keys = list(node.get("properties", {}))
    key = str(place[-1])
    near = difflib.get_close_matches(key, keys, n=1)
    remedy = f'did you mean "{near[0]}"?' if near else "remove it"
    return f"{place_text((*place[:-1], key))}: not a known key; {remedy} (allowed: {', '.join(keys)})"


def _allowed(node: Schema) -> str:
    """What a place may hold, in words."""
    if "anyOf" in node:
        return " or ".join(_allowed(_resolved(option)) for option in node["anyOf"])
    if "enum" in node or "const" in node:
        return "one of " + ", ".join(shown(v) for v in node.get("enum", [node.get("const")]))
    kind = node.get("type")
    if kind in ("number", "integer"):
        return f"a {'whole' if kind == 'integer' else 'finite'} number{_range(node)}"
    if kind == "string":
        low, high = node.get("minLength", 0), node.get("maxLength")
        return f"text of {low} to {high} characters" if high else "text"
    if kind == "boolean":
        return "true or false"
    if kind == "array":
        return _allowed_list(node)
    return "a table with the keys " + ", ".join(node["properties"]) if "properties" in node else "a value of another kind"


def _allowed_list(node: Schema) -> str:
    low, high = node.get("minItems"), node.get("maxItems")
    if "prefixItems" in node:
        each = [_allowed(_resolved(item)) for item in node["prefixItems"]]
        inner = f"each {each[0]}" if len(set(each)) == 1 else ", ".join(each)
        return f"a list of {len(each)} values: {inner}"
    count = f" of at most {high} values" if high and not low else ""
    return f"a list{count}, each {_allowed(_resolved(node.get('items', {})))}"


def _range(node: Schema) -> str:
    low, high = node.get("minimum"), node.get("maximum")
    above, below = node.get("exclusiveMinimum"), node.get("exclusiveMaximum")
    bottom = f" from {_plain(low)}" if low is not None else f" above {_plain(above)}" if above is not None else ""
    top = f" to {_plain(high)}" if high is not None else f" below {_plain(below)}" if below is not None else ""
    return bottom + (top.replace(" to ", " up to ") if above is not None else top)


def _plain(number: float) -> str:
    return str(int(number)) if number == int(number) and abs(number) < 1e15 else f"{number:g}"


_REMEDIES = {
    "finite_number": "give a finite number",
    "greater_than": "raise it",
    "greater_than_equal": "raise it",
    "less_than": "lower it",
    "less_than_equal": "lower it",
    "literal_error": "choose one of these",
    "too_long": "shorten it",
    "too_short": "lengthen it",
    "string_too_long": "shorten it",
    "string_too_short": "lengthen it",
    "bool_type": "write true or false without quotes",
}


def _remedy(error: ErrorDetails) -> str:
    if error["type"] in ("float_type", "int_type") and isinstance(error["input"], str):
        return "write the number without quotes"
    return _REMEDIES.get(error["type"], "correct it")
