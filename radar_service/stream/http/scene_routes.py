"""REST: the scenes of the server."""

import asyncio
import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

from fastapi import APIRouter, HTTPException, Request

from radar_service.scene.world import Scene
from radar_service.stream.http import schemas
from radar_service.stream.http.answers import CONFLICT, REFUSED, UNKNOWN, UNREADABLE
from radar_service.stream.http.scene_store import SceneStore
from radar_service.stream.http.uploads import UPLOAD_BODY, read_upload
from radar_service.stream.radio.station import Station


def scene_routes(stations: Mapping[str, Station], store: SceneStore) -> APIRouter:
    """Returns the routes under /scenes."""
    router = APIRouter(tags=["scenes"])

    @router.get("/scenes")
    async def list_scenes() -> list[schemas.SceneListing]:
        """Returns the scenes that can be run by name."""
        summaries = await asyncio.to_thread(lambda: [entry.summary() for entry in store.entries()])
        return [schemas.SceneListing.model_validate(summary) for summary in summaries]

    @router.post(
        "/scenes", status_code=201, responses={**REFUSED, **CONFLICT, **UNREADABLE},
        openapi_extra={"requestBody": UPLOAD_BODY},
    )  # fmt: skip
    async def add_scene(request: Request) -> schemas.SceneAnswer:
        """Keeps a scene, checked and planned for the first radar; it replaces an earlier upload of the same name."""
        name, scene, kind, files = await read_upload(request)
        first, loop = next(iter(stations.values())), asyncio.get_running_loop()

        def plan_for_first(built: Scene) -> dict[str, Any]:
            return asyncio.run_coroutine_threadsafe(first.plan(built), loop).result()

        built, plan = await asyncio.to_thread(store.add, name, scene, kind, files, plan_for_first)
        return schemas.SceneAnswer(name=name, bodies=len(built.bodies), warnings=list(built.warnings), plan=plan)

    @router.delete("/scenes/{name}", status_code=204, responses={**UNKNOWN, **CONFLICT})
    async def delete_scene(name: str) -> None:
        """Deletes an uploaded scene; radars that run it go on."""
        with not_found("scene", name):
            await asyncio.to_thread(store.remove, name)

    return router


@contextlib.contextmanager
def not_found(kind: str, name: str) -> Iterator[None]:
    """Answers 404 where the block raises KeyError."""
    try:
        yield
    except KeyError:
        raise HTTPException(404, [f'{kind}: there is no "{name[:80]}"; see /api/{kind}s']) from None
