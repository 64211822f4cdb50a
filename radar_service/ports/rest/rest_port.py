"""REST as a port: all routes under /api but for the feed, and the metrics. Those of health, probes and jobs are made here."""

from collections.abc import Iterable, Mapping, Sequence
from importlib import metadata
from pathlib import Path

from fastapi import APIRouter, Request, Response

from radar_service.ports.http.security import ROLE
from radar_service.ports.port import Port, Service
from radar_service.ports.rest import metrics, schemas
from radar_service.ports.rest.answers import REFUSED, UNKNOWN, api_router
from radar_service.ports.rest.bodies import BodyReader
from radar_service.ports.rest.command_routes import command_routes, error_routes
from radar_service.ports.rest.metrics import Vitals
from radar_service.ports.rest.pictures import Pictures
from radar_service.ports.rest.radar_routes import radar_routes
from radar_service.ports.rest.scene_routes import not_found, scene_routes
from radar_service.ports.rest.scene_store import SceneStore
from radar_service.ports.rest.websockets import ChangeFeed, pose_routes, truth_routes
from radar_service.ports.roles import needs
from radar_service.service.access import TICKET_SECONDS, Tickets
from radar_service.service.jobs import JobQueue
from radar_service.service.radio import status
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.radio.station import Station


class RestPort(Port):
    """Radars, controls, commands, scenes, jobs, health, truth, changes and metrics."""

    name = "rest"

    def __init__(self, scene_folders: Iterable[Path] = (), sandbox_all: bool = False) -> None:
        """scene_folders: their scenes are listed beside the packaged ones; sandbox_all: the files of every scene that REST
        names are parsed in a limited process, not only those of uploads."""
        self.store = SceneStore(scene_folders, sandbox_all)
        self._pictures: Pictures | None = None
        self._vitals: Vitals | None = None
        self._changes: ChangeFeed | None = None

    def routes(self, service: Service) -> Sequence[APIRouter]:
        """Returns all routes."""
        stations, jobs = service.stations, service.preparations.jobs
        self._pictures = pictures = Pictures(service.fork_server)
        self._vitals = vitals = Vitals(jobs, self.store.home)
        service.cancel_jobs.append(pictures.close)
        self._changes = changes = ChangeFeed(stations, service.refused)
        reader = BodyReader(service.fork_server, jobs)
        return (
            scene_routes(stations, self.store, reader),
            radar_routes(stations, self.store, reader, pictures),
            error_routes(stations),
            command_routes(stations),
            job_routes(jobs),
            health_routes(stations, vitals),
            ticket_routes(service.tickets),
            truth_routes(stations, service.refused),
            pose_routes(stations, service.refused),
            changes.routes(),
            _metrics(service, vitals),
        )

    async def start(self, service: Service) -> None:
        """Begins to watch."""
        assert self._vitals is not None and self._changes is not None, "routes() comes first"
        self._vitals.start()
        self._changes.start()

    async def stop(self) -> None:
        """Removes uploads."""
        if self._vitals and self._pictures:
            self._vitals.close()
            self._pictures.close()
        self.store.close()

    def changed(self, change: StateChange) -> None:
        """Tells a change."""
        if self._changes:
            self._changes.take(change)


def _metrics(service: Service, vitals: Vitals) -> APIRouter:
    router = APIRouter()

    @router.get("/metrics", include_in_schema=False)
    @needs("read")
    async def get_metrics() -> Response:
        data = metrics.exposition(list(service.stations.values()), service.refused.counts, vitals, service.threads)
        return Response(data, media_type=metrics.CONTENT_TYPE)

    return router


def job_routes(jobs: JobQueue) -> APIRouter:
    """Returns the routes under /jobs."""
    router = api_router("jobs")

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
    router = api_router("health")

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


def ticket_routes(tickets: Tickets) -> APIRouter:
    """Returns the route of tickets."""
    router = api_router("access")

    @router.post("/tickets", status_code=201)
    @needs("read")
    async def issue_ticket(request: Request) -> schemas.Ticket:
        """Returns a ticket for one websocket, for its parameter `ticket`: browsers send no token with a websocket."""
        return schemas.Ticket(ticket=tickets.issue(request.scope.get(ROLE)), seconds=TICKET_SECONDS)

    return router
