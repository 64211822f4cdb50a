"""The body of an uploaded scene: JSON, or a form with its files."""

import asyncio
import shutil
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

from fastapi import HTTPException, Request
from starlette.datastructures import UploadFile

from radar_service.scene.error import SceneError
from radar_service.stream.http import schemas
from radar_service.stream.http.bodies import SCENE, BodyReader, disk_error
from radar_service.stream.http.scene_store import UploadFolder, checked_file_names, checked_name
from radar_service.stream.source import SceneOrder

UPLOAD_BODY: dict[str, Any] = {
    "required": True,
    "content": {
        "application/json": {
            "schema": schemas.SceneUpload.model_json_schema(),
            "example": {"name": "one buoy", "scene": {"body": [{"name": "buoy", "shape": "sphere", "radius_m": 1,
                                                                "position_m": [500, 0, 2]}]}},
        },
        "multipart/form-data": {
            "schema": {
                "type": "object",
                "required": ["name", "scene"],
                "properties": {
                    "name": {"type": "string"},
                    "scene": {"type": "string", "format": "binary", "description": "a .toml or .json file"},
                    "files": {"type": "array", "items": {"type": "string", "format": "binary"},
                              "description": "meshes, height maps and tracks, named as the scene names them"},
                },
            }
        },
    },
}  # fmt: skip


async def read_upload(request: Request, reader: BodyReader, folder: UploadFolder) -> tuple[str, SceneOrder]:
    """Returns name and order of an uploaded scene, whose files then lie in the folder.

    Raises HTTPException or SceneError where the request holds no scene, and what BodyReader.read raises.
    """
    content_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if content_type == "multipart/form-data":
        return await _read_form(request, folder)
    if content_type != "application/json":
        raise HTTPException(422, [f'content-type: "{content_type[:60]}"; send application/json or multipart/form-data'])
    body = await reader.read(request, schemas.SceneUpload, folder)
    return body.name, folder.order(SCENE)


async def _read_form(request: Request, folder: UploadFolder) -> tuple[str, SceneOrder]:
    try:
        async with request.form(max_fields=8) as form:
            scene, name = form.get("scene"), form.get("name")
            if not isinstance(scene, UploadFile) or not isinstance(name, str):
                raise SceneError("scene, name: send a scene file (.toml or .json) as `scene` and its name as `name`")
            files = _by_name(form.getlist("files"))
            file = f"scene{_ending(scene)}"
            checked_name(name)
            checked_file_names(files, file)
            await asyncio.to_thread(_store, files | {file: scene}, folder)
    except OSError as error:
        raise disk_error(error) from None
    return name, folder.order(file)


def _by_name(parts: Sequence[object]) -> dict[str, UploadFile]:
    files: dict[str, UploadFile] = {}
    for part in parts:
        if not isinstance(part, UploadFile) or not part.filename or part.filename in files:
            raise SceneError("files: each is a file with a name of its own")
        files[part.filename] = part
    return files


def _ending(scene: UploadFile) -> str:
    ending = PurePosixPath(scene.filename or "").suffix.lower()
    if ending not in (".toml", ".json"):
        raise SceneError(f'scene: the ending "{ending[:20]}" is not known; send a .toml or .json file')
    return ending


def _store(files: Mapping[str, UploadFile], folder: UploadFolder) -> None:
    for name, part in files.items():
        with (folder.path / name).open("wb") as file:
            shutil.copyfileobj(part.file, file)
