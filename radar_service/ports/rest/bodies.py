"""Bodies of requests. JSON is refused with 400 where it is none, with 422 where a key occurs twice in one table.

All bodies are bounded before anything reads them: a length that the client states is checked at once, chunks are counted.
Bodies that hold scenes are read at once where they are small; big ones are left in a file for another process.
"""

import asyncio
import json
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, TypeVar

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute
from pydantic import ValidationError
from starlette.datastructures import Headers
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from radar_service.ports.rest import schemas
from radar_service.ports.rest.scene_store import MAX_UPLOAD_BYTES, UploadFolder
from radar_service.processes.call import ProcessFault, call_in_process
from radar_service.processes.fork_server import ForkServer
from radar_service.service.jobs import JobQueue
from radar_service.strict_json import DuplicateKeyError, parsed

Refusal = tuple[int, list[str]]  # status, and the lines of `detail`
MAX_JSON_BYTES = 10 * 2**20  # as much as the file of a scene may have
SMALL = 64 * 2**10  # bytes: some 2 ms to read
TOO_LONG = 413  # status
BODY, SCENE = "body.json", "scene.json"
Model = TypeVar("Model", schemas.SceneUpload, schemas.SceneChoice)
Parsed = tuple[dict[str, Any], Refusal | None]  # fields, or status and lines of a refusal
Parse = Callable[[Path, Any], Parsed]


def parsed_body(content: bytes) -> tuple[Any, Refusal | None]:
    """Returns the content of a body, and why it is refused, None where it is not."""
    try:
        return parsed(content), None
    except DuplicateKeyError as error:
        return None, (422, [f"body: {error}"])
    except (ValueError, RecursionError) as error:
        return None, (400, [f"body: not JSON: {str(error)[:200]}"])


class StrictRoute(APIRoute):
    """A route whose JSON body is read by `parsed_body`; the framework's parser takes the last of two values for one key."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the route's handler for requests that are read so."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            return await handler(_StrictRequest(request.scope, request.receive))

        return handle


class _StrictRequest(Request):
    async def json(self) -> Any:
        """Raises HTTPException."""
        content, refusal = parsed_body(await self.body())
        if refusal:
            raise HTTPException(*refusal)
        return content


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
    """Writes a body into a file; returns its size."""
    size = 0
    with path.open("wb") as file:
        async for piece in request.stream():
            size += file.write(piece)
    return size


class BodyLimitMiddleware:
    """Answers 413 to a request with a body that is too long."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        maximum, length = max_body(scope), Headers(scope=scope).get("content-length", "")
        if length.isdecimal() and int(length[:20]) > maximum:
            return await JSONResponse({"detail": _lines(maximum)}, TOO_LONG)(scope, receive, send)
        await self._app(scope, _counted(receive, maximum), send)


def max_body(scope: Scope) -> int:
    """Returns the bytes that the body of a request may have: many only where a scene is expected."""
    path = tuple(scope["path"].strip("/").split("/"))
    match scope["method"], path:
        case "POST", ("api", "scenes"):
            is_form = Headers(scope=scope).get("content-type", "").lower().startswith("multipart/")
            return MAX_UPLOAD_BYTES if is_form else MAX_JSON_BYTES
        case "PUT", ("api", "radars", _, "scene"):
            return MAX_JSON_BYTES
    return SMALL


def _counted(receive: Receive, maximum: int) -> Receive:
    """Returns a receiver that raises HTTPException where the body exceeds its maximum [bytes]."""
    size = 0

    async def receive_counted() -> Message:
        nonlocal size
        message = await receive()
        size += len(message.get("body", b""))
        if size > maximum:
            raise HTTPException(TOO_LONG, _lines(maximum))
        return message

    return receive_counted


def _lines(maximum: int) -> list[str]:
    return [f"body: more than {maximum} bytes; this request may have no more"]
