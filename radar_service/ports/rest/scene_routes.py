"""REST: the scenes of the server."""

import asyncio
import contextlib
from collections.abc import Iterator, Mapping
from typing import Annotated

from fastapi import APIRouter, HTTPException, Query, Request

from radar_service.ports.rest import schemas
from radar_service.ports.rest.answers import BUSY, CONFLICT, REFUSED, STORED, UNKNOWN, UNREADABLE
from radar_service.ports.rest.bodies import BodyReader
from radar_service.ports.rest.scene_store import SceneStore, without_folder
from radar_service.ports.rest.uploads import UPLOAD_BODY, read_upload
from radar_service.ports.roles import needs
from radar_service.service.radio.station import Station

JobName = Annotated[
    str | None, Query(alias="job", pattern=r"^[A-Za-z0-9_-]{1,64}$", description="a name for it in /api/jobs")
]


def scene_routes(stations: Mapping[str, Station], store: SceneStore, reader: BodyReader) -> APIRouter:
    """Returns the routes under /scenes."""
    router = APIRouter(tags=["scenes"])

    @router.get("/scenes")
    @needs("read")
    async def list_scenes() -> list[schemas.SceneListing]:
        """Returns the scenes that can be run by name."""
        summaries = await asyncio.to_thread(lambda: [entry.summary() for entry in store.entries()])
        return [schemas.SceneListing.model_validate(summary) for summary in summaries]

    @router.post(
        "/scenes", status_code=201, responses={**REFUSED, **CONFLICT, **UNREADABLE, **STORED, **BUSY},
        openapi_extra={"requestBody": UPLOAD_BODY},
    )  # fmt: skip
    @needs("command")
    async def add_scene(request: Request, job: JobName = None) -> schemas.SceneAnswer:
        """Keeps a scene, checked and planned for the first radar; it replaces an earlier upload of the same name."""
        first = next(iter(stations.values()))
        with store.receiving() as folder:
            name, scene_request = await read_upload(request, reader, folder)
        store.check_room(name)
        with without_folder(scene_request):
            spoke_source = await first.prepare(scene_request, job)
        scene = spoke_source.info.scene
        first.preparations.keep(spoke_source)  # a radar is likely to run it next
        store.add(name, scene_request, scene)
        warnings = [*scene.warnings, *scene.notes]
        return schemas.SceneAnswer(name=name, bodies=scene.body_count, warnings=warnings, plan=dict(spoke_source.info.plan))

    @router.delete("/scenes/{name}", status_code=204, responses={**UNKNOWN, **CONFLICT})
    @needs("command")
    async def delete_scene(name: str) -> None:
        """Deletes an uploaded scene; radars that run it go on."""
        with not_found("scene", name):
            scene_request = store.remove(name)
        for station in stations.values():
            station.preparations.drop(scene_request)

    return router


@contextlib.contextmanager
def not_found(kind: str, name: str) -> Iterator[None]:
    """Answers 404 where the block raises KeyError."""
    try:
        yield
    except KeyError:
        raise HTTPException(404, [f'{kind}: there is no "{name[:80]}"; see /api/{kind}s']) from None
