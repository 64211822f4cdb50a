"""Bodies of requests that hold scenes: small ones are read at once, big ones are left in a file for another process."""

import asyncio
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from fastapi import HTTPException, Request
from pydantic import ValidationError

from radar_service.ports.rest import schemas
from radar_service.ports.rest.json_bodies import Refusal, parsed_body
from radar_service.ports.rest.scene_store import UploadFolder
from radar_service.processes.call import ProcessFault, call_in_process
from radar_service.processes.fork_server import ForkServer
from radar_service.service.jobs import JobQueue

MAX_JSON_BYTES = 10 * 2**20  # as much as the file of a scene may have
SMALL = 64 * 2**10  # bytes: some 2 ms to read
BODY, SCENE = "body.json", "scene.json"

Model = TypeVar("Model", schemas.SceneUpload, schemas.SceneChoice)
Parsed = tuple[dict[str, Any], Refusal | None]  # fields, or status and lines of a refusal
Parse = Callable[[Path, Any], Parsed]


class BodyReader:
    """Reads bodies. Big ones are read by a process, so that no client waits for it."""

    def __init__(self, server: ForkServer, jobs: JobQueue) -> None:
        self._server, self._jobs = server, jobs

    async def read(self, request: Request, model: type[Model], folder: UploadFolder) -> Model:
        """Returns a JSON body; a scene that it holds becomes the file SCENE in the folder. Raises as `fields`."""
        return model.model_construct(**await self.fields(request, folder, read_body, model))

    async def fields(self, request: Request, folder: UploadFolder, parse: Parse, form: object) -> dict[str, Any]:
        """Returns the fields of a body, which parse(file, form) reads.

        Raises HTTPException, OSError of the disk, and what `parse` and JobQueue.run raise.
        """
        path = folder.path / BODY
        read = asyncio.to_thread if await _store(request, path) <= SMALL else self._in_process
        fields, refusal = await read(parse, path, form)
        if refusal:
            raise HTTPException(*refusal)
        return fields

    async def _in_process(self, parse: Parse, path: Path, form: object) -> Any:
        try:
            return await self._jobs.run("body", lambda job: call_in_process(self._server, job, parse, path, form))
        except ProcessFault as error:
            raise HTTPException(422, [f"body: {error}"]) from None


def read_body(path: Path, model: type[Model]) -> Parsed:
    """Returns the fields of a body but for a scene, which goes into the file SCENE beside it; or status and lines."""
    content, refusal = parsed_body(path.read_bytes())
    if refusal:
        return {}, refusal
    try:
        fields = dict(model.model_validate(content))
    except ValidationError as error:
        return {}, (422, schemas.problem_lines(error.errors()))
    if isinstance(fields["scene"], dict):
        (path.parent / SCENE).write_text(json.dumps(fields["scene"], separators=(",", ":")))
        fields["scene"] = {}
    return fields, None


async def _store(request: Request, path: Path) -> int:
    """Writes a body into a file; returns its size. body_limits bounds it."""
    size = 0
    with path.open("wb") as file:
        async for piece in request.stream():
            size += file.write(piece)
    return size
