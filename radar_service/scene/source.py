"""Where a scene comes from: a TOML or JSON file, a packaged scene by name, or a mapping; read and checked, not yet built."""

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from radar_service.packaged import packaged_folder
from radar_service.scene.error import SceneError
from radar_service.scene.faults import limited, plain_data, problems_from_validation
from radar_service.scene.files import read_limited
from radar_service.scene.model import SceneModel

Source = str | Path | Mapping[str, Any]

MAX_SCENE_BYTES = 10 * 2**20
MAX_BRACKETS = 1_000  # open at once; both parsers recurse, and TOML's is quadratic in the depth of a dotted key
_BETWEEN_KEYS = re.compile(r"[,={}\[\]]")  # a dotted key holds none of them, a list of numbers one after each number
MAX_KEY_PARTS = 200


def model_and_folder(source: Source, folder: Path | None) -> tuple[SceneModel, Path | None]:
    """The checked model of `source`, and the folder that its files stand in. Raises SceneError."""
    if isinstance(source, Mapping):
        return validated(source), Path(folder) if folder is not None else None
    if not isinstance(source, str | Path):
        raise SceneError(
            f"scene: a {type(source).__name__} is not a scene; give the path of a .toml or .json file, or a mapping"
        )
    path = scene_path(source)
    return validated(_parsed(path)), Path(folder) if folder is not None else path.parent


def validated(data: Mapping[str, Any]) -> SceneModel:
    """The model of plain data. Raises SceneError with a line per fault."""
    try:
        return SceneModel.model_validate(plain_data(data))
    except ValidationError as fault:
        raise limited(problems_from_validation(fault)) from None


def packaged_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(file.stem for file in packaged_folder("scenes").glob("*.toml"))


def scene_path(source: str | Path) -> Path:
    """The file that a path or the name of a packaged scene means. Raises SceneError listing the packaged ones."""
    path = Path(source)
    try:
        if path.is_dir():
            raise SceneError(f"{_shown(source)}: is a folder; name a .toml or .json file in it")
        if path.is_file():
            return path
        packaged = _packaged_path(str(source))
        if packaged is not None and packaged.is_file():
            return packaged
    except (OSError, ValueError) as fault:
        if isinstance(fault, SceneError):
            raise
        raise SceneError(f"{_shown(source)}: not a usable path ({fault}); give the path of a .toml or .json file") from None
    listed = ", ".join(packaged_scenes()) or "none"
    raise SceneError(
        f"{_shown(source)}: there is no such file, and no packaged scene of that name ({listed}); correct the path"
    )


def _shown(source: str | Path) -> str:
    return str(source)[:300].encode("unicode_escape").decode()


def _packaged_path(name: str) -> Path | None:
    """Where a packaged scene of that bare name would stand; None for anything with folders in it."""
    bare = name.replace("\\", "/").removeprefix("./").removeprefix("scenes/")
    if "/" in bare or bare in ("", ".", ".."):
        return None
    return packaged_folder("scenes") / (bare if bare.endswith((".toml", ".json")) else f"{bare}.toml")


def _parsed(path: Path) -> Mapping[str, Any]:
    place = _shown(path)
    kind = path.suffix.lower()
    if kind not in (".toml", ".json"):
        raise SceneError(f'{place}: the ending "{kind[:20]}" is not known; a scene file ends in .toml or .json: rename it')
    content = read_limited(path, place, MAX_SCENE_BYTES)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise SceneError(f"{place}: byte {fault.start} is not UTF-8; save the file as UTF-8") from None
    _check_depth(text, kind, place)
    try:
        data = tomllib.loads(text) if kind == ".toml" else json.loads(text, object_pairs_hook=_unique_keys)
    except SceneError as fault:
        raise SceneError(f"{place}: {fault}") from None
    except (ValueError, RecursionError, OverflowError) as fault:
        raise SceneError(f"{place}: not valid {kind[1:].upper()}: {str(fault)[:300]}; correct the file there") from None
    if not isinstance(data, dict):
        raise SceneError(f'{place}: holds a {type(data).__name__}; a scene is a table of keys, as in {{"name": ...}}')
    return data


def _unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        double = next(name for name in names if names.count(name) > 1)
        raise SceneError(f'the key "{double[:60]}" stands twice in one table; remove one')
    return table


def _check_depth(text: str, kind: str, place: str) -> None:
    """Raises SceneError where brackets or dotted keys nest so deep that a parser would take for ever or fall over."""
    depth = 0
    for mark in text if len(text) < 100_000 or text.count("[") + text.count("{") > 0 else "":
        depth += (mark in "[{") - (mark in "]}")
        if depth > MAX_BRACKETS:
            raise SceneError(f"{place}: brackets nested more than {MAX_BRACKETS} deep; a scene needs six levels: flatten it")
    for line in text.splitlines() if kind == ".toml" else ():
        if line.count(".") > MAX_KEY_PARTS and any(part.count(".") > MAX_KEY_PARTS for part in _BETWEEN_KEYS.split(line)):
            raise SceneError(f"{place}: a key of more than {MAX_KEY_PARTS} parts; a scene needs three: flatten it")
