"""The application: the routes of all ports, the documentation and the page, behind the security checks.

The documentation is Swagger UI, whose files come from the package fastapi-offline. It loads nothing from other servers and has no
inline scripts, so the server's content security policy holds.
"""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from importlib import metadata, resources

from fastapi import FastAPI, Response
from fastapi.responses import HTMLResponse
from starlette.routing import Route
from starlette.staticfiles import StaticFiles

from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.http.security import SecurityMiddleware
from radar_service.ports.http.server import Requests
from radar_service.ports.port import Service
from radar_service.ports.port_host import PortHost
from radar_service.ports.refusal_shapes import RefusalShapesMiddleware
from radar_service.ports.rest.answers import add_exception_handlers
from radar_service.ports.rest.bodies import BodyLimitMiddleware
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.roles import Roles, needs
from radar_service.processes.fork_server import ForkServer
from radar_service.scene_file import packaged_folder
from radar_service.service.access import Access, Tickets
from radar_service.service.logs import Refusals
from radar_service.service.radio.preparation import Preparations
from radar_service.service.radio.station import Station, Stations

OPENAPI = "/api/openapi.json"
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>radar-service: REST</title>
<link rel="stylesheet" href="docs/files/swagger-ui.css">
<link rel="icon" href="icon.svg">
</head>
<body>
<div id="swagger-ui"></div>
<script src="docs/files/swagger-ui-bundle.js"></script>
<script src="docs/start.js"></script>
</body>
</html>
"""

# The token is the one that the page of the radar keeps for this browser tab (clients/web/api.js).
START = """const KEPT = "radar-token";
const show = () =>
  SwaggerUIBundle({
    url: new URL("api/openapi.json", document.baseURI).href,
    dom_id: "#swagger-ui",
    deepLinking: true,
    requestInterceptor: (request) => {
      const token = sessionStorage.getItem(KEPT);
      if (token) request.headers.Authorization = `Bearer ${token}`;
      return request;
    },
    responseInterceptor: (response) => {
      if (response.status !== 401) return response;
      const token = window.prompt("This server needs a token");
      if (token) {
        sessionStorage.setItem(KEPT, token.trim());
        setTimeout(show);
      }
      return response;
    },
  });
show();
"""


def create_app(
    stations: Sequence[Station] | Stations, ports: PortHost | None = None, *, fork_server: ForkServer | None = None,
    access: Access | None = None, refused: Refusals | None = None, requests: Requests | None = None,
) -> FastAPI:  # fmt: skip
    """Returns the application; it starts the radars when it starts and stops them when it stops.

    stations: the radars, all of them by the time that the application starts;
    ports: by default REST and the feed;
    fork_server: starts the processes that read big bodies and draw pictures; the application closes it;
    access: who may do what, by default everybody may do everything; refused: counts refusals, here and elsewhere;
    requests: follows the requests in progress, which the server ends when it stops.

    Raises UndeclaredRoleError for a route of a port that does not say which role it needs.
    """
    ports, requests = ports or PortHost((RestPort(), FeedPort())), requests or Requests()
    radars = stations if isinstance(stations, Stations) else Stations(stations)
    radars.sinks, radars.came, radars.went = ports.sinks, ports.watch, ports.unwatch
    service = Service(
        radars, access or Access(), Tickets(), refused or Refusals(), fork_server or ForkServer(), Preparations(),
        requests.cancel_jobs, tuple(ports.threads.values()),
    )  # fmt: skip
    requests.cancel_jobs.append(service.preparations.close)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        try:
            await ports.start(service)
            for station in radars.values():
                station.preparations, station.stations = service.preparations, radars
                await station.start()
            for station in radars.values():
                ports.watch(station)
            yield
        finally:
            service.preparations.close()
            await radars.stop()
            await ports.stop()
            service.fork_server.close()

    app = FastAPI(
        title="radar-service",
        version=metadata.version("radar-service"),
        description="A simulated marine radar: scenes in, the live feed of a rotating radar out.",
        lifespan=lifespan,
        openapi_url=OPENAPI,
        docs_url=None,  # the framework's pages load scripts from other servers; see http.docs
        redoc_url=None,
    )
    for router in ports.routes(service):
        app.router.routes += router.routes  # `include_router` would make each anew
    for route in app.routes:
        if isinstance(route, Route) and route.path == OPENAPI:
            needs("read")(route.endpoint)  # the framework has made it
    add_docs(app)
    page = StaticFiles(directory=str(packaged_folder("clients") / "web"), html=True, check_dir=False)
    app.mount("/", needs("nothing")(page))
    add_exception_handlers(app)
    app.add_middleware(BodyLimitMiddleware)
    app.add_middleware(requests.following)
    app.add_middleware(
        SecurityMiddleware, access=service.access, tickets=service.tickets, roles=Roles(app.routes), refused=service.refused
    )
    if ports.refusals:
        app.add_middleware(RefusalShapesMiddleware, shapes=ports.refusals)
    return app


def add_docs(app: FastAPI) -> None:
    """Adds the page and its files to an application."""

    @needs("nothing")
    async def page() -> HTMLResponse:
        return HTMLResponse(PAGE)

    @needs("nothing")
    async def start() -> Response:
        return Response(START, media_type="text/javascript")

    app.add_api_route("/docs", page, include_in_schema=False)
    app.add_api_route("/docs/start.js", start, include_in_schema=False)
    files = resources.files("fastapi_offline").joinpath("static")
    app.mount("/docs/files", needs("nothing")(StaticFiles(directory=str(files))))
