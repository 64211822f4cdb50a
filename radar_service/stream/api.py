"""The REST interface: scenes, radars, controls, truth, pictures, health."""

import asyncio
import contextlib
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import metadata
from pathlib import PurePosixPath
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query, Request, Response, WebSocket
from pydantic import ValidationError
from starlette.datastructures import UploadFile

from radar_service.scene.error import SceneError
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene
from radar_service.stream import feed, messages, picture, wire
from radar_service.stream import schemas as say
from radar_service.stream.access import TICKET_SECONDS, Access
from radar_service.stream.guard import RANK
from radar_service.stream.pace import Pace
from radar_service.stream.scenes import MAX_UPLOAD_FILES, SceneShelf, json_bytes
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings

REFUSED: dict[int | str, dict[str, Any]] = {422: {"model": say.Problem, "description": "refused; `detail` says why"}}
UNKNOWN: dict[int | str, dict[str, Any]] = {404: {"model": say.Problem, "description": "there is no such thing"}}
FORBIDDEN: dict[int | str, dict[str, Any]] = {403: {"model": say.Problem, "description": "this server does not give it"}}
CONFLICT: dict[int | str, dict[str, Any]] = {409: {"model": say.Problem, "description": "not as things stand"}}
UNREADABLE: dict[int | str, dict[str, Any]] = {
    400: {"model": say.Problem, "description": "the body cannot be read"},
    413: {"model": say.Problem, "description": "the body is too long"},
}
UPLOAD_BODY: dict[str, Any] = {
    "required": True,
    "content": {
        "application/json": {
            "schema": say.SceneUpload.model_json_schema(),
            "example": {"name": "one buoy", "scene": {"body": [{"name": "buoy", "shape": "sphere", "radius_m": 1,
                                                                "position_m": [500, 0, 2]}]}},
        },
        "multipart/form-data": {
            "schema": {
                "type": "object",
                "required": ["name", "scene"],
                "properties": {
                    "name": {"type": "string"},
                    "scene": {"type": "string", "format": "binary", "description": "a .toml or .json file"},
                    "files": {"type": "array", "items": {"type": "string", "format": "binary"},
                              "description": "meshes, height maps and tracks, named as the scene names them"},
                },
            }
        },
    },
}  # fmt: skip


GUARDED: dict[int | str, dict[str, Any]] = {
    401: {"model": say.Problem, "description": "a token is needed"},
    421: {"model": say.Problem, "description": "the server does not go by that name"},
}


def api(stations: Mapping[str, Station], shelf: SceneShelf, access: Access, refused: Callable[[str], None]) -> APIRouter:
    """All routes under /api."""
    router = APIRouter(prefix="/api", responses=GUARDED)
    _add_scenes(router, stations, shelf)
    _add_radars(router, stations)
    _add_feed(router, stations, access, refused)
    _add_control(router, stations, shelf)
    _add_health(router, stations)
    return router


def _add_health(router: APIRouter, stations: Mapping[str, Station]) -> None:
    @router.get("/health", responses={503: {"model": say.Health, "description": "a radar has failed or is starting again"}})
    async def health(response: Response) -> say.Health:
        """How the server and each radar do."""
        radars = [station.health() for station in stations.values()]
        states = {radar["state"] for radar in radars}
        status = next((bad for bad in ("failed", "restarting", "behind") if bad in states), "ok")
        response.status_code = 503 if status in ("failed", "restarting") else 200
        return say.Health.model_validate({"status": status, "version": metadata.version("radar-service"), "radars": radars})

    @router.get("/health/alive")
    async def alive() -> say.Yes:
        """Whether the server answers at all; needs no token."""
        return say.Yes(yes=True)

    @router.get("/health/ready", responses={503: {"model": say.Yes, "description": "not yet, or no more"}})
    async def ready(response: Response) -> say.Yes:
        """Whether every radar is on the air and takes clients; needs no token."""
        yes = all(station.ready for station in stations.values())
        response.status_code = 200 if yes else 503
        return say.Yes(yes=yes)


def _station(stations: Mapping[str, Station], radar: str) -> Station:
    if radar not in stations:
        raise HTTPException(404, [f'radar: there is no "{radar[:40]}"; there are {", ".join(stations)}'])
    return stations[radar]


