"""The application: REST, the native feed, the page, and the guard before them. The only place that knows FastAPI's own."""

import asyncio
from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import asynccontextmanager
from importlib import metadata
from pathlib import Path

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.staticfiles import StaticFiles

from radar_service.packaged import packaged_folder
from radar_service.scene.error import SceneError
from radar_service.scene.files.mesh_reader import IN_PROCESS
from radar_service.scene.files.sandbox import Sandbox
from radar_service.stream import metrics
from radar_service.stream.access import Access
from radar_service.stream.ahead import EngineFault
from radar_service.stream.api import api, problem_lines
from radar_service.stream.guard import Guard
from radar_service.stream.journal import Refusals
from radar_service.stream.scenes import MAX_UPLOAD_BYTES, Conflict, SceneShelf
from radar_service.stream.station import Station


def create_app(
    stations: Sequence[Station], *, scene_folders: Iterable[Path] = (), sandbox: Sandbox | None = None,
    sandbox_all: bool = False, access: Access | None = None, refused: Refusals | None = None,
) -> FastAPI:  # fmt: skip
    """The application that puts these radars on the air when it starts and takes them off when it stops.

    scene_folders: whose scenes are offered besides the packaged ones. sandbox: parses the files of uploads, with
    sandbox_all those of every scene asked for by REST; it is closed when the application stops. access: who may do what,
    by default everybody everything. refused: who is told of what is turned away, here and elsewhere.
    """
    sandbox, access, refused = sandbox or Sandbox(), access or Access(), refused or Refusals()
    shelf = SceneShelf(scene_folders, sandbox if sandbox_all else IN_PROCESS, sandbox)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        try:
            for station in stations:
                await station.start()
            yield
        finally:
            await asyncio.gather(*(station.stop() for station in stations))
            shelf.close()
            await asyncio.to_thread(sandbox.close)

    app = FastAPI(
        title="radar-service",
        version=metadata.version("radar-service"),
        description="A simulated marine radar: scenes in, the live feed of a rotating radar out.",
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        docs_url=None,  # the usual pages load scripts from elsewhere, which this server's policy forbids
        redoc_url=None,
        max_body_size=MAX_UPLOAD_BYTES,
    )
    app.include_router(api({station.identity: station for station in stations}, shelf, access, refused))
    app.add_api_route("/metrics", lambda: _figures(stations, refused), include_in_schema=False)
    app.mount("/", StaticFiles(directory=str(packaged_folder("clients") / "web"), html=True, check_dir=False))
    _answer_faults(app)
    app.add_middleware(Guard, access=access, refused=refused)
    return app


def _figures(stations: Sequence[Station], refused: Refusals) -> Response:
    return Response(metrics.exposition(stations, refused.counts), media_type=metrics.CONTENT_TYPE)


def _answer_faults(app: FastAPI) -> None:
    def refuse(status: int, lines: Sequence[str]) -> JSONResponse:
        return JSONResponse({"detail": list(lines)}, status)

    @app.exception_handler(SceneError)
    async def scene_error(_: Request, fault: SceneError) -> JSONResponse:
        return refuse(422, fault.problems)

    @app.exception_handler(EngineFault)
    async def engine_fault(_: Request, fault: EngineFault) -> JSONResponse:
        return refuse(422, [f"scene: {fault}"])

    @app.exception_handler(Conflict)
    async def conflict(_: Request, fault: Conflict) -> JSONResponse:
        return refuse(409, [str(fault)])

    @app.exception_handler(RequestValidationError)
    async def invalid(_: Request, fault: RequestValidationError) -> JSONResponse:
        return refuse(422, problem_lines(fault.errors()))

    @app.exception_handler(ClientDisconnect)
    async def stopped(_: Request, fault: ClientDisconnect) -> JSONResponse:
        return refuse(400, ["body: it stopped coming; send it whole"])

    @app.exception_handler(HTTPException)
    async def refused(_: Request, fault: HTTPException) -> JSONResponse:
        detail: object = fault.detail  # our own are lists of lines, the framework's are words
        lines = detail if isinstance(detail, list) else [str(detail)]
        return JSONResponse({"detail": lines}, fault.status_code, fault.headers)
