"""REST: health and probes."""

from collections.abc import Mapping
from importlib import metadata

from fastapi import APIRouter, Response

from radar_service.stream.http import schemas
from radar_service.stream.http.vitals import Vitals
from radar_service.stream.ports.roles import needs
from radar_service.stream.radio import status
from radar_service.stream.radio.station import Station


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
