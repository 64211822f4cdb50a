"""REST: the scenes of the server, and the bodies of uploads: JSON, or a form with its files."""

import asyncio
import contextlib
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, BinaryIO

from fastapi import APIRouter, HTTPException, Query, Request
from starlette.datastructures import UploadFile
from starlette.formparsers import MultiPartException
from starlette.types import Message

from radar_service.ports.rest import schemas
from radar_service.ports.rest.answers import BUSY, CONFLICT, REFUSED, STORED, UNKNOWN, UNREADABLE, api_router
from radar_service.ports.rest.bodies import BODY, SCENE, BodyReader, Parsed
from radar_service.ports.rest.scene_store import SceneStore, UploadFolder, checked_file_names, checked_name, without_folder
from radar_service.ports.roles import needs
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest
from radar_service.world import SceneError

PIECE = 2**16  # bytes of a form that are read at a time

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
JobName = Annotated[
    str | None, Query(alias="job", pattern=r"^[A-Za-z0-9_-]{1,64}$", description="a name for it in /api/jobs")
]


async def read_upload(request: Request, reader: BodyReader, folder: UploadFolder) -> tuple[str, SceneRequest]:
    """Returns name and order of an uploaded scene, whose files then lie in the folder.

    Raises HTTPException or SceneError where the request holds no scene, and what BodyReader.read raises.
    """
    content_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if content_type == "multipart/form-data":
        fields = await reader.fields(request, folder, read_form, request.headers["content-type"])
        return fields["name"], folder.scene_request(fields["file"])
    if content_type != "application/json":
        raise HTTPException(422, [f'content-type: "{content_type[:60]}"; send application/json or multipart/form-data'])
    body = await reader.read(request, schemas.SceneUpload, folder)
    return body.name, folder.scene_request(SCENE)


def read_form(path: Path, content_type: str) -> Parsed:
    """Returns `name` and `file` of a form in a file, whose own files then lie beside it; or status and lines.

    content_type: that of the request. Raises SceneError.
    """
    try:
        return asyncio.run(_form_fields(path, content_type)), None
    except MultiPartException as error:
        return {}, (400, [f"body: {error.message}"])


async def _form_fields(path: Path, content_type: str) -> dict[str, Any]:
    with path.open("rb") as file:
        async with _request(file, content_type).form(max_fields=8) as form:
            scene, name = form.get("scene"), form.get("name")
            if not isinstance(scene, UploadFile) or not isinstance(name, str):
                raise SceneError("scene, name: send a scene file (.toml or .json) as `scene` and its name as `name`")
            files = _by_name(form.getlist("files"))
            scene_file = f"scene{_ending(scene)}"
            checked_name(name)
            checked_file_names(files, scene_file, BODY)
            for file_name, part in (files | {scene_file: scene}).items():
                with (path.parent / file_name).open("wb") as copy:
                    shutil.copyfileobj(part.file, copy)
    return {"name": name, "file": scene_file}


def _request(file: BinaryIO, content_type: str) -> Request:
    """Returns a request whose body is a file."""

    async def receive() -> Message:
        piece = file.read(PIECE)
        return {"type": "http.request", "body": piece, "more_body": bool(piece)}

    return Request({"type": "http", "headers": [(b"content-type", content_type.encode("latin-1"))]}, receive)


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


def scene_routes(stations: Mapping[str, Station], store: SceneStore, reader: BodyReader) -> APIRouter:
    """Returns the routes under /scenes."""
    router = api_router("scenes")

    @router.get("/scenes")
    @needs("read")
    async def list_scenes() -> list[schemas.SceneListing]:
        """Returns the scenes that can be run by name."""
        summaries = await asyncio.to_thread(lambda: [entry.summary() for entry in store.entries()])
        return [schemas.SceneListing.model_validate(summary) for summary in summaries]

    @router.post(
        "/scenes", status_code=201, responses={**REFUSED, **CONFLICT, **UNREADABLE, **STORED, **BUSY},
        openapi_extra={"requestBody": UPLOAD_BODY},
    )  # fmt: skip
    @needs("command")
    async def add_scene(request: Request, job: JobName = None) -> schemas.SceneAnswer:
        """Keeps a scene, checked and planned for the first radar; it replaces an earlier upload of the same name."""
        first = next(iter(stations.values()))
        with store.receiving() as folder:
            name, scene_request = await read_upload(request, reader, folder)
        store.check_room(name)
        with without_folder(scene_request):
            spoke_source = await first.prepare(scene_request, job)
        scene = spoke_source.info.scene
        first.preparations.keep(spoke_source)  # a radar is likely to run it next
        store.add(name, scene_request, scene)
        warnings = [*scene.warnings, *scene.notes]
        plan, radars = dict(spoke_source.info.plan), list(scene.radar_ids)
        return schemas.SceneAnswer(name=name, bodies=scene.body_count, warnings=warnings, plan=plan, radars=radars)

    @router.delete("/scenes/{name}", status_code=204, responses={**UNKNOWN, **CONFLICT})
    @needs("command")
    async def delete_scene(name: str) -> None:
        """Deletes an uploaded scene; radars that run it go on."""
        with not_found("scene", name):
            scene_request = store.remove(name)
        for station in stations.values():
            station.preparations.drop(scene_request)

    return router


@contextlib.contextmanager
def not_found(kind: str, name: str) -> Iterator[None]:
    """Answers 404 where the block raises KeyError."""
    try:
        yield
    except KeyError:
        raise HTTPException(404, [f'{kind}: there is no "{name[:80]}"; see /api/{kind}s']) from None
