"""Bodies of requests that hold scenes: small ones are read at once, big ones are left in a file for another process."""

import errno
import json
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, TypeVar

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute
from pydantic import ValidationError
from starlette.types import Message

from radar_service.stream.http import schemas
from radar_service.stream.http.scene_store import UploadFolder
from radar_service.stream.jobs import JobQueue
from radar_service.stream.processes.call import ProcessFault, call_in_process
from radar_service.stream.processes.fork_server import ForkServer

MAX_JSON_BYTES = 10 * 2**20  # as much as the file of a scene may have
SMALL = 64 * 2**10  # bytes: some 2 ms to read
BODY, SCENE = "body.json", "scene.json"

Model = TypeVar("Model", schemas.SceneUpload, schemas.SceneChoice)


class BodyReader:
    """Reads JSON bodies. Big ones are read by a process, so that no client waits for it."""

    def __init__(self, server: ForkServer, jobs: JobQueue) -> None:
        self._server, self._jobs = server, jobs

    async def read(self, request: Request, model: type[Model], folder: UploadFolder) -> Model:
        """Returns the body; a scene that it holds becomes the file SCENE in the folder.

        Raises HTTPException, also for OSError of the disk, and what JobQueue.run raises.
        """
        path = folder.path / BODY
        try:
            size = await _store(request, path)
        except OSError as error:
            raise disk_error(error) from None
        if size <= SMALL:
            fields, refusal = read_body(path, model)
        else:
            fields, refusal = await self._in_process(path, model)
        if refusal:
            raise HTTPException(*refusal)
        return model.model_construct(**fields)

    async def _in_process(self, path: Path, model: type[Model]) -> Any:
        try:
            return await self._jobs.run("body", lambda job: call_in_process(self._server, job, read_body, path, model))
        except ProcessFault as error:
            raise HTTPException(422, [f"body: {error}"]) from None


class SmallBodyRoute(APIRoute):
    """A route whose body has at most SMALL bytes, so that the framework may read it at once."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the framework's handler with a limited body."""
        handler = super().get_route_handler()

        async def limited(request: Request) -> Response:
            size = 0

            async def receive() -> Message:
                nonlocal size
                message = await request.receive()
                size += len(message.get("body", b""))
                if size > SMALL:
                    raise HTTPException(413, [f"body: more than {SMALL} bytes"])
                return message

            return await handler(Request(request.scope, receive))

        return limited


def read_body(path: Path, model: type[Model]) -> tuple[dict[str, Any], tuple[int, list[str]] | None]:
    """Returns the fields of a body but for a scene, which goes into the file SCENE beside it; or status and lines."""
    try:
        fields = dict(model.model_validate(json.loads(path.read_bytes())))
    except ValidationError as error:
        return {}, (422, schemas.problem_lines(error.errors()))
    except (ValueError, RecursionError) as error:
        return {}, (400, [f"body: not JSON: {str(error)[:200]}"])
    if isinstance(fields["scene"], dict):
        (path.parent / SCENE).write_text(json.dumps(fields["scene"], separators=(",", ":")))
        fields["scene"] = {}
    return fields, None


def disk_error(error: OSError) -> Exception:
    """Returns the answer to a body that cannot be stored; other errors as they are."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return HTTPException(507, ["body: the server's disk is full; try again later"])
    return error


async def _store(request: Request, path: Path) -> int:
    """Writes a body into a file; returns its size. Raises HTTPException where it is too long."""
    size = 0
    with path.open("wb") as file:
        async for piece in request.stream():
            size += len(piece)
            if size > MAX_JSON_BYTES:
                raise HTTPException(413, [f"body: more than {MAX_JSON_BYTES} bytes; JSON may have no more"])
            file.write(piece)
    return size