def _add_scenes(router: APIRouter, stations: Mapping[str, Station], shelf: SceneShelf) -> None:
    @router.get("/scenes")
    async def scenes() -> list[say.SceneOffer]:
        """The scenes that can be run by name."""
        offers = await asyncio.to_thread(lambda: [offer.summary() for offer in shelf.offers()])
        return [say.SceneOffer.model_validate(offer) for offer in offers]

    @router.post(
        "/scenes", status_code=201, responses={**REFUSED, **CONFLICT, **UNREADABLE},
        openapi_extra={"requestBody": UPLOAD_BODY},
    )  # fmt: skip
    async def upload(request: Request) -> say.SceneAnswer:
        """Keep a scene on the list, checked and planned for the first radar; it replaces an earlier upload of its name."""
        name, scene, kind, files = await _upload(request)
        first, loop = next(iter(stations.values())), asyncio.get_running_loop()

        def planned(built: Scene) -> dict[str, Any]:
            return asyncio.run_coroutine_threadsafe(first.plan(built), loop).result()

        built, plan = await asyncio.to_thread(shelf.add, name, scene, kind, files, planned)
        return say.SceneAnswer(name=name, bodies=len(built.bodies), warnings=list(built.warnings), plan=plan)

    @router.delete("/scenes/{name}", status_code=204, responses={**UNKNOWN, **CONFLICT})
    async def remove(name: str) -> None:
        """Delete an uploaded scene; radars that run it go on."""
        with _known("scene", name):
            await asyncio.to_thread(shelf.remove, name)


def _add_radars(router: APIRouter, stations: Mapping[str, Station]) -> None:
    @router.get("/radars")
    async def radars() -> list[say.RadarState]:
        """All radars of this server."""
        return [_radar(station) for station in stations.values()]

    @router.get("/radars/{radar}", responses=UNKNOWN)
    async def one(radar: str) -> say.RadarState:
        """One radar."""
        return _radar(_station(stations, radar))

    @router.get("/radars/{radar}/controls", responses=UNKNOWN)
    async def controls(radar: str) -> say.ControlsState:
        """The controls as they stand."""
        return say.ControlsState.model_validate(_station(stations, radar).controls())

    @router.get("/radars/{radar}/truth", responses={**UNKNOWN, **FORBIDDEN, **REFUSED})
    async def truth(
        radar: str, t: Annotated[float | None, Query(ge=0, le=1e9, allow_inf_nan=False, description="s, default now")] = None
    ) -> say.TruthState:
        """The true state of own ship and every body."""
        station = _station(stations, radar)
        if not station.allow_truth:
            raise HTTPException(403, ["truth: this server does not give it; start it with --truth"])
        state = await asyncio.to_thread(station.truth, t)
        return say.TruthState.model_validate(state.as_dict())

    png: dict[int | str, dict[str, Any]] = {200: {"content": {"image/png": {}}, "description": "the picture"}}

    @router.get("/radars/{radar}/ppi.png", response_class=Response, responses={**UNKNOWN, **REFUSED, **png})
    async def ppi(
        radar: str,
        size: Annotated[int, Query(ge=64, le=2048, description="pixels")] = 900,
        range_m: Annotated[float | None, Query(ge=10, le=200_000, allow_inf_nan=False)] = None,
    ) -> Response:
        """The last revolution as a picture, north up, gain, sea and rain as they are set."""
        station = _station(stations, radar)
        engine, sweep = station.transmitter.sweep()
        reach = range_m or station.settings.range
        now, video = station.transmitter.simulated, station.settings.video
        data = await asyncio.to_thread(picture.ppi_png, engine, sweep, video, size, reach, now)
        return Response(data, media_type="image/png", headers={"Cache-Control": "no-store"})


def _add_feed(router: APIRouter, stations: Mapping[str, Station], access: Access, refused: Callable[[str], None]) -> None:
    @router.post("/tickets", status_code=201)
    async def ticket(request: Request) -> say.Ticket:
        """A word that opens one websocket, as its parameter `ticket`: for browsers, which send no token with it."""
        rank = request.scope.get(RANK)
        return say.Ticket(ticket=access.ticket(rank, time.monotonic), seconds=TICKET_SECONDS)

    @router.websocket("/radars/{radar}/feed")
    async def native_feed(socket: WebSocket, radar: str) -> None:
        await feed.serve(socket, stations.get(radar), access.may(socket.scope.get(RANK), "command"), refused)


def _add_control(router: APIRouter, stations: Mapping[str, Station], shelf: SceneShelf) -> None:
    @router.put("/radars/{radar}/scene", responses={**UNKNOWN, **REFUSED, **UNREADABLE})
    async def swap(radar: str, choice: say.SceneChoice) -> say.SceneAnswer:
        """Run another scene: prepared beside the running one, it takes over when the running scan ends."""
        station = _station(stations, radar)
        epoch, engine = await station.swap(await _chosen(shelf, choice.scene))
        return say.SceneAnswer(
            name=engine.scene.name, bodies=len(engine.scene.bodies), warnings=list(engine.scene.warnings), epoch=epoch,
            plan=engine.plan.as_dict(),
        )  # fmt: skip

    @router.patch("/radars/{radar}/controls", responses={**UNKNOWN, **REFUSED, **UNREADABLE})
    async def change(radar: str, wanted: say.ControlsChange) -> say.ControlsState:
        """Change some controls; answers with all of them."""
        station = _station(stations, radar)
        _check_range(station, wanted.range_m)
        if wanted.rpm is not None and not math.isclose(wanted.rpm, station.controls()["rpm"], rel_tol=1e-9):
            await station.turn(wanted.rpm)
        station.transmitter.set(changed(station.settings, wanted, station.engine.scene.radar.range_max))
        if wanted.pace and wanted.pace.state == "step":
            station.transmitter.step(wanted.pace.steps)
        return say.ControlsState.model_validate(station.controls())


