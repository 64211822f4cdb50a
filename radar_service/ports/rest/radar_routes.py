"""REST: the radars, their controls, scenes, truth and pictures."""

from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query, Request, Response

from radar_service import wire
from radar_service.ports.rest import schemas
from radar_service.ports.rest.answers import (
    BUSY,
    CONFLICT,
    FORBIDDEN,
    REFUSED,
    STORED,
    UNKNOWN,
    UNREADABLE,
    api_router,
    knows_truth,
    station_of,
)
from radar_service.ports.rest.bodies import SCENE, BodyReader, StrictRoute
from radar_service.ports.rest.pictures import Pictures
from radar_service.ports.rest.scene_routes import JobName, not_found
from radar_service.ports.rest.scene_store import SceneStore, without_folder
from radar_service.ports.roles import needs
from radar_service.records import Truth
from radar_service.service.access import told_fields, told_plan
from radar_service.service.codecs.codec import CODECS
from radar_service.service.codecs.native import messages
from radar_service.service.controls import control_definitions
from radar_service.service.radio.station import Station
from radar_service.service.radio.status import state
from radar_service.service.scene_request import cell_layout

PICTURE: dict[int | str, dict[str, Any]] = {200: {"content": {"image/png": {}}, "description": "the picture"}}
SCENE_BODY: dict[str, Any] = {
    "required": True, "content": {"application/json": {"schema": schemas.SceneChoice.model_json_schema()}},
}  # fmt: skip


def radar_routes(stations: Mapping[str, Station], store: SceneStore, reader: BodyReader, pictures: Pictures) -> APIRouter:
    """Returns the routes under /radars."""
    router = api_router("radars", StrictRoute)
    _add_read_routes(router, stations, pictures)
    _add_changing(router, stations, store, reader)
    return router


def _add_read_routes(router: APIRouter, stations: Mapping[str, Station], pictures: Pictures) -> None:
    @router.get("/radars")
    @needs("read")
    async def list_radars(request: Request) -> list[schemas.RadarState]:
        """Returns all radars of this server."""
        return [_radar_state(station, knows_truth(request, station)) for station in stations.values()]

    @router.get("/radars/{radar}", responses=UNKNOWN)
    @needs("read")
    async def get_radar(radar: str, request: Request) -> schemas.RadarState:
        """Returns one radar."""
        station = station_of(stations, radar)
        return _radar_state(station, knows_truth(request, station))

    @router.get("/radars/{radar}/controls", responses=UNKNOWN)
    @needs("read")
    async def get_controls(radar: str) -> schemas.ControlsState:
        """Returns the state of all controls."""
        return schemas.ControlsState.model_validate(station_of(stations, radar).controls())

    @router.get("/radars/{radar}/truth", responses={**UNKNOWN, **FORBIDDEN, **REFUSED})
    @needs("read")
    async def get_truth(
        radar: str, t: Annotated[float | None, Query(ge=0, le=1e9, allow_inf_nan=False, description="s, default now")] = None
    ) -> Truth:
        """Returns the true state of own ship and of every body."""
        station = station_of(stations, radar)
        if not station.allow_truth:
            raise HTTPException(403, ["truth: this server does not give it; start it with --truth"])
        return await station.truth(t)

    @router.get("/radars/{radar}/ppi.png", response_class=Response, responses={**UNKNOWN, **REFUSED, **PICTURE, **BUSY})
    @needs("read")
    async def get_picture(
        radar: str,
        size: Annotated[int, Query(ge=64, le=2048, description="pixels")] = 900,
        range_m: Annotated[float | None, Query(ge=10, le=200_000, allow_inf_nan=False)] = None,
    ) -> Response:
        """Returns the last revolution as a picture, north up, with the radar's gain, sea and rain."""
        data = await pictures.png(station_of(stations, radar), size, range_m)
        return Response(data, media_type="image/png", headers={"Cache-Control": "no-store"})


def _add_changing(router: APIRouter, stations: Mapping[str, Station], store: SceneStore, reader: BodyReader) -> None:
    @router.put(
        "/radars/{radar}/scene", responses={**UNKNOWN, **REFUSED, **UNREADABLE, **STORED, **BUSY, **CONFLICT},
        openapi_extra={"requestBody": SCENE_BODY},
    )  # fmt: skip
    @needs("command")
    async def run_scene(radar: str, request: Request, job: JobName = None) -> schemas.SceneAnswer:
        """Runs another scene with its radars: prepared beside the running one, it takes over when the running scan ends."""
        station = station_of(stations, radar)
        with store.receiving() as folder:
            choice = await reader.read(request, schemas.SceneChoice, folder)
        scene_request = folder.scene_request(SCENE)
        if isinstance(choice.scene, str):
            with not_found("scene", choice.scene):
                scene_request = store.scene_request(choice.scene)
        with without_folder(scene_request):
            epoch, known = await station.swap(scene_request, job)
        notes = () if isinstance(choice.scene, str) else known.scene.notes
        return schemas.SceneAnswer(
            name=known.scene.name, bodies=known.scene.body_count, warnings=[*known.scene.warnings, *notes], epoch=epoch,
            plan=dict(known.plan), radars=station.group.identities,
        )  # fmt: skip

    @router.patch("/radars/{radar}/controls", responses={**UNKNOWN, **REFUSED, **UNREADABLE, **BUSY, **CONFLICT})
    @needs("command")
    async def change_controls(radar: str, requested: schemas.ControlsChange) -> schemas.ControlsState:
        """Changes some controls; answers with the state of all."""
        station = station_of(stations, radar)
        await station.change(requested.model_dump(exclude_none=True))
        return schemas.ControlsState.model_validate(station.controls())


def _radar_state(station: Station, knows: bool) -> schemas.RadarState:
    known = station.epoch.info
    to = cell_layout(known, None, None)
    fields = messages.radar_fields(station.identity, station.name, known.scene.radar, to) | {
        "scene": messages.scene_fields(known.scene, knows),
        "seed": known.seed,
        "fidelity": known.fidelity.name,
        "plan": told_plan(known.plan, knows),
        "controls": station.controls(),
        "control_definitions": control_definitions(known.scene),
        "state": state(station),
        "epoch": station.hub.epoch,
        "feed": CODECS["native"].path.format(radar=station.identity),
        "encodings": list(wire.DTYPES),
    }
    return schemas.RadarState.model_validate(told_fields(fields, station.epoch.is_blind))
