"""The REST interface: all routes under /api, put together."""

from collections.abc import Mapping

from fastapi import APIRouter, Request

from radar_service.stream.access import TICKET_SECONDS, Tickets
from radar_service.stream.http import schemas
from radar_service.stream.http.answers import PROTECTED
from radar_service.stream.http.bodies import BodyReader
from radar_service.stream.http.command_routes import command_routes
from radar_service.stream.http.health_routes import health_routes
from radar_service.stream.http.job_routes import job_routes
from radar_service.stream.http.pictures import Pictures
from radar_service.stream.http.radar_routes import radar_routes
from radar_service.stream.http.scene_routes import scene_routes
from radar_service.stream.http.scene_store import SceneStore
from radar_service.stream.http.security import ROLE
from radar_service.stream.http.vitals import Vitals
from radar_service.stream.jobs import JobQueue
from radar_service.stream.ports.roles import needs
from radar_service.stream.radio.station import Station


def api(
    stations: Mapping[str, Station],
    store: SceneStore,
    tickets: Tickets,
    jobs: JobQueue,
    reader: BodyReader,
    pictures: Pictures,
    vitals: Vitals,
) -> APIRouter:
    """Returns all routes under /api."""
    router = APIRouter(prefix="/api", responses=PROTECTED)
    router.include_router(scene_routes(stations, store, reader))
    router.include_router(radar_routes(stations, store, reader, pictures))
    router.include_router(command_routes(stations))
    router.include_router(job_routes(jobs))
    router.include_router(health_routes(stations, vitals))

    @router.post("/tickets", status_code=201, tags=["access"])
    @needs("read")
    async def issue_ticket(request: Request) -> schemas.Ticket:
        """Returns a ticket for one websocket, for its parameter `ticket`: browsers send no token with a websocket."""
        return schemas.Ticket(ticket=tickets.issue(request.scope.get(ROLE)), seconds=TICKET_SECONDS)

    return router