def _check_range(station: Station, range_m: float | None) -> None:
    longest = station.engine.scene.radar.range_max
    if range_m is not None and range_m > longest:
        raise HTTPException(422, [f"range_m: {range_m:g}; this radar sees from 10 to {longest:g} m: give less"])


def changed(settings: Settings, wanted: say.ControlsChange, range_max: float) -> Settings:
    """The settings with what is wanted put in place of what was; steps and rpm are not settings."""
    video = {key: value for key in ("gain", "sea", "rain") if (value := getattr(wanted, key)) is not None}
    settings = replace(settings, video=replace(settings.video, **video))
    if wanted.transmit is not None:
        settings = replace(settings, transmit=wanted.transmit)
    if wanted.range_m is not None:
        settings = replace(settings, range=None if wanted.range_m == range_max else wanted.range_m)
    return replace(settings, pace=_changed_pace(settings.pace, wanted.pace)) if wanted.pace else settings


def _changed_pace(pace: Pace, wanted: say.PaceChange) -> Pace:
    if wanted.factor is not None:
        pace = replace(pace, factor=math.inf if wanted.factor == "max" else wanted.factor)
    return replace(pace, state=wanted.state) if wanted.state in ("run", "pause") else pace


def _radar(station: Station) -> say.RadarState:
    engine = station.engine
    to = messages.engine_layout(engine, None, None)
    return say.RadarState.model_validate(
        messages.radar_fields(station.identity, station.name, engine.scene.radar, to)
        | {
            "scene": messages.scene_fields(engine.scene),
            "seed": engine.seed,
            "fidelity": engine.fidelity.name,
            "plan": engine.plan.as_dict(),
            "controls": station.controls(),
            "state": station.state(),
            "epoch": station.hub.epoch,
            "feed": f"/api/radars/{station.identity}/feed",
            "encodings": list(wire.DTYPES),
        }
    )


async def _chosen(shelf: SceneShelf, scene: str | dict[str, Any]) -> Scene:
    if isinstance(scene, str):
        with _known("scene", scene):
            return await asyncio.to_thread(shelf.load, scene)
    return await asyncio.to_thread(load_scene, scene)


@contextlib.contextmanager
def _known(kind: str, name: str) -> Any:
    try:
        yield
    except KeyError:
        raise HTTPException(404, [f'{kind}: there is no "{name[:80]}"; see /api/{kind}s']) from None


async def _upload(request: Request) -> tuple[str, bytes, str, dict[str, bytes]]:
    kind = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if kind == "multipart/form-data":
        return await _multipart(request)
    if kind != "application/json":
        raise HTTPException(422, [f'content-type: "{kind[:60]}"; send application/json or multipart/form-data'])
    try:
        body = say.SceneUpload.model_validate(await request.json())
    except ValidationError as fault:
        raise HTTPException(422, problem_lines(fault.errors())) from None
    except (ValueError, RecursionError) as fault:
        raise HTTPException(400, [f"body: not JSON: {str(fault)[:200]}"]) from None
    return body.name, json_bytes(body.scene), ".json", {}


async def _multipart(request: Request) -> tuple[str, bytes, str, dict[str, bytes]]:
    async with request.form(max_files=MAX_UPLOAD_FILES + 1, max_fields=8) as form:
        scene, name = form.get("scene"), form.get("name")
        if not isinstance(scene, UploadFile) or not isinstance(name, str):
            raise SceneError("scene, name: send a scene file (.toml or .json) as `scene` and its name as `name`")
        files: dict[str, bytes] = {}
        for part in form.getlist("files"):
            if not isinstance(part, UploadFile) or not part.filename or part.filename in files:
                raise SceneError("files: each is a file with a name of its own")
            files[part.filename] = await part.read()
        return name, await scene.read(), PurePosixPath(scene.filename or "").suffix.lower(), files


def problem_lines(errors: Sequence[Any]) -> list[str]:
    """A line per fault of pydantic: the place, the value where it is short, what is wrong."""
    lines = []
    for error in errors[:20]:
        place = ".".join(str(step) for step in error["loc"] if step not in ("body", "query", "path")) or "body"
        value = repr(error.get("input"))
        shown = f" {value};" if len(value) <= 80 else ""
        lines.append(f"{place}:{shown} {error['msg']}")
    return lines
