"""REST as a port: what is under /api but for the feed, and the metrics."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import Response
from typing_extensions import override

from radar_service.ports.port import Port, Service
from radar_service.ports.rest import metrics
from radar_service.ports.rest.api import api
from radar_service.ports.rest.bodies import BodyReader
from radar_service.ports.rest.change_feed import ChangeFeed
from radar_service.ports.rest.pictures import Pictures
from radar_service.ports.rest.pose_feed import pose_routes
from radar_service.ports.rest.scene_store import SceneStore
from radar_service.ports.rest.truth_feed import truth_routes
from radar_service.ports.rest.vitals import Vitals
from radar_service.ports.roles import needs
from radar_service.service.radio.state_changes import StateChange


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

    @override
    def routes(self, service: Service) -> Sequence[APIRouter]:
        stations, jobs = service.stations, service.preparations.jobs
        self._pictures = pictures = Pictures(service.fork_server)
        self._vitals = vitals = Vitals(jobs, self.store.home)
        service.cancel_jobs.append(pictures.close)
        self._changes = changes = ChangeFeed(stations, service.refused)
        reader = BodyReader(service.fork_server, jobs)
        return (
            api(stations, self.store, service.tickets, jobs, reader, pictures, vitals),
            truth_routes(stations, service.refused),
            pose_routes(stations, service.refused),
            changes.routes(),
            _metrics(service, vitals),
        )

    @override
    async def start(self, service: Service) -> None:
        assert self._vitals is not None and self._changes is not None, "routes() comes first"
        self._vitals.start()
        self._changes.start()

    @override
    async def stop(self) -> None:
        if self._vitals and self._pictures:
            self._vitals.close()
            self._pictures.close()
        self.store.close()

    @override
    def changed(self, change: StateChange) -> None:
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
