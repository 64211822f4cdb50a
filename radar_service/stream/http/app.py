"""The application: REST, the feeds, metrics, the documentation and the page, behind the security checks."""

import asyncio
from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import asynccontextmanager
from importlib import metadata
from pathlib import Path

from fastapi import FastAPI
from fastapi.responses import Response
from starlette.staticfiles import StaticFiles

from radar_service.packaged import packaged_folder
from radar_service.stream.http import metrics
from radar_service.stream.http.access import Access, Tickets
from radar_service.stream.http.answers import add_exception_handlers
from radar_service.stream.http.api import api
from radar_service.stream.http.bodies import BodyReader
from radar_service.stream.http.body_limits import BodyLimitMiddleware
from radar_service.stream.http.docs import add_docs
from radar_service.stream.http.feed import feed_routes
from radar_service.stream.http.pictures import Pictures
from radar_service.stream.http.pose_feed import pose_routes
from radar_service.stream.http.requests import Requests, RequestsMiddleware
from radar_service.stream.http.scene_store import SceneStore
from radar_service.stream.http.security import SecurityMiddleware
from radar_service.stream.http.truth_feed import truth_routes
from radar_service.stream.http.vitals import Vitals
from radar_service.stream.logs import Refusals
from radar_service.stream.processes.fork_server import ForkServer
from radar_service.stream.radio.preparation import Preparations
from radar_service.stream.radio.station import Station


def create_app(
    stations: Sequence[Station], *, scene_folders: Iterable[Path] = (), sandbox_all: bool = False,
    fork_server: ForkServer | None = None, access: Access | None = None, refused: Refusals | None = None,
    requests: Requests | None = None,
) -> FastAPI:  # fmt: skip
    """Returns the application; it starts the radars when it starts and stops them when it stops.

    stations: the radars, all of them by the time that the application starts;
    scene_folders: their scenes are listed beside the packaged ones;
    sandbox_all: the files of every scene that REST names are parsed in a limited process, not only those of uploads;
    fork_server: starts the processes that read big bodies and draw pictures; the application closes it;
    access: who may do what, by default everybody may do everything; refused: counts refusals, here and elsewhere;
    requests: follows the requests in progress, which the server ends when it stops.
    """
    access, refused, tickets = access or Access(), refused or Refusals(), Tickets()
    store, server = SceneStore(scene_folders, sandbox_all), fork_server or ForkServer()
    preparations, pictures = Preparations(), Pictures(server)
    requests = requests or Requests()
    requests.cancel_jobs += [preparations.close, pictures.close]
    reader, vitals = BodyReader(server, preparations.jobs), Vitals(preparations.jobs, store.home)
    by_identity: dict[str, Station] = {}

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        vitals.start()
        by_identity.update((station.identity, station) for station in stations)
        try:
            for station in stations:
                station.preparations = preparations
                await station.start()
            yield
        finally:
            vitals.close()
            preparations.close()
            pictures.close()
            await asyncio.gather(*(station.stop() for station in stations))
            store.close()
            server.close()

    app = FastAPI(
        title="radar-service",
        version=metadata.version("radar-service"),
        description="A simulated marine radar: scenes in, the live feed of a rotating radar out.",
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        docs_url=None,  # the framework's pages load scripts from other servers; see http.docs
        redoc_url=None,
    )
    app.include_router(api(by_identity, store, tickets, preparations.jobs, reader, pictures, vitals))
    app.include_router(feed_routes(by_identity, access, refused))
    app.include_router(truth_routes(by_identity, refused))
    app.include_router(pose_routes(by_identity, refused))

    @app.get("/metrics", include_in_schema=False)
    async def get_metrics() -> Response:
        return Response(metrics.exposition(stations, refused.counts, vitals), media_type=metrics.CONTENT_TYPE)

    add_docs(app)
    app.mount("/", StaticFiles(directory=str(packaged_folder("clients") / "web"), html=True, check_dir=False))
    add_exception_handlers(app)
    app.add_middleware(BodyLimitMiddleware)
    app.add_middleware(RequestsMiddleware, requests=requests)
    app.add_middleware(SecurityMiddleware, access=access, tickets=tickets, refused=refused)
    return app
