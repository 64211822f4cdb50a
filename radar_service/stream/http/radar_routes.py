"""REST: the radars, their controls, scenes, truth and pictures."""

import asyncio
from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query, Response

from radar_service.display.last_scan import last_scan_png
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene
from radar_service.stream.codecs.native import messages, wire
from radar_service.stream.codecs.registry import CODECS
from radar_service.stream.controls import control_definitions
from radar_service.stream.http import schemas
from radar_service.stream.http.answers import FORBIDDEN, REFUSED, UNKNOWN, UNREADABLE
from radar_service.stream.http.scene_routes import not_found
from radar_service.stream.http.scene_store import SceneStore
from radar_service.stream.radio.station import Station
from radar_service.stream.radio.status import state
from radar_service.stream.source import cell_layout

PICTURE: dict[int | str, dict[str, Any]] = {200: {"content": {"image/png": {}}, "description": "the picture"}}


def radar_routes(stations: Mapping[str, Station], store: SceneStore) -> APIRouter:
    """Returns the routes under /radars."""
    router = APIRouter(tags=["radars"])
    _add_read_routes(router, stations)
    _add_picture(router, stations)
    _add_changing(router, stations, store)
    return router


def _station(stations: Mapping[str, Station], radar: str) -> Station:
    if radar not in stations:
        raise HTTPException(404, [f'radar: there is no "{radar[:40]}"; there are {", ".join(stations)}'])
    return stations[radar]


def _add_read_routes(router: APIRouter, stations: Mapping[str, Station]) -> None:
    @router.get("/radars")
    async def list_radars() -> list[schemas.RadarState]:
        """Returns all radars of this server."""
        return [_radar_state(station) for station in stations.values()]

    @router.get("/radars/{radar}", responses=UNKNOWN)
    async def get_radar(radar: str) -> schemas.RadarState:
        """Returns one radar."""
        return _radar_state(_station(stations, radar))

    @router.get("/radars/{radar}/controls", responses=UNKNOWN)
    async def get_controls(radar: str) -> schemas.ControlsState:
        """Returns the state of all controls."""
        return schemas.ControlsState.model_validate(_station(stations, radar).controls())

    @router.get("/radars/{radar}/truth", responses={**UNKNOWN, **FORBIDDEN, **REFUSED})
    async def get_truth(
        radar: str, t: Annotated[float | None, Query(ge=0, le=1e9, allow_inf_nan=False, description="s, default now")] = None
    ) -> schemas.TruthState:
        """Returns the true state of own ship and of every body."""
        station = _station(stations, radar)
        if not station.allow_truth:
            raise HTTPException(403, ["truth: this server does not give it; start it with --truth"])
        state_at = await asyncio.to_thread(station.truth, t)
        return schemas.TruthState.model_validate(state_at.as_dict())


def _add_picture(router: APIRouter, stations: Mapping[str, Station]) -> None:
    @router.get("/radars/{radar}/ppi.png", response_class=Response, responses={**UNKNOWN, **REFUSED, **PICTURE})
    async def get_picture(
        radar: str,
        size: Annotated[int, Query(ge=64, le=2048, description="pixels")] = 900,
        range_m: Annotated[float | None, Query(ge=10, le=200_000, allow_inf_nan=False)] = None,
    ) -> Response:
        """Returns the last revolution as a picture, north up, with the radar's gain, sea and rain."""
        station = _station(stations, radar)
        engine, rows = station.last_scan.read()
        range_max = range_m or station.settings.range
        time, video = station.transmitter.simulated, station.settings.video
        to = cell_layout(engine, None, range_max)
        data = await asyncio.to_thread(
            last_scan_png, engine.scene, rows, to, video, engine.noise_power, size=size, range_max=range_max, time=time
        )
        return Response(data, media_type="image/png", headers={"Cache-Control": "no-store"})


def _add_changing(router: APIRouter, stations: Mapping[str, Station], store: SceneStore) -> None:
    @router.put("/radars/{radar}/scene", responses={**UNKNOWN, **REFUSED, **UNREADABLE})
    async def run_scene(radar: str, choice: schemas.SceneChoice) -> schemas.SceneAnswer:
        """Runs another scene: it is prepared beside the running one and takes over when the running scan ends."""
        station = _station(stations, radar)
        epoch, engine = await station.swap(await _chosen(store, choice.scene))
        return schemas.SceneAnswer(
            name=engine.scene.name, bodies=len(engine.scene.bodies), warnings=list(engine.scene.warnings), epoch=epoch,
            plan=engine.plan.as_dict(),
        )  # fmt: skip

    @router.patch("/radars/{radar}/controls", responses={**UNKNOWN, **REFUSED, **UNREADABLE})
    async def change_controls(radar: str, requested: schemas.ControlsChange) -> schemas.ControlsState:
        """Changes some controls; answers with the state of all."""
        station = _station(stations, radar)
        await station.change(requested.model_dump(exclude_none=True))
        return schemas.ControlsState.model_validate(station.controls())


async def _chosen(store: SceneStore, scene: str | dict[str, Any]) -> Scene:
    if isinstance(scene, str):
        with not_found("scene", scene):
            return await asyncio.to_thread(store.load, scene)
    return await asyncio.to_thread(load_scene, scene)


def _radar_state(station: Station) -> schemas.RadarState:
    engine = station.engine
    to = cell_layout(engine, None, None)
    return schemas.RadarState.model_validate(
        messages.radar_fields(station.identity, station.name, engine.scene.radar, to)
        | {
            "scene": messages.scene_fields(engine.scene),
            "seed": engine.seed,
            "fidelity": engine.fidelity.name,
            "plan": engine.plan.as_dict(),
            "controls": station.controls(),
            "control_definitions": control_definitions(engine.scene),
            "state": state(station),
            "epoch": station.hub.epoch,
            "feed": CODECS["native"].path.format(radar=station.identity),
            "encodings": list(wire.DTYPES),
        }
    )
