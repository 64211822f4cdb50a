"""Turns validation errors into messages of one line each: key path, value, allowed range, remedy.

pydantic finds the errors. The allowed ranges come from the JSON Schema of the model, so they are written once.
"""

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from radar_service.scene_file.model.scene import scene_schema
from radar_service.world import SceneError

MAX_PROBLEMS = 20  # in one message; the rest is counted
MAX_KEYS = 3  # that a message names; docs/scenes.md has all
MAX_DEPTH = 24  # of nested tables and lists; a scene needs six
MAX_VALUES = 5_000_000
FORMS = {"list": "array", "table": "object", "flag": "boolean"}  # of a key with several forms: their names, types of JSON

Schema = dict[str, Any]


def plain_data(value: Any) -> Any:
    """Returns `value` as dicts with text keys, tuples and scalars, without numpy types. Raises SceneError if too large."""
    remaining = [MAX_VALUES]

    def plain(value: Any, depth: int) -> Any:
        remaining[0] -= 1
        if depth > MAX_DEPTH:
            raise SceneError(f"scene: values are nested more than {MAX_DEPTH} deep; a scene needs six levels: flatten it")
        if remaining[0] < 0:
            raise SceneError(
                f"scene: more than {MAX_VALUES} values are not allowed; put large data into mesh or track files"
            )
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        if isinstance(value, Mapping):
            return {str(key)[:200]: plain(item, depth + 1) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return tuple(plain(item, depth + 1) for item in value)
        return value

    return plain(value, 0)


def error_from_problems(problems: Iterable[str]) -> SceneError:
    """Returns one error with a line for each of the first twenty problems, and the number of the rest."""
    lines = list(problems)
    more = len(lines) - MAX_PROBLEMS
    return SceneError(*lines[:MAX_PROBLEMS], *([f"... and {more} more problems"] if more > 0 else []))


def problems_from_validation(validation_error: ValidationError) -> list[str]:
    """Returns one line for each problem, in the order of the scene."""
    errors: dict[tuple[str | int, ...], tuple[ErrorDetails, Schema]] = {}
    for error in validation_error.errors(include_url=False):
        location, node = _walk(error["loc"])
        known = errors.get(location)
        if known is None or _specificity(error) > _specificity(known[0]):
            errors[location] = (error, node)
    inner = {location[:n] for location in errors for n in range(len(location))}
    unions = {location for location in errors if location in inner and "anyOf" in errors[location][1]}
    return [_message(location, *errors[location]) for location in errors if location not in unions]


def _specificity(error: ErrorDetails) -> int:
    """Ranks the errors of one value, one for each branch of a union: a range error is more specific than a type error."""
    return {"finite_number": 2, "greater_than": 1, "greater_than_equal": 1, "less_than": 1, "less_than_equal": 1}.get(
        error["type"], 0
    )


def _resolved(node: Schema) -> Schema:
    while "$ref" in node:
        node = {**scene_schema()["$defs"][node["$ref"].rsplit("/", 1)[1]], **{k: v for k, v in node.items() if k != "$ref"}}
    options = [option for option in node.get("anyOf", ()) if option.get("type") != "null"]
    if len(options) == 1:
        return _resolved({**{k: v for k, v in node.items() if k != "anyOf"}, **options[0]})
    if len(options) > 1 and all("properties" in _resolved(option) for option in options):
        return _joined([_resolved(option) for option in options])
    return {**node, "anyOf": options} if options else node


def _joined(tables: list[Schema]) -> Schema:
    """Returns one table with the keys of all: of bodies, whatever their kind. A key of several has the node that is not null."""
    properties: Schema = {}
    shared = set.intersection(*({*table.get("required", ())} for table in tables))
    for table in tables:
        kind = next(iter({*table.get("required", ())} - shared), "another kind")
        nodes = {key: {**node, "kind": kind} for key, node in table["properties"].items() if node != {"type": "null"}}
        properties |= nodes
    return {**tables[0], "properties": properties}


def _walk(loc: tuple[str | int, ...]) -> tuple[tuple[str | int, ...], Schema]:
    """Returns the location without pydantic's names for branches of unions, and its node of the schema."""
    location: list[str | int] = []
    node = _resolved(scene_schema())
    for n, step in enumerate(loc):
        if "oneOf" in node:
            node = _form(node, "array" if isinstance(step, int) else FORMS.get(step, "object"))
            if step in FORMS:
                continue  # the name of the form
        if "anyOf" in node:
            if isinstance(step, str):
                continue  # the name of a branch
            node = next((option for option in node["anyOf"] if option.get("type") == "array"), {})
        location.append(step)
        following = _child(node, step)
        if following is None and n < len(loc) - 1:
            return tuple(location), {}
        node = _resolved(following or {})
    return tuple(location), node


def _form(node: Schema, kind: str) -> Schema:
    """Returns that form of a node with several which has a type of JSON, and any other node as it is."""
    forms = (_resolved(option) for option in node.get("oneOf", ()))
    return next((form for form in forms if form.get("type") == kind), node)


def _child(node: Schema, step: str | int) -> Schema | None:
    if isinstance(step, str):
        child: Schema | None = node.get("properties", {}).get(step)
        return child
    prefix = node.get("prefixItems", [])
    return prefix[step] if step < len(prefix) else node.get("items") or None


def location_text(location: tuple[str | int, ...]) -> str:
    """Returns `body[3].position_m[1]` for ("body", 3, "position_m", 1)."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{_key_text(step)}" for step in location)
    return text.removeprefix(".")


def _key_text(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]{1,60}", key) else value_text(key)


def value_text(value: Any) -> str:
    """Returns a value as a scene file writes it, shortened."""
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
        return f"[{', '.join(map(value_text, value))}]" if len(value) <= 4 else f"a list of {len(value)} values"
    return str(value)[:60]


def _message(location: tuple[str | int, ...], error: ErrorDetails, node: Schema) -> str:
    kind, value = error["type"], error["input"]
    path = location_text(location) or "scene"
    if kind == "value_error":
        return _from_validator(location, str(error["ctx"]["error"]), node)
    if kind in ("extra_forbidden", "invalid_key"):
        return _unknown_key(location)
    if kind == "missing":
        return f"{path}: missing; {_allowed(node)}; add it"
    return f"{path}: {value_text(value)} is not allowed; {_allowed(node)}; {_remedy(error)}"


def _from_validator(location: tuple[str | int, ...], text: str, node: Schema) -> str:
    """Returns a message of the model's validators, with the key at its start joined to the location."""
    key = re.match(r"([a-z_]+)(\[\d+\])*(\.[a-z_]+|\[\d+\])*: ", text)
    if key and key[1] in node.get("properties", {}):
        return f"{location_text(location)}.{text}".removeprefix(".")
    return f"{location_text(location) or 'scene'}: {text}"


def _unknown_key(location: tuple[str | int, ...]) -> str:
    node = _form(_walk(location[:-1])[1], "object")
    keys = list(node.get("properties", {}))
    key = str(location[-1])
    if key in keys:
        return f"{location_text(location)}: this key needs a body with {node['properties'][key]['kind']}; remove it"
    nearest = difflib.get_close_matches(key, keys, n=MAX_KEYS, cutoff=0.0)
    takes_effects = [step for step in location[:-1] if isinstance(step, str)] in ([], ["environment"], ["radar"], ["body"])
    remove = f"remove it{', or install the package of the effect that has it' if takes_effects else ''}"
    remedy = f'did you mean "{nearest[0]}"?' if difflib.get_close_matches(key, keys) else remove
    shown = f"nearest of {len(keys)} keys" if len(keys) > MAX_KEYS else "allowed"
    return f"{location_text((*location[:-1], key))}: this is not a known key; {remedy} ({shown}: {', '.join(nearest)})"


def _allowed(node: Schema) -> str:
    """Returns in words which values a node of the schema allows."""
    if "anyOf" in node:
        return " or ".join(_allowed(_resolved(option)) for option in node["anyOf"])
    if "enum" in node or "const" in node:
        return "one of " + ", ".join(value_text(v) for v in node.get("enum", [node.get("const")]))
    kind = node.get("type")
    if kind in ("number", "integer"):
        return f"a {'whole' if kind == 'integer' else 'finite'} number{_range(node)}"
    if kind == "string":
        low, high = node.get("minLength", 0), node.get("maxLength")
        which = f": {node['description']}" if "pattern" in node and "description" in node else ""
        return f"text of {low} to {high} characters{which}" if high else "text"
    if kind == "boolean":
        return "true or false"
    if kind == "array":
        return _allowed_list(node)
    return _allowed_table(list(node["properties"])) if "properties" in node else "a value of another type"


def _allowed_table(keys: list[str]) -> str:
    more = f" and {len(keys) - MAX_KEYS} more" if len(keys) > MAX_KEYS else ""
    return f"a table with the keys {', '.join(keys[:MAX_KEYS])}{more}"


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
    bottom = (
        f" from {_number_text(low)}" if low is not None else f" above {_number_text(above)}" if above is not None else ""
    )
    top = f" to {_number_text(high)}" if high is not None else f" below {_number_text(below)}" if below is not None else ""
    return bottom + (top.replace(" to ", " up to ") if above is not None else top)


def _number_text(number: float) -> str:
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
