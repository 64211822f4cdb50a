"""Reads and validates the description of a scene: a TOML or JSON file, a packaged scene or a mapping."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from radar_service.scene_file.folder import FORWARD, read_limited
from radar_service.scene_file.model.scene import SceneModel, scene_model
from radar_service.scene_file.validation_messages import error_from_problems, plain_data, problems_from_validation
from radar_service.strict_json import DuplicateKeyError, parsed
from radar_service.world import SceneError

SceneInput = str | Path | Mapping[str, Any]

MAX_SCENE_BYTES = 10 * 2**20
MAX_BRACKETS = 1_000  # open at once: both parsers recurse
MAX_KEY_PARTS = 200  # of a dotted key: the TOML parser is quadratic in their number
_KEY_SEPARATORS = re.compile(r"[,={}\[\]]")  # a dotted key has none of them; a list has one after each number
PACKAGE = Path(__file__).parents[1]


def packaged_folder(name: str) -> Path:
    """The folder `name`: inside the package when it is installed, beside it in a checkout."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name


def model_and_folder(scene_input: SceneInput, folder: Path | None) -> tuple[SceneModel, Path | None]:
    """Returns the validated model of `scene_input` and the folder of its files. Raises SceneError."""
    if isinstance(scene_input, Mapping):
        return validated(scene_input), Path(folder) if folder is not None else None
    if not isinstance(scene_input, str | Path):
        raise SceneError(
            f"scene: a {type(scene_input).__name__} is not a scene; give the path of a .toml or .json file, or a mapping"
        )
    path = scene_path(scene_input)
    return validated(scene_content(path)), Path(folder) if folder is not None else path.parent


def validated(data: Mapping[str, Any]) -> SceneModel:
    """Returns the model of a mapping. Raises SceneError with one line for each problem."""
    if not data:
        raise SceneError(
            f"scene: it is empty; give it a name, a radar or a body, or load one of {', '.join(packaged_scenes())}"
        )
    try:
        return scene_model().model_validate(plain_data(data))
    except ValidationError as error:
        raise error_from_problems(problems_from_validation(error)) from None


def model_at_range(model: SceneModel, radar_id: str | None, range_m: float | None) -> SceneModel:
    """Returns a scene with another range scale [m] of the radar of this id, the first for None; as it is without a scale.

    Raises SceneError.
    """
    if range_m is None:
        return model
    document: dict[str, Any] = model.model_dump(by_alias=True, exclude_unset=True)
    radar_table(document, radar_id)["range_max_m"] = range_m
    return validated(document)


def radar_table(document: dict[str, Any], radar_id: str | None) -> dict[str, Any]:
    """Returns the table of the radar of this id in the content of a scene, the first for None; an empty one is added to none."""
    radars = document.setdefault("radar", {})
    if isinstance(radars, dict):
        return radars
    table: dict[str, Any] = next(radar for radar in radars if radar_id in (None, radar["id"]))
    return table


def packaged_scenes() -> list[str]:
    """Returns the sorted names of the scenes in the package."""
    return sorted(file.stem for file in packaged_folder("scenes").glob("*.toml"))


def scene_path(name: str | Path) -> Path:
    """Returns the file of a path or of a packaged scene's name. Raises SceneError with the packaged names."""
    if not str(name).strip():
        raise SceneError(f'scene: "" names no scene; give a .toml or .json file, or one of {", ".join(packaged_scenes())}')
    path = Path(name)
    try:
        if path.is_dir():
            raise SceneError(f"{_printable(name)}: this is a folder; name a .toml or .json file in it")
        if path.is_file():
            return path
        packaged = _packaged_path(str(name))
        if packaged is not None and packaged.is_file():
            return packaged
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(
            f"{_printable(name)}: the path cannot be used ({error}); give the path of a .toml or .json file"
        ) from None
    names = ", ".join(packaged_scenes()) or "none"
    raise SceneError(
        f"{_printable(name)}: neither a file nor a packaged scene has this name; packaged scenes are {names}: correct "
        "the path"
    )


def _printable(name: str | Path) -> str:
    return str(name)[:300].encode("unicode_escape").decode()


def _packaged_path(name: str) -> Path | None:
    """Returns the path that a packaged scene of this name has; None if the name contains folders."""
    bare = name.replace("\\", "/").removeprefix("./").removeprefix("scenes/")
    if "/" in bare or bare in ("", ".", ".."):
        return None
    return packaged_folder("scenes") / (bare if bare.endswith((".toml", ".json")) else f"{bare}.toml")


def scene_content(path: Path) -> Mapping[str, Any]:
    """Returns what a scene file holds, not validated. Raises SceneError for a file that is no TOML or JSON."""
    location = _printable(path)
    kind = path.suffix.lower()
    if kind not in (".toml", ".json"):
        raise SceneError(
            f'{location}: the ending "{kind[:20]}" is not known; a scene file ends in .toml or .json: rename it'
        )
    content = read_limited(path, location, MAX_SCENE_BYTES)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{location}: byte {error.start} is not UTF-8; save the file as UTF-8") from None
    _check_depth(text, kind, location)
    try:
        data = tomllib.loads(text) if kind == ".toml" else parsed(text)
    except DuplicateKeyError as error:
        raise SceneError(f"{location}: {error}") from None
    except (ValueError, RecursionError, OverflowError) as error:
        remedy = _backslash_remedy(text, str(error)) or "correct it there"
        raise SceneError(f"{location}: the file is not valid {kind[1:].upper()}: {str(error)[:300]}; {remedy}") from None
    if not isinstance(data, dict):
        raise SceneError(
            f'{location}: the file holds a {type(data).__name__}; a scene is a table of keys, as in {{"name": ...}}'
        )
    return data


def _backslash_remedy(text: str, error: str) -> str:
    """The remedy where an error of a parser is about a line with a backslash; empty otherwise."""
    number = re.search(r"line (\d+)", error)
    line = text.splitlines()[int(number[1]) - 1 :][:1] if number else []
    return f"a backslash begins an escape; {FORWARD}" if line and "\\" in line[0] else ""


def _check_depth(text: str, kind: str, location: str) -> None:
    """Raises SceneError if brackets or dotted keys are nested too deep for the parsers."""
    depth = 0
    for mark in text if text.count("[") + text.count("{") > MAX_BRACKETS else "":
        depth += (mark in "[{") - (mark in "]}")
        if depth > MAX_BRACKETS:
            raise SceneError(
                f"{location}: brackets are nested more than {MAX_BRACKETS} deep; a scene needs six levels: flatten it"
            )
    for line in text.splitlines() if kind == ".toml" else ():
        if line.count(".") > MAX_KEY_PARTS and any(part.count(".") > MAX_KEY_PARTS for part in _KEY_SEPARATORS.split(line)):
            raise SceneError(f"{location}: a key has more than {MAX_KEY_PARTS} parts; a scene needs three: shorten it")
