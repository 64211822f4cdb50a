"""The body of an uploaded scene: JSON, or a form with its files."""

from pathlib import PurePosixPath
from typing import Any, NamedTuple

from fastapi import HTTPException, Request
from pydantic import ValidationError
from starlette.datastructures import UploadFile

from radar_service.scene.error import SceneError
from radar_service.stream.http import schemas
from radar_service.stream.http.answers import problem_lines
from radar_service.stream.http.scene_store import json_bytes

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


class Upload(NamedTuple):
    """A scene as it was sent: its name, its text, the ending of its file name, and its files by name."""

    name: str
    scene: bytes
    kind: str
    files: dict[str, bytes]


async def read_upload(request: Request) -> Upload:
    """Returns the upload of a request. Raises HTTPException or SceneError where it is not one."""
    content_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if content_type == "multipart/form-data":
        return await _read_form(request)
    if content_type != "application/json":
        raise HTTPException(422, [f'content-type: "{content_type[:60]}"; send application/json or multipart/form-data'])
    try:
        body = schemas.SceneUpload.model_validate(await request.json())
    except ValidationError as error:
        raise HTTPException(422, problem_lines(error.errors())) from None
    except (ValueError, RecursionError) as error:
        raise HTTPException(400, [f"body: not JSON: {str(error)[:200]}"]) from None
    return Upload(body.name, json_bytes(body.scene), ".json", {})


async def _read_form(request: Request) -> Upload:
    async with request.form(max_fields=8) as form:
        scene, name = form.get("scene"), form.get("name")
        if not isinstance(scene, UploadFile) or not isinstance(name, str):
            raise SceneError("scene, name: send a scene file (.toml or .json) as `scene` and its name as `name`")
        files: dict[str, bytes] = {}
        for part in form.getlist("files"):
            if not isinstance(part, UploadFile) or not part.filename or part.filename in files:
                raise SceneError("files: each is a file with a name of its own")
            files[part.filename] = await part.read()
        return Upload(name, await scene.read(), PurePosixPath(scene.filename or "").suffix.lower(), files)
