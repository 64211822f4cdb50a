"""The REST interface: all routes under /api, put together.

The routes of health, probes and jobs are here too.
"""

from collections.abc import Mapping
from importlib import metadata

from fastapi import APIRouter, Request, Response

from radar_service.ports.http.security import ROLE
from radar_service.ports.rest import schemas
from radar_service.ports.rest.answers import PROTECTED, REFUSED, UNKNOWN
from radar_service.ports.rest.bodies import BodyReader
from radar_service.ports.rest.command_routes import command_routes
from radar_service.ports.rest.pictures import Pictures
from radar_service.ports.rest.radar_routes import radar_routes
from radar_service.ports.rest.scene_routes import not_found, scene_routes
from radar_service.ports.rest.scene_store import SceneStore
from radar_service.ports.rest.vitals import Vitals
from radar_service.ports.roles import needs
from radar_service.service.access import TICKET_SECONDS, Tickets
from radar_service.service.jobs import JobQueue
from radar_service.service.radio import status
from radar_service.service.radio.station import Station


def job_routes(jobs: JobQueue) -> APIRouter:
    """Returns the routes under /jobs."""
    router = APIRouter(tags=["jobs"])

    @router.get("/jobs")
    @needs("read")
    async def list_jobs() -> list[schemas.JobState]:
        """Returns the jobs that wait or run, and the last ones that have ended."""
        return [schemas.JobState.model_validate(job.as_dict()) for job in jobs.jobs]

    @router.get("/jobs/{job}", responses={**UNKNOWN, **REFUSED})
    @needs("read")
    async def get_job(job: str) -> schemas.JobState:
        """Returns how far a job is."""
        with not_found("job", job):
            return schemas.JobState.model_validate(jobs.job(job).as_dict())

    @router.delete("/jobs/{job}", status_code=204, responses={**UNKNOWN, **REFUSED})
    @needs("command")
    async def cancel_job(job: str) -> None:
        """Cancels a job; the request that waits for it is answered with 409."""
        with not_found("job", job):
            jobs.job(job).cancel()

    return router


def health_routes(stations: Mapping[str, Station], vitals: Vitals) -> APIRouter:
    """Returns the routes under /health."""
    router = APIRouter(tags=["health"])

    @router.get(
        "/health", responses={503: {"model": schemas.Health, "description": "a radar has failed or is starting again"}}
    )
    @needs("read")
    async def get_health(response: Response) -> schemas.Health:
        """Returns the health of the server and of each radar."""
        radars = [status.health(station) for station in stations.values()]
        states = {radar["state"] for radar in radars}
        worst = next((bad for bad in ("failed", "restarting", "behind") if bad in states), "ok")
        response.status_code = 503 if worst in ("failed", "restarting") else 200
        version = metadata.version("radar-service")
        return schemas.Health.model_validate({"status": worst, "version": version, "radars": radars})

    @router.get("/health/alive", response_model_exclude_defaults=True)
    @needs("nothing")
    async def is_alive() -> schemas.ReadyState:
        """Answers whenever the server runs; needs no token."""
        return schemas.ReadyState(yes=True)

    @router.get(
        "/health/ready", response_model_exclude_defaults=True,
        responses={503: {"model": schemas.ReadyState, "description": "not yet, or no more"}},
    )  # fmt: skip
    @needs("nothing")
    async def is_ready(response: Response) -> schemas.ReadyState:
        """Returns whether every radar is on the air and takes clients, and uploads are possible; needs no token."""
        problems = await vitals.problems(stations.values())
        ready = not problems and all(status.is_ready(station) for station in stations.values())
        response.status_code = 200 if ready else 503
        return schemas.ReadyState(yes=ready, problems=problems)

    return router


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
